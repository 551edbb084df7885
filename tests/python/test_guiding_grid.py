"""The guiding grid against an oracle: on recorded vertices of real frames, GuidingSplat's keys and counts are
those of guiding_oracle exactly, its sums within 2^-19 of the samples' weight, and GuidingFit's guide within
1% of guiding_fit_oracle's.

Nothing here is statistical. Left out are cells that rounding decides: vertices within 10^-6 radii of a
border, or lobes within 10^-4 of a threshold of re-seeding. That these are few is tested, too.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import guiding_fit_oracle as fit_oracle
import guiding_oracle as oracle
import numpy as np
import pytest
from renderer_scenes import ROOT, check_samples, make_renderer, restirpg

from restirpg.harness.guiding import LEARNT, level_of, with_learnt_paths
from restirpg.records import constant
from restirpg.scenes import shapes
from restirpg.scenes.gltf import SceneFile, lambert

FRAMES = 6
#: Cells of this part of the image's height hold some ten samples each at 32 x 32.
CELL_SIZE = 0.15
SUM_TOLERANCE = 2.0**-19  # of the samples' weight: single-precision exp; measured: 2^-21
PACKED = 1e-4  # of a direction in 32 bits
FIT_TOLERANCE = 0.01  # of kappa and weight; measured: 0.2%
#: A header's fields of which the grid is made.
GRID = ("camera", "scale", "origin", "smallest")
#: Under a moving camera, the middle of a cell that changes its level is a corner of finer ones, and rounding
#: picks one of them.
FEW = 0.05


@dataclass
class Recorded:
    """One frame. `samples`: SAMPLE; `statistics`, `guide`: (header, table, keys); `before`: the guide a frame
    ago, or None."""

    samples: np.ndarray
    camera: dict
    statistics: tuple
    guide: tuple
    before: tuple | None
    knobs: dict

    @property
    def grid(self):
        return oracle.grid_of(self.statistics[0], self.knobs["splat"]["smallest_cell"])

    @property
    def previous(self):
        """Grid and table of the guide a frame ago."""
        if not self.before:
            return None, {}
        return oracle.grid_of(self.before[0], self.knobs["splat"]["smallest_cell"]), self.before[1]

    @property
    def learns_alpha(self):
        """Was the BSDF a component of the mixtures? Not in the first frame, whose guide says nothing yet."""
        return bool(self.statistics[0]["options"] & oracle.LEARNS_ALPHA)

    @cached_property
    def sums(self):
        """The oracle's E-step."""
        parallax = self.knobs["splat"]["parallax"]
        return oracle.e_step(self.samples, self.grid, *self.previous, self.learns_alpha, parallax)


def training_samples(renderer):
    """What GuidingSplat takes in, as SAMPLE, weighted."""
    splat, names = renderer.knobs()["splat"], renderer.output_names
    if "samples" in names:
        return renderer.read_port("paths.samples").view(oracle.SAMPLE).copy()
    vertices = renderer.read_port(f"{LEARNT}.vertices").view(oracle.VERTEX)
    samples = np.zeros(len(vertices), oracle.SAMPLE)
    for name in oracle.VERTEX.names:
        samples[name] = vertices[name]
    samples["weight"] = 1 / oracle.vertex_scatter(samples) if splat["incident"] else 1
    samples["distance"] = 1
    if splat["final_edges"] == "scattered":
        samples["weight"][samples["surface"] & oracle.LIGHT_SAMPLED != 0] = 0
    bounces = samples.reshape(-1, constant("PATH_TOLD"))
    bounces["weight"][:, splat["learned_bounces"] :] = 0
    return samples


def in_added_rows(renderer, samples):
    """The samples of each n-th row of pixels, of which the first is a row further on in each frame."""
    width, height = renderer.size
    step = -(-height // renderer.knobs()["splat"]["rows"])
    by_row = samples.reshape(height, -1)
    return by_row[(renderer.frame - 1) % step :: step].reshape(-1)


def record(scene, graph, move=0.0, count=FRAMES, leaves=None, **knobs):
    """`count` frames of a graph whose camera steps `move` m aside per frame. In the last two the node `leaves` is 100 m
    away, so that the scene outgrows its sphere. Knobs: pass__knob."""
    renderer = make_renderer(scene, graph, seed=7)
    for name, value in knobs.items():
        renderer.set(name.replace("__", "."), value)
    place = renderer.camera["position"]
    values = renderer.knobs()
    distances = [oracle.DISTANCES] if values["splat"]["parallax"] else []
    fit = values["fit"]
    memory = [oracle.MEMORY] if fit["keep_samples"] or fit["decay"] > 0 or fit["parallax"] else []
    frames, before = [], None
    for frame in range(count):
        renderer.move_camera(position=(place[0] + move * frame, place[1], place[2]))
        if leaves and frame == count - 2:
            away = np.eye(4)
            away[:3, 3] = 100.0
            renderer.move_node(leaves, away)
        renderer.render(1)
        guide = oracle.read_table(renderer.read_port("fit.guide"), oracle.CELL, *memory)
        statistics = oracle.read_table(renderer.read_port("splat.statistics"), oracle.SUMS, *distances)
        frames.append(
            Recorded(
                in_added_rows(renderer, training_samples(renderer)), renderer.camera, statistics, guide, before, values
            )
        )
        before = guide
    check_samples(renderer)
    return frames


def graph_of(name):
    """A graph of graphs/, with what it trains on as outputs."""
    description = restirpg.load_graph(ROOT / "graphs" / f"{name}.py").description
    description = with_learnt_paths(description) or description
    port = {"restir_pg": (LEARNT, "vertices"), "raw_pt_ruppert2020": ("paths", "samples")}[name]
    description["outputs"].append({"name": port[1], "pass": port[0], "output": port[1]})
    return description


CASES = {
    "still": ("cornell_box", "restir_pg", {}),
    "moving": ("door_ajar", "restir_pg", {"move": 0.04}),
    "raw, parallax and decay": ("door_ajar", "raw_pt_ruppert2020", {"move": 0.04, "splat__cell_size": 0.24}),
    "raw, decay and lobes that are moved": (
        "door_ajar",
        "raw_pt_ruppert2020",
        {"move": 0.04, "fit__lobes": 3, "fit__minimum": 2, "fit__weight_prior": 0},
    ),
    "incident radiance": (
        "door_ajar",
        "restir_pg",
        {"splat__incident": True, "splat__final_edges": "scattered"},
    ),
    "two bounces of each path": ("door_ajar", "restir_pg", {"splat__learned_bounces": 2}),
    "every third row": ("door_ajar", "restir_pg", {"splat__rows": 12}),
    "two lobes": ("door_ajar", "restir_pg", {"fit__lobes": 2}),
    "learnt alpha": ("door_ajar", "restir_pg", {"move": 0.04, "fit__learn_alpha": True}),
    "a scene that outgrows its sphere": ("door_ajar", "restir_pg", {"leaves": "Chair"}),
    "neither kept samples nor memory": (
        "cornell_box",
        "restir_pg",
        {"fit__keep_samples": False, "fit__oldest": 2, "fit__reseed": False},
    ),
}


@pytest.fixture(scope="module", params=CASES, ids=lambda name: name.replace(" ", "-"))
def frames(request, embedded):
    name, graph, options = CASES[request.param]
    return record(restirpg.load_scene(embedded(name)), graph_of(graph), **{"splat__cell_size": CELL_SIZE} | options)


def expected_sums(frame):
    """The oracle's E-step, and the keys to be compared."""
    sums = frame.sums
    certain = [key for key, cell in sums.items() if not cell.doubtful]
    assert len(certain) >= (1 - FEW) * len(sums)
    return sums, certain


def check_grid(frame):
    """The grid is made from this frame's camera."""
    header = frame.statistics[0]
    height = 2 * np.tan(frame.camera["yfov"] / 2)
    assert np.allclose(header["camera"], frame.camera["position"], atol=1e-6)
    assert np.isclose(header["scale"], frame.knobs["splat"]["cell_size"] * height, rtol=1e-5)


def check_keys_and_counts(frame):
    sums, certain = expected_sums(frame)
    header, table, keys = frame.statistics
    if len(certain) == len(sums):
        assert set(table) == set(sums)
    assert set(certain) <= set(table)
    assert all(table[key][0]["count"] == sums[key].count for key in certain)
    assert sum(int(records[0]["count"]) for records in table.values()) == sum(cell.count for cell in sums.values())
    assert header["cells"] == len(table) and header["failed"] == 0
    assert oracle.slots_are_reachable(keys)


def check_sums(frame):
    sums, certain = expected_sums(frame)
    for key in certain:
        found, cell = frame.statistics[1][key], sums[key]
        tolerance = SUM_TOLERANCE * cell.weight + cell.count / oracle.ONE
        if frame.knobs["splat"][
            "parallax"
        ]:  # single-precision places turn directions by their rounding over the distance
            tolerance += 2.0**-20 * frame.grid.radius * cell.inverse.sum()
        assert np.abs(found[0]["lanes"].reshape(oracle.LOBES, 4) / oracle.ONE - cell.sums).max() < tolerance
        assert abs(found[0]["bsdf"] / oracle.ONE - cell.bsdf) < tolerance
        if len(found) > 1:
            error = np.abs(found[1]["lanes"] / oracle.ONE - cell.inverse)
            # The rounding of places moves the inverse of a distance by its square.
            rounding = 2.0**-20 * frame.grid.radius / cell.nearest
            assert error.max() < (SUM_TOLERANCE + rounding) * cell.inverse.sum() + cell.count / oracle.ONE


def check_strangest(frame):
    """The sample that is explained worst is one of the cell's, and its log density is the least, to 1/256."""
    sums, certain = expected_sums(frame)
    for key in certain:
        strangest = int(frame.statistics[1][key][0]["strangest"])
        direction = oracle.unpack_direction(np.uint32(strangest & 0xFFFFFFFF))
        assert np.linalg.norm(sums[key].directions - direction, axis=-1).min() < PACKED
        assert abs(128 - (strangest >> 32) / 256 - sums[key].worst) < 1 / 128


def expected_guide(frame):
    """The oracle's guide."""
    return fit_oracle.fit_guide(
        frame.statistics[1], frame.learns_alpha, frame.grid, *frame.previous, frame.knobs["fit"]
    )


def check_fit(frame):
    """Parameters, ages, samples and memories of all cells, whether fitted now, pooled or carried on."""
    expected = expected_guide(frame)
    guide = frame.guide[1]
    assert set(guide) == set(expected)
    certain = [key for key in expected if not expected[key].doubtful]
    assert len(certain) >= (1 - FEW) * len(expected)
    check_cells([guide[key] for key in certain], [expected[key] for key in certain])


def check_cells(found, cells):
    """Records of cells are as expected."""
    cell = np.array([records[0] for records in found])
    mixtures = [oracle.mixture_of(record) for record in cell]
    for name, tolerance in (("kappa", {"atol": 2e-3}), ("weight", {"atol": 1e-6})):
        values = np.array([getattr(mixture, name) for mixture in mixtures])
        expected = np.array([getattr(c.mixture, name) for c in cells])
        assert np.allclose(values, expected, rtol=FIT_TOLERANCE, **tolerance)
    assert np.allclose(values.sum(-1), 1, atol=1e-5)  # of the weights
    turns = np.array([mixture.mu - c.mixture.mu for mixture, c in zip(mixtures, cells)])
    assert np.linalg.norm(turns, axis=-1).max() < 2e-4
    assert np.abs([oracle.alpha_of(record) - c.alpha for record, c in zip(cell, cells)]).max() < 1e-4
    assert np.array_equal(cell["age"], [c.age for c in cells])
    assert np.allclose(cell["samples"], [c.samples for c in cells], rtol=1e-5)
    if cells[0].memory is not None:
        memories = np.array([fit_oracle.memory_of(records[1]) for records in found])
        expected = np.array([c.memory for c in cells])
        sums, rest = expected[:, :18], expected[:, 18:]
        assert np.allclose(memories[:, :18], sums, rtol=1e-4, atol=1e-4 * np.maximum(sums[:, 17:], 1))
        largest = np.abs(rest).max(1, keepdims=True)
        assert np.allclose(memories[:, 18:], rest, rtol=1e-4, atol=1e-4 * np.maximum(largest, 1))


def check_counts_of_the_guide(frame):
    header, guide, keys = frame.guide
    cells = [records[0] for records in guide.values()]
    assert header["cells"] == len(cells) and header["failed"] == 0
    assert header["samples"] == sum(int(records[0]["count"]) for records in frame.statistics[1].values())
    assert header["fitted"] == sum(cell["samples"] > 0 and cell["age"] == 0 for cell in cells)
    assert header["guiding"] == sum(cell["samples"] > 0 for cell in cells)
    assert oracle.slots_are_reachable(keys)


CHECKS = (
    check_grid,
    check_keys_and_counts,
    check_sums,
    check_strangest,
    check_fit,
    check_counts_of_the_guide,
)


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_every_frame_is_as_the_oracle_says(frames, check):
    for frame in frames:
        check(frame)


def test_the_frames_show_what_is_tested(frames):
    """Cells are fitted, others wait for samples, some had guidance before; alpha is learnt where it is to be; lobes are
    moved, where that is to be seen, and leave what they remember."""
    learns = frames[-1].knobs["fit"]["learn_alpha"]
    assert [frame.learns_alpha for frame in frames] == [False] + [learns] * (len(frames) - 1)
    learnt = {records[0]["alpha"] for records in frames[-1].guide[1].values()}
    assert len(learnt) > 10 if learns else learnt == {32768}
    if frames[-1].knobs["fit"]["lobes"] == 3:
        moved = [cell for frame in frames for cell in expected_guide(frame).values() if cell.handed_over]
        assert len(moved) > 20
    last = frames[-1].guide
    ages = np.array([records[0]["age"] for records in last[1].values()])
    assert 0 < last[0]["fitted"] < last[0]["cells"] and (ages > 0).any() and frames[-1].before is not None
    assert frames[-1].before[0]["guiding"] > 0


def wrong_kappa(monkeypatch):
    right = fit_oracle.m_step

    def m_step(*arguments):
        m = right(*arguments)
        m.kappa = 1.05 * m.kappa
        return m

    monkeypatch.setattr(fit_oracle, "m_step", m_step)


def wrong_normalization(monkeypatch):
    right = oracle.Mixture.log_lobes
    monkeypatch.setattr(oracle.Mixture, "log_lobes", lambda self, w: right(self, w) + 0.001 * np.sqrt(self.kappa))


@pytest.mark.parametrize(
    ("mutation", "check"),
    [(wrong_kappa, check_fit), (wrong_normalization, check_sums)],
    ids=["kappa 5% too large", "normalisation off by 0.1%"],
)
def test_a_mistake_of_the_formulas_is_found(frames, monkeypatch, mutation, check):
    mutation(monkeypatch)
    with pytest.raises(AssertionError):
        for frame in frames:
            check(replace(frame))  # a copy has not worked out its sums yet


def missing_keys(frame):
    """How many keys of the oracle's, by the frame's grid, are not in its table."""
    return len(set(expected_sums(frame)[1]) - set(frame.statistics[1]))


def test_keys_of_the_previous_camera_are_found(embedded):
    knobs = {"splat__cell_size": CELL_SIZE}
    door = restirpg.load_scene(embedded("door_ajar"))
    first, last = record(door, graph_of("restir_pg"), move=0.2, count=2, **knobs)
    header, table, keys = last.statistics
    assert missing_keys(last) == 0
    mistaken = header.copy()
    for name in GRID:
        mistaken[name] = first.statistics[0][name]
    # The grid only moves where cells change their size: 20 of 409 keys.
    assert missing_keys(replace(last, statistics=(mistaken, table, keys))) > 10


def test_parallax_asks_for_samples(scene):
    knobs = {"splat__parallax": True, "fit__parallax": True, "fit__decay": 0.9}
    with pytest.raises(restirpg.Error, match="parallax=true needs samples"):
        record(scene, graph_of("restir_pg"), count=1, **knobs)


@pytest.mark.parametrize("knobs", [{"splat__final_edges": "none"}, {"splat__incident": True}])
def test_what_is_meant_for_paths_is_refused_for_samples(scene, knobs):
    with pytest.raises(restirpg.Error, match="incident and final_edges are for paths"):
        record(scene, graph_of("raw_pt_ruppert2020"), count=1, **knobs)


def corner(folder):
    """A floor and a wall, white, in the open."""
    scene = SceneFile("corner", 2, environment=(1.0, 1.0, 1.0))
    white = lambert("White", (0.8, 0.8, 0.8))
    scene.add("Floor", (shapes.quad((-1, 0, 1), (2, 0, 0), (0, 0, -2)), white))
    scene.add("Wall", (shapes.quad((-1, 0, -1), (2, 0, 0), (0, 2, 0)), white))
    scene.add_camera((0.0, 1.0, 3.0), (0.0, 0.5, -0.5), 40.0)
    return scene.write(folder)


def test_light_too_dim_for_the_sums_leaves_no_lobes_that_are_too_light(tmp_path):
    """Weights that do not add up to 1 would be drawn from, but not be in the density: a bias."""
    file = corner(tmp_path)
    graph = graph_of("raw_pt_ruppert2020")
    for light, guides in (("1e-9,1e-9,1e-9", False), ("1e-7,1e-7,1e-7", True), ("1,1,1", True)):
        renderer = make_renderer(restirpg.load_scene(file, environment=light), graph, seed=7)
        renderer.set("splat.cell_size", CELL_SIZE)
        for knob in ("cosine", "reseed"):
            renderer.set(f"fit.{knob}", False)
        renderer.render(4)
        cells = oracle.read_table(renderer.read_port("fit.guide"), oracle.CELL, oracle.MEMORY)[1]
        weights = [oracle.mixture_of(cell).weight.sum() for cell, *_ in cells.values() if cell["samples"] > 0]
        assert (len(weights) > 5) == guides
        assert np.allclose(weights, 1, atol=1e-3)


@pytest.mark.parametrize("smallest", [1e-5, 1e-4, 1e-3])
def test_the_middle_of_a_key_is_where_its_points_are(smallest):
    """Also where the grid has more cells than a key can count, as near a camera in a large scene."""
    radius = 1000.0
    camera = np.array([10.0, -20.0, 5.0])
    grid = oracle.Grid(camera, 0.12, np.full(3, -2 * radius), smallest * radius, radius)
    points = camera + np.random.default_rng(3).normal(size=(200, 3)) * np.geomspace(0.01, 500, 200)[:, None]
    keys, _ = grid.keys(points, np.zeros(200, int), np.zeros(200, int))
    for point, key in zip(points, keys.tolist()):
        assert np.abs(grid.center(key) - point).max() <= 0.501 * grid.side(level_of(key))
