"""The guiding grid in NumPy and double precision: keys, E-step and M-step, written from the equations of
framework/shaders/README.md on what restirpg.harness.guiding reads, without a line of the kernels.

Tables are dictionaries from key to record; how the GPU's hash table places them is checked by
`slots_are_reachable`.
"""

from dataclasses import dataclass, field

import numpy as np

from restirpg.harness.guiding import (  # noqa: F401
    CELL,
    DISTANCES,
    FINAL,
    HEADER,
    LEARNS_ALPHA,
    LIGHT_SAMPLED,
    LOBES,
    MEMORY,
    SAMPLE,
    SUMS,
    VERTEX,
    Grid,
    Mixture,
    alpha_of,
    face_of,
    grid_of,
    is_valid,
    material_of,
    mixture_of,
    read_table,
    unpack_direction,
    vertex_density,
    vertex_face,
    vertex_scatter,
)

PROBES = 32
ONE = 2.0**22  # of the fixed-point sums
LARGEST_WEIGHT = 2.0**22
NEW_ALPHA = 0.5  # of a cell that has learnt nothing
SHORTEST_DISTANCE = 1e-3  # m, of what inverse distances are summed of


def pcg4d(*words):
    """The hash of four words, or arrays of them, four words.  [Jarzynski & Olano 2020]"""
    v = [np.asarray(c, np.uint32) * np.uint32(1664525) + np.uint32(1013904223) for c in words]
    for last in (False, True):
        for to, a, b in ((0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)):
            v[to] = v[to] + v[a] * v[b]
        v = v if last else [c ^ (c >> np.uint32(16)) for c in v]
    return v


def unit_floats(words):
    """As random numbers in [0, 1)."""
    return [(word >> np.uint32(8)) / 2.0**24 for word in words]


def slots_are_reachable(keys):
    """Does a probe that begins at each key's own slot find it before an empty slot, within PROBES?"""
    capacity, taken = len(keys), np.flatnonzero(keys)
    words = keys[taken]
    halves = (words & np.uint64(0xFFFFFFFF)).astype(np.uint32), (words >> np.uint64(32)).astype(np.uint32)
    hashes = pcg4d(*halves, np.zeros_like(halves[0]), np.zeros_like(halves[0]))[0]
    home = (hashes ^ hashes >> np.uint32(16)) % capacity
    steps = (taken - home) % capacity
    return all(
        step < PROBES and np.all(keys[(start + np.arange(step)) % capacity] != 0)
        for start, step in zip(home.astype(int), steps.astype(int))
    )


def face_normals(face):
    normal = np.zeros((len(face), 3))
    normal[np.arange(len(face)), face >> 1] = np.where(face & 1, -1.0, 1.0)
    return normal


def new_mixture(normal):
    """Fibonacci set over the hemisphere of a face, kappa 3, equal weights.  [shaders/README: The MAP fit] [frame: Duff
    et al. 2017]"""
    k = np.arange(LOBES)
    z, phi = 1 - (k + 0.5) / LOBES, np.pi * (3 - np.sqrt(5)) * k
    r = np.sqrt(1 - z * z)
    x, y, up = normal
    s = 1.0 if up >= 0 else -1.0
    a = -1 / (s + up)
    frame = np.array([[1 + s * x * x * a, s * x * y * a, -s * x], [x * y * a, s + y * y * a, -y], normal])
    return Mixture(
        np.stack([r * np.cos(phi), r * np.sin(phi), z], -1) @ frame, np.full(LOBES, 3.0), np.full(LOBES, 0.25)
    )


def previous_key(key, grid, before, cells):
    """The key under which the frame before served a cell, or None; and whether rounding decides.  `before`:
    its grid."""
    if before is None:
        return None, False
    if key in cells and before.same_places(grid):
        return key, False
    other, doubtful = before.keys(grid.center(key)[None], np.array([face_of(key)]), np.array([material_of(key)]))
    return (int(other[0]) if int(other[0]) in cells else None), bool(doubtful[0])


@dataclass
class CellSums:
    """E-step of a cell. `sums` (4, 4): x, y, z, 1 a lobe; `bsdf`: of the BSDF's responsibilities; `inverse`
    (4,): of responsibilities over distance, 1/m; `nearest`: the least distance, m; `weight`: of all samples;
    `doubtful`: not to be compared."""

    sums: np.ndarray = field(default_factory=lambda: np.zeros((LOBES, 4)))
    bsdf: float = 0.0
    inverse: np.ndarray = field(default_factory=lambda: np.zeros(LOBES))
    nearest: float = np.inf
    count: int = 0
    weight: float = 0.0
    worst: float = np.inf  # log density
    directions: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    doubtful: bool = False


def e_step(samples, grid, before, cells, learns_alpha, parallax):
    """{key: CellSums} of a frame's samples (SAMPLE), against the guide of the frame before: its grid and
    {key: (CELL, ...)}. `learns_alpha`: the BSDF is a component, too.  [shaders/README: Where alpha comes from]
    `parallax`: directions are those in which the middle of the cell sees what the samples see."""
    used = samples[is_valid(samples) & (samples["weight"] > 0)]
    points = grid.positions(used["position"])
    keys, doubtful = grid.keys(points, vertex_face(used), used["surface"] & 0xFFFF)
    w = unpack_direction(used["direction"])
    weights = np.minimum(used["weight"].astype(float), LARGEST_WEIGHT)
    distance = used["distance"].astype(float)
    if parallax:
        target = points + np.maximum(distance, SHORTEST_DISTANCE)[:, None] * w
        seen = target - np.array([grid.center(key) for key in keys.tolist()])
        length = np.linalg.norm(seen, axis=-1)
        w = seen / length[:, None]
        distance = length
    inverse = 1 / np.maximum(distance, SHORTEST_DISTANCE)
    result, doubts = {}, set(keys[doubtful].tolist())
    for key in map(int, np.unique(keys)):
        mine = np.flatnonzero(keys == key)
        found, unsure = previous_key(key, grid, before, cells)
        mixture = mixture_of(cells[found][0]) if found else new_mixture(face_normals(np.array([face_of(key)]))[0])
        by_bsdf = np.zeros(len(mine))
        if learns_alpha:
            alpha = alpha_of(cells[found][0]) if found else NEW_ALPHA
            densities = vertex_density(used[mine]), np.exp(mixture.log_density(w[mine]))
            by_bsdf = alpha * densities[0] / (alpha * densities[0] + (1 - alpha) * densities[1])
        share = mixture.shares(w[mine]) * (weights[mine] * (1 - by_bsdf))[:, None]
        result[key] = CellSums(
            share.T @ np.c_[w[mine], np.ones(len(mine))],
            by_bsdf @ weights[mine],
            share.T @ inverse[mine],
            1 / inverse[mine].max(),
            len(mine),
            weights[mine].sum(),
            mixture.log_density(w[mine]).min(),
            w[mine],
            unsure or key in doubts,
        )
    return result
