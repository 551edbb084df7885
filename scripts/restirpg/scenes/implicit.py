"""Closed meshes from implicit functions: blended shapes that no lathe makes, watertight by construction."""

import numpy as np

from .shapes import Mesh, unit


def smooth_union(a, b, width):
    """Polynomial smooth minimum (Quilez): rounds the seam of two distance fields over `width` metres."""
    h = np.clip(0.5 + 0.5 * (b - a) / width, 0.0, 1.0)
    return b * (1 - h) + a * h - width * h * (1 - h)


def capsule_chain(points, path, radii):
    """Distance from points (..., 3) to a tapered tube along path (K, 3) with one radius a path point."""
    best = np.full(points.shape[:-1], np.inf)
    for a, b, ra, rb in zip(path[:-1], path[1:], radii[:-1], radii[1:]):
        axis = b - a
        t = np.clip((points - a) @ axis / (axis @ axis), 0.0, 1.0)
        best = np.minimum(best,
                          np.linalg.norm(points - a - t[..., None] * axis, axis=-1) - (ra + t * (rb - ra)))
    return best


def revolved(points, profile):
    """Signed distance from points (..., 3) to the solid that an outline of (radius, y) sweeps about +y."""
    q = np.stack([np.hypot(points[..., 0], points[..., 2]), points[..., 1]], -1)
    distance = np.full(q.shape[:-1], np.inf)
    inside = np.zeros(q.shape[:-1], bool)
    for a, b in zip(profile, np.roll(profile, -1, axis=0)):
        edge = b - a
        t = np.clip((q - a) @ edge / (edge @ edge), 0.0, 1.0)
        if max(a[0], b[0]) > 0:  # the axis itself is no boundary
            distance = np.minimum(distance, np.linalg.norm(q - a - t[..., None] * edge, axis=-1))
        crosses = (a[1] > q[..., 1]) != (b[1] > q[..., 1])
        x = a[0] + (q[..., 1] - a[1]) * edge[0] / np.where(edge[1] == 0, 1.0, edge[1])
        inside ^= crosses & (q[..., 0] < x)
    return np.where(inside, -distance, distance)


def gradient(field, points, step):
    """Central differences of a scalar field at points (N, 3)."""
    columns = []
    for axis in np.eye(3) * step:
        columns.append((field(points + axis) - field(points - axis)) / (2 * step))
    return np.stack(columns, -1)


def mesh_isosurface(field, lower, upper, cell):
    """Closed triangle mesh of field = 0 (negative inside), which must lie within the box lower..upper.

    Surface nets (Gibson 1998): a vertex a cell that the surface crosses, a quad across each crossed edge;
    then two Newton steps along the gradient put the vertices on the surface. `cell`: edge length
    in metres; a grid plane that grazes a flat part of the surface leaves slivers, so pick one that does not.
    """
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    axes = [low + cell * np.arange(int(np.ceil((high - low) / cell)) + 1) for low, high in zip(lower, upper)]
    values = field(np.stack(np.meshgrid(*axes, indexing="ij"), -1))
    active, positions = _cell_centroids(values)
    index = np.full(np.array(values.shape) - 1, -1)
    index[tuple(active.T)] = np.arange(len(active))
    positions = lower + positions * cell
    for _ in range(2):
        slope = gradient(field, positions, cell * 0.1)
        move = field(positions)[:, None] * slope / np.maximum((slope * slope).sum(1, keepdims=True), 1e-6)
        length = np.linalg.norm(move, axis=1, keepdims=True)
        positions -= move * np.minimum(
            1.0, 0.2 * cell / np.maximum(length, 1e-12))  # longer ones would fold the sheet
    normals = unit(gradient(field, positions, cell * 0.1))
    triangles = np.concatenate([_quads(values < 0, index, positions, axis) for axis in range(3)])
    uvs = positions[:, :2] * (1, -1)
    return Mesh(positions, normals, uvs, triangles)


def _cell_centroids(values):
    """Indices (N, 3) of the cells that the surface crosses, and the mean crossing of each cell's edges."""
    shape = np.array(values.shape) - 1
    total, count = np.zeros((*shape, 3)), np.zeros(shape)
    for axis in range(3):
        tail = np.take(values, range(shape[axis]), axis)
        head = np.take(values, range(1, shape[axis] + 1), axis)
        crossed = (tail < 0) != (head < 0)
        at = np.argwhere(crossed)
        point = at.astype(float)
        point[:, axis] += tail[crossed] / (tail[crossed] - head[crossed])
        for offset in np.ndindex(2, 2):  # an edge belongs to four cells
            cells = at.copy()
            cells[:, [(axis + 1) % 3, (axis + 2) % 3]] -= offset
            valid = ((cells >= 0) & (cells < shape)).all(axis=1)
            where = tuple(cells[valid].T)
            np.add.at(total, where, point[valid])
            np.add.at(count, where, 1)
    active = np.argwhere(count > 0)
    return active, total[count > 0] / count[count > 0][:, None]


def _quads(inside, index, positions, axis):
    """Two triangles across every grid edge along `axis` whose ends lie on different sides of the surface."""
    a, b = (axis + 1) % 3, (axis + 2) % 3
    head = [slice(None)] * 3
    tail = [slice(None)] * 3
    tail[axis], head[axis] = slice(None, -1), slice(1, None)
    crossed = np.argwhere(inside[tuple(tail)] != inside[tuple(head)])
    crossed = crossed[(crossed[:, a] > 0) & (crossed[:, b] > 0)]
    leaving = inside[tuple(crossed.T)]

    def cell(da, db):
        at = crossed.copy()
        at[:, a] -= da
        at[:, b] -= db
        return index[tuple(at.T)]

    quads = np.stack([cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)], -1)
    quads[~leaving] = quads[~leaving][:, ::-1]
    diagonal = [np.linalg.norm(positions[quads[:, i]] - positions[quads[:, i + 2]], axis=1) for i in (0, 1)]
    split = np.where((diagonal[0] <= diagonal[1])[:, None], quads[:, [0, 1, 2, 0, 2, 3]],
                     quads[:, [1, 2, 3, 1, 3, 0]])
    return split.reshape(-1, 3)
