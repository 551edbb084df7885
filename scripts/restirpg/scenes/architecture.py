"""Walls with openings, skirting boards, columns and arches; metres."""

import math

import numpy as np

from .shapes import Mesh, box, copies, join, lathe, room_quad, rounded_box, surface


def wall(corner, along, height, openings=()):
    """A vertical wall from `corner` `along` a horizontal vector; its front is where along x up points.

    `openings`: (left, right, bottom, top) in metres from the corner. The wall is a grid through their edges,
    without T-junctions, so that no light leaks. UVs in metres.
    """
    corner, along = np.asarray(corner, float), np.asarray(along, float)
    length = np.linalg.norm(along)
    direction = along / length
    xs = sorted({0.0, length, *(x for o in openings for x in o[:2])})
    ys = sorted({0.0, height, *(y for o in openings for y in o[2:])})
    panels = []
    for left, right in zip(xs[:-1], xs[1:]):
        for bottom, top in zip(ys[:-1], ys[1:]):
            if any(o[0] <= left and right <= o[1] and o[2] <= bottom and top <= o[3] for o in openings):
                continue
            panel = room_quad(corner + left * direction + (0, bottom, 0), (right - left) * direction,
                              (0, top - bottom, 0))
            panels.append(Mesh(panel.positions, panel.normals, panel.uvs + (left, -top), panel.triangles))
    return join(*panels)


def reveal(corner, along, opening, depth, sill=True):
    """The inner faces of a wall's opening, `depth` metres back from the wall's front."""
    corner, along = np.asarray(corner, float), np.asarray(along, float)
    direction = along / np.linalg.norm(along)
    back = -depth * np.cross(direction, (0.0, 1.0, 0.0))
    left, right, bottom, top = opening
    lower_left, lower_right = (corner + x * direction + (0, bottom, 0) for x in (left, right))
    up, across = np.array((0, top - bottom, 0)), (right - left) * direction
    faces = [room_quad(lower_left, back, up), room_quad(lower_right + back, -back, up),
             room_quad(lower_left + up, back, across)]
    if sill:
        faces.append(room_quad(lower_left, across, back))
    return join(*faces)


def skirting(start, end, height=0.1, thickness=0.018):
    """A board along a wall's foot from start to end (x, z); seen from above, the room is on the right."""
    (x0, z0), (x1, z1) = start, end
    length = math.hypot(x1 - x0, z1 - z0)
    board = rounded_box((0, 0, 0), (length, height, thickness), 0.006, 2)
    return board.turned("y", -math.degrees(math.atan2(z1 - z0, x1 - x0))).moved(x0, 0, z0)


def column(height, radius=0.2, flutes=16):
    """A fluted column with a square plinth, a round base and a capital, standing on y = 0."""
    base = lathe([(radius * 1.45, 0.10), (radius * 1.45, 0.15), (radius * 1.35, 0.18), (radius * 1.15, 0.20),
                  (radius * 1.25, 0.24), (radius * 1.2, 0.27), (radius * 1.02, 0.29)], 64, crease=60)
    capital = lathe([(radius * 0.86, height - 0.32), (radius * 0.98, height - 0.30),
                     (radius * 0.9, height - 0.26), (radius * 1.0, height - 0.22),
                     (radius * 1.35, height - 0.12)],
                    64,
                    crease=60)
    slabs = [
        rounded_box((-radius * 1.6, 0, -radius * 1.6), (radius * 1.6, 0.10, radius * 1.6), 0.008),
        rounded_box((-radius * 1.5, height - 0.12, -radius * 1.5), (radius * 1.5, height, radius * 1.5),
                    0.008)
    ]
    return join(base, capital, *slabs, _fluted_shaft(radius, 0.29, height - 0.31, flutes))


def _fluted_shaft(radius, bottom, top, flutes, sides=6, rings=12):
    """A tapering shaft with swelling (entasis); facets across the flutes are smooth."""
    def point(u, v):
        swelling = radius * (1 - 0.15 * v * np.abs(v) ** 0.6)
        r = swelling * (1 - 0.055 * np.abs(np.sin(math.pi * flutes * u)) ** 0.8)
        a = 2 * math.pi * u
        return np.stack([r * np.cos(a), bottom + (top - bottom) * v, -r * np.sin(a)], -1)

    return surface(point, flutes * sides, rings, wrap_u=True)


def arch(span, springing, top, depth, pier, segments=24):
    """A wall of faces z = +-depth/2 with a round-headed opening of x in [-span/2, span/2].

    The opening rises straight to `springing`, then as a half circle; the wall reaches `top`, and is `pier`
    wide beside it.
    """
    r, z = span / 2, depth / 2
    angles = np.linspace(math.pi, 0, segments + 1)
    curve = np.stack([r * np.cos(angles), springing + r * np.sin(angles)], -1)
    outline = np.concatenate([[(-r, 0.0)], curve, [(r, 0.0)]])
    ceiling = np.stack([curve[:, 0], np.full(segments + 1, top)], -1)
    faces = []
    for side in (1, -1):
        strip = np.concatenate([curve, ceiling])
        k = np.arange(segments)
        n = segments + 1
        triangles = np.concatenate([np.stack([k, k + 1, k + 1 + n], -1), np.stack([k, k + 1 + n, k + n], -1)])
        positions = np.column_stack([strip, np.full(len(strip), side * z)])
        faces.append(
            Mesh(positions, np.tile((0.0, 0.0, side), (len(strip), 1)), strip * (1, -1),
                 triangles[:, ::side]))
        for left, right in ((-r - pier, -r), (r, r + pier)):
            x0, x1 = (left, right) if side > 0 else (right, left)
            panel = [room_quad((x0, low, side * z), (x1 - x0, 0, 0), (0, high - low, 0))
                     for low, high in ((0.0, springing), (springing, top))]
            faces += panel
    tangent = np.gradient(outline, axis=0)
    tangent[[0, 1]], tangent[[-1, -2]] = (0, 1), (0, -1)
    normals = np.stack([tangent[:, 1], -tangent[:, 0]], -1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(outline, axis=0), axis=1))])
    count = len(outline)
    inside = Mesh(np.concatenate([np.column_stack([outline, np.full(count, s * z)]) for s in (1, -1)]),
                  np.tile(np.column_stack([normals, np.zeros(count)]), (2, 1)),
                  np.concatenate([np.column_stack([along, np.full(count, s * z)]) for s in (1, -1)]),
                  np.array([t for k in range(count - 1)
                            for t in ((k, k + count, k + 1), (k + 1, k + count, k + count + 1))]))
    return join(*faces, inside)


def steps(width, rise, tread, count):
    """A straight flight of stone steps going up towards -z from z = 0, centred on x = 0."""
    return join(*(rounded_box((-width / 2, k * rise, -count * tread), (width / 2,
                                                                       (k + 1) * rise, -k * tread), 0.01)
                  for k in range(count)))


def beams(size, offsets):
    """Copies of one squared beam (lower corner at the origin)."""
    return copies(rounded_box((0, 0, 0), size, 0.01), offsets)


def slab(lower, upper):
    """A sharp-edged block, for parts that meet others flush."""
    return box(lower, upper)
