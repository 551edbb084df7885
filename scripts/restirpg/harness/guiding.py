"""What is in the guiding grid's buffers (framework/shaders/guide/guiding_grid_types.h, path_vertex_types.h), for
scripts and tests to read.

Tables are dictionaries from key to records. Positions and lengths in m, densities in 1/sr.
"""

from dataclasses import dataclass

import numpy as np

from restirpg.harness import UserError
from restirpg.records import constant, fields_of, record

VERTEX = record("PathVertex", position="<u8")
SAMPLE = record("GuidingSample", vertex=fields_of(VERTEX))
HEADER = record("GuidingHeader", grid=fields_of(record("GuidingGrid")))
SUMS = record("GuidingSums", lanes="<i8", bsdf="<i8")
DISTANCES = record("GuidingDistanceSums", lanes="<i8")
CELL = record("GuidingCell", state=[("age", "<u2"), ("alpha", "<u2")])  # alpha in 65535ths
MEMORY = record("GuidingMemory")
CHAIN_CELL, CHAIN_HEADER = record("ChainCell"), record("ChainHeader")

# Of a vertex's `position`, whose second word is its upper half.
POSITION_BITS, POSITION_EXTENT = constant("POSITION_BITS"), constant("POSITION_EXTENT")
NORMAL_SHIFT, VALID = 32 + constant("VERTEX_FACE_SHIFT"), constant("VERTEX_VALID") << 32
# Of its `surface`.
FINAL, LIGHT_SAMPLED = constant("VERTEX_FINAL"), constant("VERTEX_LIGHT_SAMPLED")
MATERIAL_MASK, LOGARITHM_MASK = constant("VERTEX_MATERIAL_MASK"), (1 << constant("VERTEX_LOGARITHM_BITS")) - 1
DENSITY_SHIFT, SCATTER_SHIFT = constant("VERTEX_DENSITY_SHIFT"), constant("VERTEX_SCATTER_SHIFT")
# Of a key.
INDEX_BITS, LEVEL_SHIFT = constant("GUIDING_INDEX_BITS"), constant("GUIDING_LEVEL_SHIFT")
FACE_SHIFT, MATERIAL_SHIFT = constant("GUIDING_FACE_SHIFT"), constant("GUIDING_MATERIAL_SHIFT")
LEARNS_ALPHA = constant("GUIDING_ALPHA")  # of a header's `options`
LOBES = constant("GUIDING_LOBES")


def chain_header_of(raw):
    """The header of GuidingChain's guide."""
    return raw[: CHAIN_HEADER.itemsize].view(CHAIN_HEADER)[0]


def header_of(raw):
    """The header of a buffer of the guiding grid's form."""
    return raw[: HEADER.itemsize].view(HEADER)[0]


def read_table(raw, *records):
    """Header and {key: one record of each kind} of a buffer of the guiding grid's form."""
    header = header_of(raw)
    capacity, at = int(header["capacity"]), constant("GUIDING_HEADER_BYTES")
    columns = []
    for dtype in (np.dtype("<u8"), *records):
        columns.append(raw[at : at + capacity * dtype.itemsize].view(dtype))
        at += capacity * dtype.itemsize
    assert at == len(raw), "the buffer holds other records than these"
    slots = np.flatnonzero(columns[0])
    table = {int(columns[0][s]): tuple(column[s] for column in columns[1:]) for s in slots}
    assert len(table) == len(slots), "a key stands in two slots"
    return header, table, columns[0]


def is_valid(vertices):
    """Which of VERTEX or SAMPLE records hold a bounce."""
    return vertices["position"] & np.uint64(VALID) != 0


def vertex_face(vertices):
    """Face of the normal, 0 to 5: 2 axis + (1 when negative)."""
    return (vertices["position"] >> np.uint64(NORMAL_SHIFT) & np.uint64(7)).astype(int)


def _unpack_logarithm(bits):
    return 2.0 ** (((bits & LOGARITHM_MASK).astype(float) - 64) / 4)


def vertex_density(vertices):
    """The BSDF's own density of the direction, 1/sr."""
    return _unpack_logarithm(vertices["surface"] >> DENSITY_SHIFT)


def vertex_scatter(vertices):
    """Luminance of f |cos|."""
    return _unpack_logarithm(vertices["surface"] >> SCATTER_SHIFT)


def unpack_direction(bits):
    """Unit vectors (..., 3) of packed octahedral directions."""
    bits = np.asarray(bits, np.uint32)
    halves = np.stack([bits & 0xFFFF, bits >> 16], -1).astype(np.uint16).view(np.int16)
    p = np.maximum(halves / 32767.0, -1.0)
    z = 1 - np.abs(p).sum(-1)
    folded = (1 - np.abs(p[..., ::-1])) * np.where(p >= 0, 1, -1)
    w = np.concatenate([np.where((z < 0)[..., None], folded, p), z[..., None]], -1)
    return w / np.linalg.norm(w, axis=-1, keepdims=True)


def read_guide(raw):
    """Header and {key: CELL} of GuidingFit's guide, whether or not its cells remember samples."""
    header = header_of(raw)
    cells_end = constant("GUIDING_HEADER_BYTES") + int(header["capacity"]) * (8 + CELL.itemsize)
    table = read_table(raw, *([CELL, MEMORY] if len(raw) > cells_end else [CELL]))[1]
    return header, {key: cells[0] for key, cells in table.items()}


@dataclass
class Grid:
    """Keys of a frame: `camera` (3,), `scale`: largest side over distance, `origin` (3,), `smallest` side, m,
    `radius` of the scene, m: packed positions lie in a cube of POSITION_EXTENT of it, from `corner` on.

    All places are as kernels have them: of a scene that lies far off, relative to its middle (Scene::origin)."""

    camera: np.ndarray
    scale: float
    origin: np.ndarray
    smallest: float
    radius: float

    @property
    def corner(self):
        """Cells begin a part of the smallest before the cube, so that no sheet through its middle is on a border."""
        return self.origin + 0.382 * self.smallest

    def positions(self, packed):
        """Points (n, 3) of positions of 3 x POSITION_BITS."""
        packed, mask = np.asarray(packed, np.uint64), np.uint64((1 << POSITION_BITS) - 1)
        steps = [packed >> np.uint64(POSITION_BITS * axis) & mask for axis in range(3)]
        share = (np.stack(steps, -1).astype(float) + 0.5) / 2**POSITION_BITS
        return self.corner + share * POSITION_EXTENT * self.radius

    def keys(self, points, face, material):
        """Keys (n,) and whether rounding may make the GPU see another cell: within 1e-6 radii of a border, or
        1e-5 of a level."""
        exact = np.log2(self.scale * np.linalg.norm(points - self.camera, axis=-1) / self.smallest)
        level = np.clip(np.floor(exact), 0, 31).astype(int)
        place = np.maximum((points - self.origin) / self.side(level)[:, None], 0)
        index = place.astype(np.uint64) & np.uint64((1 << INDEX_BITS) - 1)
        key = index[:, 0] | index[:, 1] << np.uint64(INDEX_BITS) | index[:, 2] << np.uint64(2 * INDEX_BITS)
        material = material & MATERIAL_MASK
        for value, shift in ((level, LEVEL_SHIFT), (face, FACE_SHIFT), (material, MATERIAL_SHIFT)):
            key = key | np.asarray(value).astype(np.uint64) << np.uint64(shift)
        near = np.abs(place - np.round(place)) * self.side(level)[:, None] < 1e-6 * self.radius
        return key | np.uint64(1 << 63), near.any(-1) | (np.abs(exact - np.round(exact)) < 1e-5)

    def same_places(self, other):
        """Whether keys of both mean the same places: they do unless the scene's sphere has changed."""
        return self.smallest == other.smallest and np.array_equal(self.origin, other.origin)

    def side(self, level):
        return self.smallest * 2.0 ** np.asarray(level)

    def center(self, key):
        """The middle (3,) of a key's cell: of the cells whose indices are the same, the nearest to the camera."""
        period = 1 << INDEX_BITS
        index = np.array([key >> INDEX_BITS * axis & period - 1 for axis in range(3)])
        side = self.side(level_of(key))
        turns = np.round(((self.camera - self.origin) / side - index) / period)
        return self.origin + (index + np.maximum(turns, 0) * period + 0.5) * side


def level_of(key):
    return key >> LEVEL_SHIFT & 31


def face_of(key):
    return key >> FACE_SHIFT & 7


def material_of(key):
    return key >> MATERIAL_SHIFT & MATERIAL_MASK


def grid_of(header, smallest_cell):
    """The Grid of a buffer's header; `smallest_cell`: the knob of the GuidingSplat, in radii."""
    return Grid(
        header["camera"].astype(float),
        float(header["scale"]),
        header["origin"].astype(float),
        float(header["smallest"]),
        float(header["smallest"]) / smallest_cell,
    )


def grid_of_splat(renderer, splat):
    """The Grid of the renderer's last frame, by the name of its GuidingSplat."""
    return grid_of(header_of(renderer.read_port(f"{splat}.statistics")), renderer.get(f"{splat}.smallest_cell"))


def added_rows(renderer, splat, records):
    """Of records per pixel those in rows of pixels that the GuidingSplat of this name has added in the last frame, (rows, ...)."""
    height = renderer.size[1]
    step = -(-height // renderer.get(f"{splat}.rows"))
    return records.reshape(height, -1)[(renderer.frame - 1) % step :: step]


def splatted_paths(renderer, splat):
    """VERTEX records that the GuidingSplat of this name has added in the last frame, and their weights. The renderer's graph is
    one of with_learnt_paths."""
    knobs = renderer.knobs()[splat]
    rows = added_rows(renderer, splat, renderer.read_port(f"{LEARNT}.vertices").view(VERTEX))
    bounces = rows.reshape(-1, constant("PATH_TOLD"))[:, : knobs["learned_bounces"]]
    unwanted = {"all": 0, "scattered": LIGHT_SAMPLED, "none": FINAL}[knobs["final_edges"]]
    vertices = bounces[is_valid(bounces) & (bounces["surface"] & unwanted == 0)]
    weights = 1 / vertex_scatter(vertices) if knobs["incident"] else np.ones(len(vertices))
    return vertices, np.minimum(weights, constant("GUIDING_LARGEST_WEIGHT"))


def passes_of(description, *types):
    """Names of a graph's passes of these types, the last of each; raises UserError where it has none."""
    names = {entry["type"]: entry["name"] for entry in description["passes"]}
    if missing := [kind for kind in types if kind not in names]:
        raise UserError(f"graph '{description.get('name')}': it has no pass of type {', '.join(missing)}")
    return [names[kind] for kind in types]


LEARNT = "learnt_paths"


def with_learnt_paths(description):
    """A copy of a graph's description with a pass LEARNT of type PathVertices: its output `vertices` has the bounces that the
    graph's GuidingSplat learns from. None where that learns from `samples`, or there is none."""
    splats = [entry["inputs"] for entry in description["passes"] if entry["type"] == "GuidingSplat"]
    wired = splats[-1] if splats else {}
    if not wired.get("paths"):
        return None
    added = {"name": LEARNT, "type": "PathVertices", "inputs": {name: wired[name] for name in ("surface", "paths")}}
    return {**description, "passes": [*description["passes"], added]}


class GuidedGraph:
    """Names of the passes by which a graph's description guides."""

    def __init__(self, description):
        types = ("GBuffer", "PathTracerGuided", "ReSTIRReuse", "GuidingSplat", "GuidingFit")
        self.gbuffer, self.paths, self.reuse, self.splat, self.fit = passes_of(description, *types)

    def grid(self, renderer):
        """The Grid of the renderer's last frame."""
        return grid_of_splat(renderer, self.splat)


@dataclass
class Mixture:
    """Lobes: `mu` (4, 3), `kappa` (4,), `weight` (4,)."""

    mu: np.ndarray
    kappa: np.ndarray
    weight: np.ndarray

    def log_lobes(self, w):
        """log(pi_k v_k(w)), (n, 4).  [shaders/README: The von Mises-Fisher distribution]"""
        k = np.maximum(self.kappa, 1e-12)
        normalization = np.log(k / (2 * np.pi * -np.expm1(-2 * k)))
        distance = ((w[:, None] - self.mu) ** 2).sum(-1)
        return np.log(np.maximum(self.weight, 1e-30)) + normalization - 0.5 * self.kappa * distance

    def log_density(self, w):
        return np.logaddexp.reduce(self.log_lobes(w), -1)

    def shares(self, w):
        """Responsibilities, (n, 4).  [shaders/README: The E-step]"""
        return np.exp(self.log_lobes(w) - self.log_density(w)[:, None])


def alpha_of(cell):
    """Probability of the BSDF that a cell has learnt."""
    return int(cell["alpha"]) / 65535


def mixture_of(cell):
    lobes = cell["lobes"]
    return Mixture(unpack_direction(lobes["direction"]), lobes["kappa"].astype(float), lobes["weight"].astype(float))


def chain_mixture_of(cell, position, header):
    """The Mixture of a CHAIN_CELL's chains, seen from a point; weights are 0 of chains that have no lobe. `header`:
    CHAIN_HEADER.  [shaders/README: Markov chain mixtures]"""
    states = cell["states"]
    to = states["target"].astype(float) - position
    distance = np.maximum(np.linalg.norm(to, axis=-1), 1e-20)
    squared = states["samples"].astype(float) ** 2
    r = states["cosine"] * squared / (squared + header["prior"] / np.maximum(distance**2, 1e-12))
    kappa = np.clip(r * (3 - r * r) / np.maximum(1 - r * r, 1e-6), 0, header["largestKappa"])
    return Mixture(to / distance[:, None], kappa, (squared > 0) / max(1, (squared > 0).sum()))
