"""Triangle meshes: boxes, lathes, tubes, spheres, sheets. Counter-clockwise from outside; metres."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Mesh:
    """An indexed triangle mesh."""

    positions: np.ndarray  # (N, 3)
    normals: np.ndarray  # (N, 3), unit
    uvs: np.ndarray  # (N, 2), v down
    triangles: np.ndarray  # (M, 3)

    def moved(self, x=0.0, y=0.0, z=0.0):
        """The mesh shifted."""
        return Mesh(self.positions + (x, y, z), self.normals, self.uvs, self.triangles)

    def scaled(self, x, y=None, z=None):
        """The mesh scaled about the origin by positive factors; one factor scales all axes."""
        factors = np.array((x, x if y is None else y, x if z is None else z), float)
        return Mesh(self.positions * factors, unit(self.normals / factors), self.uvs, self.triangles)

    def turned(self, axis, degrees):
        """The mesh turned about "x", "y" or "z"."""
        i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
        matrix = np.eye(3)
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        matrix[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
        return Mesh(self.positions @ matrix.T, self.normals @ matrix.T, self.uvs, self.triangles)

    def inverted(self):
        """The mesh seen from inside."""
        return Mesh(self.positions, -self.normals, self.uvs, self.triangles[:, ::-1])

    def with_uvs(self, scale_u, scale_v=None):
        """The mesh with its texture coordinates multiplied."""
        return Mesh(self.positions, self.normals, self.uvs * (scale_u, scale_v or scale_u), self.triangles)

    def faceted(self):
        """The mesh with a flat normal a triangle (vertices unshared)."""
        corners = self.positions[self.triangles]
        normals = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        return Mesh(corners.reshape(-1, 3), np.repeat(normals, 3, axis=0),
                    self.uvs[self.triangles].reshape(-1, 2),
                    np.arange(corners.shape[0] * 3).reshape(-1, 3))


def unit(vectors):
    """Vectors (..., 3) scaled to length 1."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def join(*meshes):
    """One mesh of several."""
    starts = np.cumsum([0] + [len(m.positions) for m in meshes])
    return Mesh(
        *(np.concatenate([getattr(m, part) for m in meshes]) for part in ("positions", "normals", "uvs")),
        np.concatenate([m.triangles + start for m, start in zip(meshes, starts)]))


def copies(mesh, offsets):
    """One mesh of copies shifted by each of `offsets`."""
    return join(*(mesh.moved(*offset) for offset in offsets))


def grid_triangles(rows, columns):
    """Triangles of a grid of rows x columns vertices whose front is where column step x row step points."""
    i = np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)
    corner = np.stack([i, i + 1, i + columns, i + columns + 1], -1).reshape(-1, 4)
    return corner[:, [0, 1, 3, 0, 3, 2]].reshape(-1, 3)


def drop_degenerate(mesh):
    """The mesh without triangles of zero area, such as a lathe leaves at its poles."""
    corners = mesh.positions[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return Mesh(mesh.positions, mesh.normals, mesh.uvs, mesh.triangles[area > 1e-12])


def quad(corner, edge_u, edge_v, divisions=(1, 1)):
    """A rectangle whose front is where edge_u x edge_v points. UVs: u along edge_u, v against edge_v."""
    edge_u, edge_v = np.asarray(edge_u, float), np.asarray(edge_v, float)
    columns, rows = divisions[0] + 1, divisions[1] + 1
    v, u = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, columns), indexing="ij")
    positions = np.asarray(corner, float) + u[..., None] * edge_u + v[..., None] * edge_v
    normal = unit(np.cross(edge_u, edge_v))
    return Mesh(positions.reshape(-1, 3), np.tile(normal, (rows * columns, 1)),
                np.stack([u, 1 - v], -1).reshape(-1, 2), grid_triangles(rows, columns))


def room_quad(corner, edge_u, edge_v, divisions=(1, 1)):
    """A quad with UVs in metres, for tiling textures."""
    return quad(corner, edge_u, edge_v, divisions).with_uvs(np.linalg.norm(edge_u), np.linalg.norm(edge_v))


def _box_faces(lower, upper):
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    x, y, z = np.diag(upper - lower)
    return [
        room_quad(corner, u, v)
        for corner, u, v in ((lower + x, -x, y), (lower + z, x, y), (lower, z, y), (upper - y, -z, y),
                             (lower + y + z, x, -z), (lower, x, z))
    ]


def box(lower, upper):
    """An axis-aligned box with sharp edges. UVs in metres."""
    return join(*_box_faces(lower, upper))


def rounded_box(lower, upper, radius=0.004, segments=1):
    """A box with rounded edges, which catch the light as real ones do. UVs in metres, projected a face.

    A point p of the sharp box goes to c + radius * unit(p - c), c being p clamped to the box shrunk by the
    radius.
    """
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    center, half = (lower + upper) / 2, (upper - lower) / 2
    radius = min(radius, *(half * 0.999))
    angles = np.tan(np.linspace(-math.pi / 4, 0, segments + 1)[:-1])  # equal angles over half the bend

    def steps(h):
        bend = h - radius - radius * angles[::-1]
        return np.concatenate([-bend[::-1], [radius - h, h - radius], bend])

    faces = []
    for axis in range(3):
        for sign in (-1, 1):
            a, b = (axis + 1) % 3, (axis + 2) % 3
            if sign < 0:
                a, b = b, a
            grid_b, grid_a = np.meshgrid(steps(half[b]), steps(half[a]), indexing="ij")
            p = np.empty((*grid_a.shape, 3))
            p[..., axis], p[..., a], p[..., b] = sign * half[axis], grid_a, grid_b
            inner = np.clip(p, radius - half, half - radius)
            normals = unit(p - inner)
            positions = (center + inner + radius * normals).reshape(-1, 3)
            horizontal, vertical = ((2, 1), (0, 2), (0, 1))[axis]
            uvs = np.stack([positions[:, horizontal], -positions[:, vertical]], -1)
            faces.append(Mesh(positions, normals.reshape(-1, 3), uvs, grid_triangles(*grid_a.shape)))
    return join(*faces)


def _profile_normals(profile, crease):
    """Split a profile (K, 2) at angles sharper than `crease` degrees: points, normals, arc lengths."""
    edges = np.diff(profile, axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    side = np.stack([edges[:, 1], -edges[:, 0]], -1) / lengths[:, None]
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    strips = []
    current = [(profile[0], side[0], along[0])]
    for k in range(1, len(profile) - 1):
        if side[k - 1] @ side[k] >= math.cos(math.radians(crease)):
            mean = side[k - 1] + side[k]
            current.append((profile[k], mean / np.linalg.norm(mean), along[k]))
        else:
            strips.append(current + [(profile[k], side[k - 1], along[k])])
            current = [(profile[k], side[k], along[k])]
    strips.append(current + [(profile[-1], side[-1], along[-1])])
    return [tuple(np.array(column) for column in zip(*strip)) for strip in strips]


def lathe(profile, segments=48, crease=40.0):
    """A surface of revolution about +y. `profile`: (radius, y) from bottom to top along the outside.

    Closed where the profile begins and ends at radius 0. Normals are smooth across angles under `crease`
    degrees.
    """
    profile = np.asarray(profile, float)
    angles = np.linspace(0, 2 * math.pi, segments + 1)
    cosine, sine = np.cos(angles), np.sin(angles)
    cosine[-1], sine[-1] = cosine[0], sine[0]  # the seam's two columns have the same positions
    strips = []
    for points, normals, along in _profile_normals(profile, crease):
        positions = np.stack([
            points[:, :1] * cosine,
            np.broadcast_to(points[:, 1:], (len(points), segments + 1)), -points[:, :1] * sine
        ], -1)
        directions = np.stack([normals[:, :1] * cosine, np.broadcast_to(normals[:, 1:], positions.shape[:2]),
                               -normals[:, :1] * sine], -1)
        circumference = 2 * math.pi * profile[:, 0].max()
        u, v = np.meshgrid(angles / (2 * math.pi) * circumference, -along)
        strips.append(
            Mesh(positions.reshape(-1, 3), directions.reshape(-1, 3),
                 np.stack([u, v], -1).reshape(-1, 2), grid_triangles(len(points), segments + 1)))
    return drop_degenerate(join(*strips))


def cylinder(radius, height, segments=32, bevel=0.0):
    """A closed cylinder standing on y = 0, its rims bevelled."""
    profile = [(0, 0), (radius, 0), (radius, height), (0, height)]
    if bevel:
        profile = [(0, 0), (radius - bevel, 0), (radius, bevel), (radius, height - bevel),
                   (radius - bevel, height), (0, height)]
    return lathe(profile, segments)


def sphere(radius, rings=24, segments=48):
    """A closed sphere about the origin (latitude and longitude)."""
    angles = np.linspace(-math.pi / 2, math.pi / 2, rings + 1)
    profile = np.stack([np.cos(angles), np.sin(angles)], -1) * radius
    profile[[0, -1], 0] = 0.0
    return lathe(profile, segments, crease=180.0)


def icosphere(radius, subdivisions):
    """A sphere of 20 * 4^subdivisions nearly equal triangles, with smooth normals."""
    g = (1 + math.sqrt(5)) / 2
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
              (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    points = [unit(np.array(p, float)) for p in points]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
             (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5),
             (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(subdivisions):
        middle = {}

        def between(a, b, middle=middle):
            key = (min(a, b), max(a, b))
            if key not in middle:
                points.append(unit(points[a] + points[b]))
                middle[key] = len(points) - 1
            return middle[key]

        faces = [t for a, b, c in faces for ab, bc, ca in [(between(a, b), between(b, c), between(c, a))]
                 for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))]
    normals = np.array(points)
    uvs = np.stack([0.5 + np.arctan2(normals[:, 0], -normals[:, 2]) / (2 * math.pi),
                    np.arccos(np.clip(normals[:, 1], -1, 1)) / math.pi], -1)
    return Mesh(normals * radius, normals, uvs, np.array(faces))


def surface(function, columns, rows, wrap_u=False, wrap_v=False):
    """A parametric sheet: function(u, v) -> (..., 3) over the unit square; its front is along dp/du x dp/dv.

    A wrapped direction is periodic: its last column repeats the first one exactly, which closes the sheet.
    """
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    positions = function(u, v)
    step = 1e-4
    normals = unit(
        np.cross(
            function(u + step, v) - function(u - step, v),
            function(u, v + step) - function(u, v - step)))
    if wrap_u:
        positions[:, -1], normals[:, -1] = positions[:, 0], normals[:, 0]
    if wrap_v:
        positions[-1], normals[-1] = positions[0], normals[0]
    return drop_degenerate(
        Mesh(positions.reshape(-1, 3), normals.reshape(-1, 3),
             np.stack([u, 1 - v], -1).reshape(-1, 2), grid_triangles(rows + 1, columns + 1)))


def tube(path, radius, sides=16):
    """A closed tube along points (K, 3), its ends capped. `radius`: a number, or one a point."""
    path = np.asarray(path, float)
    radii = np.broadcast_to(np.asarray(radius, float), len(path))
    tangents = unit(np.gradient(path, axis=0))
    frame = [np.cross(tangents[0], (0.0, 1.0, 0.0) if abs(tangents[0][1]) < 0.9 else (1.0, 0.0, 0.0))]
    for t in tangents[1:]:  # parallel transport keeps the tube from twisting
        frame.append(frame[-1] - t * (frame[-1] @ t))
    x = unit(np.array(frame))
    y = np.cross(tangents, x)
    angles = np.linspace(0, 2 * math.pi, sides + 1)
    cosine, sine = np.cos(angles), np.sin(angles)
    cosine[-1], sine[-1] = cosine[0], sine[0]
    normals = x[:, None] * cosine[:, None] + y[:, None] * sine[:, None]
    positions = path[:, None] + radii[:, None, None] * normals
    v, u = np.meshgrid(np.linspace(0, 1, len(path)), angles / (2 * math.pi), indexing="ij")
    side = Mesh(positions.reshape(-1, 3), normals.reshape(-1, 3), np.stack([u, v], -1).reshape(-1, 2),
                grid_triangles(len(path), sides + 1))
    ends = [_disc(path[0], -tangents[0], positions[0, ::-1]), _disc(path[-1], tangents[-1], positions[-1])]
    return join(side, *ends)


def _disc(center, normal, rim):
    """A fan that closes a rim (K, 3), counter-clockwise about the normal, whose ends coincide."""
    count = len(rim)
    return Mesh(np.concatenate([[center], rim]), np.tile(normal, (count + 1, 1)),
                np.full((count + 1, 2), 0.5),
                np.array([(0, k, k + 1) for k in range(1, count)]))


def bezier(points, count):
    """`count` points on the Bezier curve of the control points (de Casteljau)."""
    t = np.linspace(0, 1, count)[:, None, None]
    level = np.broadcast_to(np.asarray(points, float), (count, len(points), len(points[0])))
    while level.shape[1] > 1:
        level = level[:, :-1] * (1 - t) + level[:, 1:] * t
    return level[:, 0]
