"""The guiding grid in NumPy and double precision: keys, E-step and M-step, written from ALGORITHMS' equations and from the layout
in framework/shaders/*_types.h, without a line of the kernels.

Tables are dictionaries from key to record; how the GPU's hash table places them is checked by `slots_are_reachable`.
"""

from dataclasses import dataclass, field

import numpy as np

VERTEX = np.dtype([("position", "<u8"), ("direction", "<u4"), ("surface", "<u4")])
SAMPLE = np.dtype([("position", "<u8"), ("direction", "<u4"), ("surface", "<u4"), ("weight", "<f4"), ("distance", "<f4")])
HEADER = np.dtype([("camera", "<f4", 3), ("scale", "<f4"), ("origin", "<f4", 3), ("smallest", "<f4"), ("capacity", "<u4"),
                   ("options", "<u4"), ("cells", "<u4"), ("collisions", "<u4"), ("failed", "<u4"), ("samples", "<u4"),
                   ("fitted", "<u4"), ("guiding", "<u4"), ("unused", "<u4", 4)])
SUMS = np.dtype([("lanes", "<i8", 16), ("strangest", "<u8"), ("count", "<u4"), ("unused", "<u4")])
PLACES = np.dtype([("lanes", "<i8", 7)])
CELL = np.dtype([("lobes", [("direction", "<u4"), ("kappa", "<f4"), ("weight", "<f4")], 4), ("age", "<u4"), ("samples", "<f4")])
MEMORY = np.dtype([("sums", "<f4", 16), ("count", "<f4"), ("places", "<f4", 7)])

LOBES = 4
PROBES = 32
ONE = 2.0 ** 24  # of the fixed-point sums
LARGEST_WEIGHT = 65536.0
SHORTEST_DISTANCE = 1e-3  # m, of what inverse distances are summed of
VALID, FINAL, LIGHT_SAMPLED = 1 << 19, 1 << 20, 1 << 21


def read_table(raw, *records):
    """Header and {key: one record of each kind} of a buffer of the guiding grid's form."""
    header = raw[:HEADER.itemsize].view(HEADER)[0]
    capacity, at = int(header["capacity"]), HEADER.itemsize
    columns = []
    for dtype in (np.dtype("<u8"), *records):
        columns.append(raw[at:at + capacity * dtype.itemsize].view(dtype))
        at += capacity * dtype.itemsize
    assert at == len(raw), "the buffer holds other records than these"
    slots = np.flatnonzero(columns[0])
    table = {int(columns[0][s]): tuple(column[s] for column in columns[1:]) for s in slots}
    assert len(table) == len(slots), "a key stands in two slots"
    return header, table, columns[0]


def pcg4d(x, y):
    """First word of the hash of (x, y, 0, 0).  [Jarzynski & Olano 2020]"""
    v = [np.asarray(c, np.uint32) * np.uint32(1664525) + np.uint32(1013904223) for c in (x, y, np.zeros_like(x), np.zeros_like(x))]
    for last in (False, True):
        for to, a, b in ((0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)):
            v[to] = v[to] + v[a] * v[b]
        v = v if last else [c ^ (c >> np.uint32(16)) for c in v]
    return v[0]


def slots_are_reachable(keys):
    """Does a probe that begins at each key's own slot find it before an empty slot, within PROBES?"""
    capacity, taken = len(keys), np.flatnonzero(keys)
    words = keys[taken]
    hashes = pcg4d((words & np.uint64(0xffffffff)).astype(np.uint32), (words >> np.uint64(32)).astype(np.uint32))
    home = (hashes ^ hashes >> np.uint32(16)) % capacity
    steps = (taken - home) % capacity
    return all(step < PROBES and np.all(keys[(start + np.arange(step)) % capacity] != 0)
               for start, step in zip(home.astype(int), steps.astype(int)))


def unpack_direction(bits):
    """Unit vectors (..., 3) of packed octahedral directions."""
    bits = np.asarray(bits, np.uint32)
    halves = np.stack([bits & 0xffff, bits >> 16], -1).astype(np.uint16).view(np.int16)
    p = np.maximum(halves / 32767.0, -1.0)
    z = 1 - np.abs(p).sum(-1)
    folded = (1 - np.abs(p[..., ::-1])) * np.where(p >= 0, 1, -1)
    w = np.concatenate([np.where((z < 0)[..., None], folded, p), z[..., None]], -1)
    return w / np.linalg.norm(w, axis=-1, keepdims=True)


def face_normals(face):
    normal = np.zeros((len(face), 3))
    normal[np.arange(len(face)), face >> 1] = np.where(face & 1, -1.0, 1.0)
    return normal


@dataclass
class Grid:
    """Keys of a frame: `camera` (3,), `scale`: largest side over distance, `origin` (3,), `smallest` side, m."""
    camera: np.ndarray
    scale: float
    origin: np.ndarray
    smallest: float

    @property
    def radius(self):
        """Of the scene, m: the grid's cube has 4 of it, from `origin` on."""
        return self.smallest / 1e-3

    def positions(self, packed):
        """Points (n, 3) of positions of 3 x 21 bits."""
        packed = np.asarray(packed, np.uint64)
        q = np.stack([packed >> np.uint64(21 * axis) & np.uint64(0x1fffff) for axis in range(3)], -1).astype(float)
        return self.origin + (q + 0.5) / 2 ** 21 * 4 * self.radius

    def keys(self, points, face, material):
        """Keys (n,) and whether rounding may make the GPU see another cell: within 1e-6 radii of a border, or 1e-5 of a level."""
        exact = np.log2(self.scale * np.linalg.norm(points - self.camera, axis=-1) / self.smallest)
        level = np.clip(np.floor(exact), 0, 31).astype(int)
        place = np.maximum((points - self.origin) / self.side(level)[:, None], 0)
        index = place.astype(np.uint64) & np.uint64(0x1fff)
        key = index[:, 0] | index[:, 1] << np.uint64(13) | index[:, 2] << np.uint64(26)
        for value, shift in ((level, 39), (face, 44), (material & 0xffff, 47)):
            key = key | np.asarray(value).astype(np.uint64) << np.uint64(shift)
        near = np.abs(place - np.round(place)) * self.side(level)[:, None] < 1e-6 * self.radius
        return key | np.uint64(1 << 63), near.any(-1) | (np.abs(exact - np.round(exact)) < 1e-5)

    def side(self, level):
        return self.smallest * 2.0 ** np.asarray(level)

    def center(self, key):
        index = np.array([key >> shift & 0x1fff for shift in (0, 13, 26)])
        return self.origin + (index + 0.5) * self.side(level_of(key))


def level_of(key):
    return key >> 39 & 31


def face_of(key):
    return key >> 44 & 7


def material_of(key):
    return key >> 47 & 0xffff


def grid_of(header):
    return Grid(header["camera"].astype(float), float(header["scale"]), header["origin"].astype(float), float(header["smallest"]))


@dataclass
class Mixture:
    """Lobes: `mu` (4, 3), `kappa` (4,), `weight` (4,)."""
    mu: np.ndarray
    kappa: np.ndarray
    weight: np.ndarray

    def log_lobes(self, w):
        """log(pi_k v_k(w)), (n, 4).  [ALGORITHMS 2.1]"""
        k = np.maximum(self.kappa, 1e-12)
        normalization = np.log(k / (2 * np.pi * -np.expm1(-2 * k)))
        distance = ((w[:, None] - self.mu) ** 2).sum(-1)
        return np.log(np.maximum(self.weight, 1e-30)) + normalization - 0.5 * self.kappa * distance

    def log_density(self, w):
        return np.logaddexp.reduce(self.log_lobes(w), -1)

    def shares(self, w):
        """Responsibilities, (n, 4).  [ALGORITHMS 3.1]"""
        return np.exp(self.log_lobes(w) - self.log_density(w)[:, None])


def new_mixture(normal):
    """Fibonacci set over the hemisphere of a face, kappa 3, equal weights.  [ALGORITHMS 3.4; frame: Duff et al. 2017]"""
    k = np.arange(LOBES)
    z, phi = 1 - (k + 0.5) / LOBES, np.pi * (3 - np.sqrt(5)) * k
    r = np.sqrt(1 - z * z)
    x, y, up = normal
    s = 1.0 if up >= 0 else -1.0
    a = -1 / (s + up)
    frame = np.array([[1 + s * x * x * a, s * x * y * a, -s * x], [x * y * a, s + y * y * a, -y], normal])
    return Mixture(np.stack([r * np.cos(phi), r * np.sin(phi), z], -1) @ frame, np.full(LOBES, 3.0), np.full(LOBES, 0.25))


def mixture_of(cell):
    lobes = cell["lobes"]
    return Mixture(unpack_direction(lobes["direction"]), lobes["kappa"].astype(float), lobes["weight"].astype(float))


def previous_key(key, grid, before, cells):
    """The key under which the frame before served a cell, or None; and whether rounding decides.  `before`: its grid."""
    if before is None:
        return None, False
    if key in cells:
        return key, False
    other, doubtful = before.keys(grid.center(key)[None], np.array([face_of(key)]), np.array([material_of(key)]))
    return (int(other[0]) if int(other[0]) in cells else None), bool(doubtful[0])


@dataclass
class CellSums:
    """E-step of a cell. `sums` (4, 4): x, y, z, 1 a lobe; `places` (7,); `weight`: of all samples; `doubtful`: not to be compared."""
    sums: np.ndarray = field(default_factory=lambda: np.zeros((LOBES, 4)))
    places: np.ndarray = field(default_factory=lambda: np.zeros(7))
    count: int = 0
    weight: float = 0.0
    worst: float = np.inf  # log density
    directions: list = field(default_factory=list)
    doubtful: bool = False


def e_step(samples, grid, before, cells):
    """{key: CellSums} of a frame's samples (SAMPLE), against the guide of the frame before: its grid and {key: (CELL, ...)}."""
    used = samples[(samples["surface"] & VALID != 0) & (samples["weight"] > 0)]
    points = grid.positions(used["position"])
    keys, doubtful = grid.keys(points, used["surface"] >> 16 & 7, used["surface"] & 0xffff)
    w = unpack_direction(used["direction"])
    weights = np.minimum(used["weight"].astype(float), LARGEST_WEIGHT)
    inverse = 1 / np.maximum(used["distance"].astype(float), SHORTEST_DISTANCE)
    result, doubts = {}, set(keys[doubtful].tolist())
    for key in map(int, np.unique(keys)):
        mine = np.flatnonzero(keys == key)
        found, unsure = previous_key(key, grid, before, cells)
        mixture = mixture_of(cells[found][0]) if found else new_mixture(face_normals(np.array([face_of(key)]))[0])
        share = mixture.shares(w[mine]) * weights[mine, None]
        place = (points[mine] - grid.center(key)) / grid.side(level_of(key))
        result[key] = CellSums(share.T @ np.c_[w[mine], np.ones(len(mine))],
                               np.r_[share.T @ inverse[mine], weights[mine] @ place], len(mine), weights[mine].sum(),
                               mixture.log_density(w[mine]).min(), used["direction"][mine].tolist(), unsure or key in doubts)
    return result
