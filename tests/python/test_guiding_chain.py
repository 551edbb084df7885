"""GuidingChain: its chains move as a NumPy oracle says, and paths that they guide have the path tracer's mean.

The oracle is written from framework/shaders/README.md, "Markov chain mixtures", in double precision. Cells where rounding
could decide are left out, and counted. Statistics of the rendered test: see live_guides.py. Indirect light of the
diffuse Cornell box, bounce cap 2. A guide whose density is 10% too small must be found.
"""

import guiding_oracle as oracle
import numpy as np
import pytest
from live_guides import check_mean, unguided, verdict_on
from mutants import mutant
from renderer_scenes import ROOT, make_renderer, restirpg

from restirpg.harness.guiding import CHAIN_CELL, chain_header_of, chain_mixture_of
from restirpg.records import constant

CELL = CHAIN_CELL
CHAINS = constant("CHAINS")
REFERENCE_PATHS = 1024
TESTS = 2  # that share the false-alarm rate
SEED = 7
STREAM = 0xC2B2AE35  # random.glsl: RANDOM_STREAM_CHAIN
SMALLEST_CELL = 1e-3
FEW = 0.05  # of the chains that rounding may decide


def graph(output="guide", **knobs):
    """ReSTIR PT over candidates that chains guide. `output`: the port that is called radiance."""
    described = restirpg.load_graph(ROOT / "graphs" / "raw_pt_alber2025.py").description
    passes = {p["name"]: p for p in described["passes"]}
    passes["guide"]["knobs"].update(knobs)
    passes["accumulate"]["inputs"]["indirect"] = {"pass": "paths", "output": "radiance"}
    for name in ("direct", "emission"):
        del passes["accumulate"]["inputs"][name]
    name, port = {"guide": ("guide", "guide")}.get(output) or output.split(".")
    described["outputs"] = [
        {"name": "radiance", "pass": name, "output": port},
        {"name": "samples", "pass": "paths", "output": "samples"},
    ]
    return described


def read_guide(renderer):
    """The header, {key: ChainCell}, the grid and the header of the chains."""
    raw = renderer.read_port("guide.guide")
    header, table, keys = oracle.read_table(raw, CELL)
    assert oracle.slots_are_reachable(keys)
    cells = {key: cell for key, (cell,) in table.items()}
    return header, cells, oracle.grid_of(header, SMALLEST_CELL), chain_header_of(raw)


class Proposals:
    """What the samples of a cell propose: per chain the sum of weights, the best bid, its sample and whether it explores."""

    def __init__(self):
        self.count = 0
        self.weights, self.bids = np.zeros(CHAINS), np.zeros(CHAINS)
        self.best, self.explores = [None] * CHAINS, [False] * CHAINS
        self.doubtful = [False] * CHAINS

    def add(self, number, weight, cell, position, w, bsdf_density, numbers, header):
        chain, explores, doubtful = min(int(numbers[1] * CHAINS), CHAINS - 1), True, False
        if cell is not None and (cell["states"]["samples"] > 0).any():
            densities = np.exp(chain_mixture_of(cell, position, header).log_lobes(w[None]))[0]
            # The components' shares of the unit interval, in order: the lobes, then the BSDF.
            borders = np.cumsum([*densities, bsdf_density]) / (densities.sum() + bsdf_density)
            component = int(np.searchsorted(borders, numbers[0], side="right"))
            doubtful = np.abs(borders[:-1] - numbers[0]).min() < 1e-4
            if component < CHAINS:
                chain, explores = component, False
        if doubtful:
            self.doubtful = [True] * CHAINS
        self.weights[chain] += weight
        bid = weight / -np.log(max(numbers[2], 1e-9))
        if abs(bid - self.bids[chain]) < 1e-5 * bid:
            self.doubtful[chain] = True
        if bid > self.bids[chain]:
            self.bids[chain], self.best[chain], self.explores[chain] = bid, number, explores


def propose(samples, width, frame, grid, before, knobs):
    """{key: Proposals} of a frame; `before`: cells, grid and header of the frame before, or None."""
    stride = len(samples) // (width * width)
    points = grid.positions(samples["position"])
    keys, doubtful = grid.keys(points, oracle.vertex_face(samples), samples["surface"] & 0xFFFF)
    directions, densities = oracle.unpack_direction(samples["direction"]), oracle.vertex_density(samples)
    numbers = np.arange(len(samples))
    pixels = numbers // stride
    words = oracle.pcg4d(
        (pixels % width | (pixels // width) << 16).astype(np.uint32),
        np.full(len(samples), frame, np.uint32),
        np.full(len(samples), SEED ^ STREAM, np.uint32),
        (numbers % stride * 16).astype(np.uint32),
    )
    random = np.stack(oracle.unit_floats(words), -1)
    weights = samples["weight"].astype(float)
    if knobs["product"]:
        weights = weights * oracle.vertex_scatter(samples)
    found, unsure = {}, set()
    for n in np.flatnonzero(oracle.is_valid(samples)):
        key = int(keys[n])
        cell, doubt = None, False
        if before is not None:
            previous, doubt = oracle.previous_key(key, grid, before[1], before[0])
            cell = before[0].get(previous)
        if doubt or doubtful[n]:
            unsure.add(key)
        proposals = found.setdefault(key, Proposals())
        proposals.count += 1
        if weights[n] > 0:
            weight = min(weights[n], oracle.LARGEST_WEIGHT)
            proposals.add(n, weight, cell, points[n], directions[n], densities[n], random[n], before and before[2])
    for key in unsure:
        found[key].doubtful = [True] * CHAINS
    return found


def advance(state, proposals, chain, key, frame, samples, grid, knobs):
    """The state of a chain after a frame, a dictionary, and whether rounding decides."""
    state = {name: np.array(state[name], float) for name in CELL["states"].base.names}
    state["energy"] = state["energy"] * knobs["decay"]
    energy = proposals.weights[chain] / max(proposals.count, 1)
    word = oracle.pcg4d(
        *(
            np.array([w], np.uint32)
            for w in (key & 0xFFFFFFFF, key >> 32, frame, ((SEED ^ STREAM) + chain) & 0xFFFFFFFF)
        )
    )
    bar = oracle.unit_floats(word)[0][0] * state["energy"]
    n = proposals.best[chain]
    doubtful = proposals.doubtful[chain] or (n is not None and abs(bar - energy) < 1e-4 * energy)
    if n is None or (state["samples"] > 0 and bar >= energy):
        return state, doubtful
    position, w = grid.positions(samples["position"][n : n + 1])[0], oracle.unpack_direction(samples["direction"][n])
    target = position + min(float(samples["distance"][n]), 100 * grid.radius) * w
    if proposals.explores[chain] or state["samples"] == 0:
        return {"target": target, "cosine": 1.0, "energy": energy, "samples": 1.0}, doubtful
    count = min(state["samples"] + 1, knobs["memory"])
    to = state["target"] - position
    cosine = to @ w / np.linalg.norm(to)
    moved = {
        "target": state["target"] + (target - state["target"]) / count,
        "cosine": state["cosine"] + (cosine - state["cosine"]) / count,
        "energy": energy,
        "samples": count,
    }
    return moved, doubtful


def check_frame(renderer, before, after, knobs):
    """All cells of a frame; returns the shares of chains that moved within their lobe, and that began anew."""
    header, cells, grid, _ = after
    samples = renderer.read_port("paths.samples").view(oracle.SAMPLE)
    frame = renderer.frame - 1
    found = propose(samples, renderer.size[0], frame, grid, before and before[1:], knobs)
    assert header["samples"] == sum(p.count for p in found.values())
    lobes = [(cell["states"]["samples"] > 0).any() for cell in cells.values()]
    assert (header["cells"], header["guiding"], header["failed"]) == (len(cells), sum(lobes), 0)
    empty, doubts, moved, began = np.zeros((), CELL), 0, 0, 0
    for key, proposals in found.items():
        previous = oracle.previous_key(key, grid, before[2], before[1])[0] if before else None
        start = before[1][previous] if previous is not None else empty
        if key not in cells:
            assert all(proposals.doubtful)
            continue
        assert cells[key]["age"] == 0
        for chain in range(CHAINS):
            was = start["states"][chain]
            expected, doubtful = advance(was, proposals, chain, key, frame, samples, grid, knobs)
            doubts += doubtful
            if doubtful:
                continue
            state = cells[key]["states"][chain]
            moved += was["samples"] > 0 and expected["samples"] > was["samples"]
            began += expected["samples"] == 1 and not np.array_equal(expected["target"], was["target"])
            for name, value in expected.items():
                scale = grid.radius if name == "target" else 1.0
                assert np.allclose(state[name], value, rtol=1e-4, atol=1e-4 * scale), (name, chain)
    total = CHAINS * len(found)
    assert doubts < FEW * total
    for key in cells.keys() - found.keys():
        previous = before[1][oracle.previous_key(key, before[2], None, before[1])[0] or key]
        assert (
            cells[key]["age"] == previous["age"] + 1 and cells[key]["states"].tobytes() == previous["states"].tobytes()
        )
    return moved / total, began / total


@pytest.mark.parametrize("knobs", [{}, {"product": False, "decay": 1.0, "memory": 2.0}], ids=["defaults", "others"])
def test_chains_move_as_the_oracle_says(scene, knobs):
    renderer = make_renderer(scene, graph(cell_size=0.2, **knobs), seed=SEED, size=(24, 24))
    before, shares = None, []
    for _ in range(5):
        renderer.render(1)
        after = read_guide(renderer)
        shares.append(check_frame(renderer, before, after, renderer.knobs()["guide"]))
        before = after
    assert min(shares[-1]) > 0.02, "too few chains move for a test of how"


def test_a_cut_forgets_the_chains(scene):
    renderer = make_renderer(scene, graph(), seed=1)
    renderer.render(4)
    assert max(cell["states"]["samples"].max() for cell in read_guide(renderer)[1].values()) > 1
    renderer.cut()
    renderer.render(1)
    assert max(cell["states"]["samples"].max() for cell in read_guide(renderer)[1].values()) == 1


def test_the_same_seed_gives_the_same_bytes(scene):
    images = []
    for _ in range(2):
        renderer = make_renderer(scene, graph("reuse.radiance"), seed=3)
        renderer.render(8)
        images.append(renderer.output("radiance").tobytes())
    assert images[0] == images[1]


@pytest.fixture(scope="module")
def reference(scene):
    """The plain path tracer's indirect light."""
    return unguided(scene, REFERENCE_PATHS)


@pytest.mark.parametrize("output", ["paths.radiance", "reuse.radiance"])
def test_guiding_by_chains_keeps_the_path_tracers_mean(scene, reference, output):
    check_mean(scene, graph(output), reference, TESTS)


def test_a_density_that_is_too_small_is_found(scene, reference):
    with mutant("chain_density"):
        assert verdict_on(scene, graph("paths.radiance"), reference, TESTS).biased
