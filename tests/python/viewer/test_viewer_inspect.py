"""What the viewer tells of a pixel of a guided graph: reservoirs in words, the selected path in the picture, the
guide."""

import json

import numpy as np
import pytest
from renderer_scenes import GRAPH, restirpg, write_far

from restirpg.harness import UserError, guide_maps, guiding
from restirpg.viewer import camera, capture, guide, reservoirs
from restirpg.viewer.session import Session

SIZE = (32, 32)
FLOOR = (16, 28)
FRAMES, SEED = 12, 1


@pytest.fixture(scope="module")
def session(scene):
    """ReSTIR PG after some frames."""
    session = Session(scene, [GRAPH.with_name("restir_pg.py")], SIZE, validation=True)
    session.apply({"do": "seed", "value": SEED})
    for _ in range(FRAMES):
        session.render()
    return session


@pytest.fixture(scope="module")
def pixel(session):
    """A pixel that has selected a path of several bounces, as the page is told of it."""
    for x in range(4, 28):
        told = session.inspector.pixel(x, FLOOR[1])
        if told["paths"][0] and len(told["paths"][0]["bounces"]) > 1:
            return told
    raise AssertionError("no pixel has selected a path")


def test_the_radiance_told_of_a_path_is_that_of_the_pass(session, pixel):
    told = pixel["reservoirs"][0]
    assert set(told) == {"direct.reservoirs", "reuse.reservoirs"}
    path = [what for what, _ in told["reuse.reservoirs"]]
    (radiance,) = [what.partition("= ")[2].split() for what in path if what.startswith("f W")]
    np.testing.assert_allclose([float(value) for value in radiance], pixel["panes"][0]["reuse.radiance"], rtol=2e-3)
    edges = int(path[0].split()[3])
    assert edges > max(pixel["paths"][0]["bounces"]) and edges <= 1 + session.panes[0].bounces + 1
    assert path[2].startswith("x1 smooth")
    assert any(what.startswith(("a point of triangle", "empty")) for what, _ in told["direct.reservoirs"])


def test_the_selected_path_begins_at_the_pixel_and_stays_in_the_scene(session, pixel):
    path = pixel["paths"][0]
    assert path["bounces"][0] == 1 and path["bounces"] == sorted(path["bounces"])
    first = np.multiply(path["points"][0], SIZE)
    np.testing.assert_allclose(first, [pixel["x"] + 0.5, pixel["y"] + 0.5], atol=0.05)
    # The camera looks into a box: all of it is in front.
    assert all(point is not None for point in path["points"])


def test_times_memory_and_files_are_the_graphs_own(session, tmp_path):
    """Without the pass that tells the viewer what paths are."""
    plain = restirpg.Renderer(session.scene, restirpg.load_graph(GRAPH.with_name("restir_pg.py")), size=SIZE)
    plain.render(2)
    passes = [entry["name"] for entry in session.panes[0].description["passes"]]
    assert guiding.LEARNT in session.panes[0].renderer.gpu_times() and guiding.LEARNT not in passes
    told = session.frame().header["panes"][0]
    assert set(told["passes"]) == set(passes)
    shown_alone = SIZE[0] * SIZE[1] * 12  # the last frame, of which the viewer keeps a mean
    assert told["memory"] == sum(plain.memory().values()) + shown_alone
    capture.save(session, session.panes[0], tmp_path / "saved.exr")
    saved = json.loads(restirpg.read_exr_attributes(tmp_path / "saved.exr")["restirpg.graph"])
    assert [entry["name"] for entry in saved["passes"]] == passes
    restirpg.Renderer(session.scene, saved, size=SIZE)  # a graph as it is


def test_points_are_projected_as_pixels_see_them(session):
    pose, (x, y) = session.camera, FLOOR
    depth = session.inspector.geometry(x, y)["depth"]
    right, up, forward = camera.axes(pose)
    extent = np.tan(pose["yfov"] / 2)
    point = pose["position"] + depth * (
        forward + extent * ((2 * (x + 0.5) / SIZE[0] - 1) * right + (1 - 2 * (y + 0.5) / SIZE[1]) * up)
    )
    np.testing.assert_allclose(np.multiply(camera.project(pose, 1.0, [point])[0], SIZE), [x + 0.5, y + 0.5], atol=1e-6)
    assert camera.project(pose, 1.0, [pose["position"] - forward]) == [None]


def test_empty_and_light_reservoirs_in_words():
    assert reservoirs.describe_path(np.zeros(1, reservoirs.PATH)[0])[0][0] == "empty"
    light = np.zeros(1, reservoirs.LIGHT)
    assert reservoirs.describe_light(light[0])[0][0] == "empty"
    light["confidence"], light["instance"], light["index"] = 3, 0xFFFFFFFF, 7
    words = [what for what, _ in reservoirs.describe_light(light[0])]
    assert words[:2] == ["a point of light 7 of the table", "confidence M = 3"]
    light["index"] = 0xFFFFFFFF  # as ReSTIRDI has it where all candidates carry nothing
    words = [what for what, _ in reservoirs.describe_light(light[0])]
    assert words[:2] == ["empty", "confidence M = 3"]
    path = np.zeros(1, reservoirs.PATH)
    path["shape"], path["labels"], path["confidence"] = 4 | 3 << 8 | 1 << 17, 1 << 2, 2
    words = [what for what, _ in reservoirs.describe_path(path[0])]
    assert words[:4] == [
        "a path of 4 edges",
        "its light was met by scattering",
        "x1 smooth, x2 sharp reflection (delta), x3 smooth",
        "it reconnects at x3",
    ]
    path["shape"] = 3 | 3 << 8 | 1 << 7
    path["anchor"] = 0xFFFFFFFF, 5
    told = reservoirs.describe_path(path[0])
    assert [what for what, _ in told[:2]] == ["a path of 3 edges", "its light was sampled"]
    assert told[3] == ("it reconnects at its light, x3", "light 5 of the table")


def test_the_guide_at_a_pixel_is_that_of_the_harness(session, scene):
    """guide_maps makes it from a renderer of its own, as see_guide draws it."""
    description = session.panes[0].description
    (point,), (frames,), (mixture,) = guide_maps.Learner(scene, description, [FLOOR], SIZE).run(FRAMES, SEED)
    told = session.inspector.guide(0, *FLOOR)
    order = np.argsort(-mixture.weight)
    assert told["lobes"] == [(float(mixture.kappa[i]), float(mixture.weight[i])) for i in order]
    directions, weights = frames[-1]
    maps = {
        "lobes": guide_maps.lobes_in(mixture, point),
        "directions of this frame": point.histogram(directions, weights),
    }
    assert told["directions"] == len(directions) > 0
    assert told["maps"] == guide._encoded(maps, guide_maps.top_of([maps["lobes"]]))
    cell = guiding.read_guide(session.panes[0].renderer.read_port("fit.guide"))[1][point.key]
    assert told["alpha"] == 0.5 and told["samples"] == cell["samples"] > 0
    assert sum(weight for _, weight in told["lobes"]) == pytest.approx(1, abs=0.01)


def test_a_guide_of_other_knobs_is_told(scene):
    """The alpha that paths have, and a guide that keeps no samples, whose cells have no memory."""
    session = Session(scene, [GRAPH.with_name("restir_pg.py")], SIZE, validation=True)
    for knob, value in (("paths.alpha", 0.25), ("fit.keep_samples", False)):
        session.apply({"do": "set", "pane": 0, "knob": knob, "value": value})
    for _ in range(FRAMES):
        session.render()
    told = session.inspector.guide(0, *FLOOR)
    assert told["alpha"] == 0.25 and told["samples"] > 0
    session.apply({"do": "set", "pane": 0, "knob": "fit.learn_alpha", "value": True})
    for _ in range(FRAMES):
        session.render()
    cells = guiding.read_guide(session.panes[0].renderer.read_port("fit.guide"))[1].values()
    told = session.inspector.guide(0, *FLOOR)["alpha"]
    assert told in [guiding.alpha_of(cell) for cell in cells] and told not in (0.25, 0.5)


@pytest.mark.parametrize(
    ("graph", "knobs"),
    [
        ("restir_pg.py", {}),
        ("restir_pg.py", {"splat.rows": 8, "splat.learned_bounces": 1}),
        ("guided_by_candidates.py", {"splat.final_edges": "none"}),
        ("restir_pg.py", {"splat.final_edges": "scattered", "splat.incident": True}),
    ],
)
def test_what_a_guide_learns_from_is_what_is_splatted(scene, graph, knobs):
    description = guiding.with_learnt_paths(restirpg.load_graph(GRAPH.with_name(graph)).description)
    renderer = restirpg.Renderer(scene, description, size=SIZE, outputs=[f"{guiding.LEARNT}.vertices"], validation=True)
    for knob, value in knobs.items():
        renderer.set(knob, value)
    renderer.render(3)
    header, table, _ = guiding.read_table(renderer.read_port("splat.statistics"), guiding.SUMS)
    vertices, weights = guiding.splatted_paths(renderer, "splat")
    assert header["failed"] == 0 and len(vertices) == sum(int(sums["count"]) for (sums,) in table.values()) > 100
    assert (weights == 1).all() != ("splat.incident" in knobs)


def test_maps_without_light_have_a_scale():
    dark, narrow = np.zeros((8, 32)), np.zeros((8, 32))
    narrow[3, 4] = 0.5
    assert guide_maps.top_of([dark, None, narrow]) == 0.5 and guide_maps.top_of([dark]) == 1
    assert np.isnan(guide_maps.score(narrow, 3, dark, np.random.default_rng(1))).all()


def test_the_true_product_is_of_the_time_and_of_the_renderers_options(flying, monkeypatch):
    made = []

    class Recorded(restirpg.Renderer):
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            made.append((options, self))

        def set_time(self, seconds):
            super().set_time(seconds)
            self.seconds = seconds

    options = {"device": 0, "energy_compensation": True, "validation": True, "outputs": ["frame"]}
    session = Session(flying, [GRAPH.with_name("restir_pg.py")], SIZE, **options)
    session.apply({"do": "time", "seconds": 0.01})
    session.render()
    monkeypatch.setattr(guide_maps.restirpg, "Renderer", Recorded, raising=False)
    assert "true product" in session.inspector.guide(0, 16, 16, product=True)["maps"]
    (product,) = [entry for entry in made if entry[0]["size"] == (guide_maps.FACE, guide_maps.FACE)]
    assert product[1].seconds == 0.01
    wanted = {"device": 0, "energy_compensation": True, "validation": True}
    assert wanted.items() <= product[0].items() and "outputs" not in product[0]


def test_the_guide_by_chains_is_told_too(scene):
    session = Session(scene, [GRAPH.with_name("raw_pt_alber2025.py")], SIZE, validation=True)
    for _ in range(FRAMES):
        session.render()
    assert session.state()["panes"][0]["guided"]  # so the page offers it
    told = session.inspector.guide(0, *FLOOR)
    assert 0 < len(told["lobes"]) <= 4 and sum(weight for _, weight in told["lobes"]) == pytest.approx(1)
    assert told["alpha"] == 0.5 and told["samples"] >= 1 and set(told["maps"]) == {"lobes", "directions of this frame"}


FAR = (1000, 0, 0)  # so many radii from 0 that kernels have places relative to the scene's middle


@pytest.fixture(scope="module")
def far(scene_file, tmp_path_factory):
    """The Cornell box, far off."""
    return restirpg.load_scene(write_far(scene_file, tmp_path_factory.mktemp("far") / "box.glb", FAR))


def test_the_points_of_a_scene_far_off_stand_in_the_world_and_in_cells(scene, far):
    description = restirpg.load_graph(GRAPH.with_name("restir_pg.py")).description
    ((near,), _, _), ((point,), (frames,), (mixture,)) = (
        guide_maps.Learner(where, description, [FLOOR], SIZE).run(FRAMES, SEED) for where in (scene, far)
    )
    np.testing.assert_allclose(point.position - near.position, FAR, atol=1e-3)
    assert mixture is not None and sum(len(directions) for directions, _ in frames) > 0


@pytest.mark.parametrize("graph", ["restir_pg.py", "raw_pt_alber2025.py"])
def test_a_scene_far_off_is_told_as_near_by(scene, far, graph):
    sessions = [Session(where, [GRAPH.with_name(graph)], SIZE, validation=True) for where in (scene, far)]
    for session in sessions:
        session.apply({"do": "seed", "value": SEED})
        for _ in range(FRAMES):
            session.render()
    near, told = (session.inspector.guide(0, *FLOOR) for session in sessions)
    assert set(told["maps"]) == set(near["maps"]) and told["side"] == pytest.approx(near["side"], rel=1e-3)
    assert told["directions"] == pytest.approx(near["directions"], rel=0.3)
    for x in range(4, 28):
        if path := sessions[1].inspector.pixel(x, FLOOR[1])["paths"][0]:
            np.testing.assert_allclose(np.multiply(path["points"][0], SIZE), [x + 0.5, FLOOR[1] + 0.5], atol=0.05)


def test_a_graph_without_a_guide_refuses(scene):
    plain = Session(scene, [GRAPH], (16, 16), validation=True)
    assert not plain.state()["panes"][0]["guided"]
    with pytest.raises(UserError, match="no pass of type .*GuidingSplat"):
        plain.inspector.guide(0, 8, 8)
    told = plain.inspector.pixel(8, 8)
    assert told["reservoirs"] == [{}] and told["paths"] == [None]
