"""The viewer's session without a network: what its commands do to the pictures, and what they refuse."""

import json
import shlex
import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image
from renderer_scenes import GRAPH, make_renderer, restirpg, scene, scene_file, write_flying_panel  # noqa: F401

from restirpg.harness import UserError
from restirpg.harness.render import native_file
from restirpg.viewer import camera, capture, pictures
from restirpg.viewer.session import Session
from restirpg.viewer.watch import Watch

SIZE = (16, 16)


@pytest.fixture(scope="module")
def reference(scene):
    """Some frames of the path tracer, as a reference."""
    renderer = make_renderer(scene, seed=77, size=SIZE)
    renderer.render(8)
    return renderer.output("image")


@pytest.fixture(scope="module")
def shared(scene, reference):
    """A session of two graphs that all tests use."""
    return Session(scene, [GRAPH, GRAPH], SIZE, reference, validation=True)


@pytest.fixture(scope="module")
def flying(tmp_path_factory):
    """A scene that its panel fills at 0 s and has left at 1 s."""
    return restirpg.load_scene(write_flying_panel(tmp_path_factory.mktemp("flying") / "panel.gltf"))


@pytest.fixture
def session(shared):
    """The session, as it was at first."""
    for pane in range(2):
        shared.apply({"do": "reset", "pane": pane})
        shared.apply({"do": "show", "pane": pane, "port": None})
    for message in (
        {"do": "reference", "source": "file"},
        {"do": "home"},
        {"do": "keep", "on": False},
        {"do": "play", "on": True},
        {"do": "view", "name": "image"},
        {"do": "exposure", "stops": 0},
        {"do": "seed", "value": 0},
    ):
        shared.apply(message)
    shared.render()
    return shared


def images(session):
    return [pane.picture().copy() for pane in session.panes]


def test_graphs_in_step_have_the_same_camera_and_random_numbers(session):
    session.apply({"do": "orbit", "x": 0.2, "y": 0.1})
    session.render()
    first, second = images(session)
    assert first.tobytes() == second.tobytes()
    session.apply({"do": "seed", "value": 5})
    session.render()
    assert images(session)[0].tobytes() == images(session)[1].tobytes() != first.tobytes()


def test_a_move_begins_the_mean_anew_and_rest_goes_on_with_it(session, scene):
    session.render()
    assert [pane.frames for pane in session.panes] == [2, 2]
    session.apply({"do": "pan", "x": 0.1, "y": 0.0})
    session.render()
    assert [pane.frames for pane in session.panes] == [1, 1]
    session.render()
    alone = make_renderer(scene, size=SIZE)
    alone.move_camera(**session.camera)
    alone.render(2)
    np.testing.assert_array_equal(images(session)[0], alone.output("image"))


def test_kept_history_averages_the_frames_since_the_last_move(session):
    session.apply({"do": "keep", "on": True})
    session.render()
    session.apply({"do": "pan", "x": 0.1, "y": 0.0})
    frames = []
    for _ in range(3):
        session.render()
        ports = session.panes[0].frame_ports
        frames.append(sum(session.panes[0].read(port) for port in ports))
    assert session.panes[0].renderer.frame == 4 and session.panes[0].frames == 3
    np.testing.assert_allclose(images(session)[0], np.mean(frames, 0), rtol=1e-5, atol=1e-6)


def test_a_knob_changes_its_own_graph_alone_and_can_be_reset(session):
    before = images(session)
    session.apply({"do": "set", "pane": 1, "knob": "paths.bounces", "value": 0})
    session.render()
    session.apply({"do": "restart"})
    session.render()
    after = images(session)
    assert after[0].tobytes() == before[0].tobytes() and after[1].mean() < 0.99 * after[0].mean()
    state = session.state()["panes"][1]
    knob = next(
        knob
        for entry in state["passes"]
        if entry["name"] == "paths"
        for knob in entry["knobs"]
        if knob["name"] == "bounces"
    )
    assert (knob["value"], knob["type"], knob["minimum"]) == (0, "uint", 0) and knob["meaning"] and knob["initial"] != 0
    assert state["arguments"] == "--set paths.bounces=0"
    session.apply({"do": "reset", "pane": 1})
    session.apply({"do": "restart"})
    session.render()
    assert images(session)[1].tobytes() == before[1].tobytes() and session.state()["panes"][1]["arguments"] == ""


def test_pause_holds_and_a_step_is_one_frame(session):
    session.apply({"do": "play", "on": False})
    assert not session.wants_frame()
    session.apply({"do": "step"})
    assert session.wants_frame()
    session.render()
    assert not session.wants_frame() and session.panes[0].frames == 2
    session.apply({"do": "dolly", "amount": 0.1})
    assert session.wants_frame()  # a paused picture follows the camera


def test_errors_are_those_against_the_reference_while_the_camera_is_at_home(session, reference):
    expected = restirpg.measure_errors(images(session)[0], reference)["mape"]
    assert session.errors() == [pytest.approx(expected)] * 2
    relative = pictures.relative_difference(images(session)[0], reference)
    assert relative.mean() == pytest.approx(expected, rel=1e-4)
    session.apply({"do": "orbit", "x": 0.1, "y": 0.0})
    session.render()
    assert session.errors() == [None, None]


def test_the_difference_of_equal_pictures_is_black(session):
    session.apply({"do": "view", "name": "difference"})
    (black,) = session._shown()
    assert not black.any()
    session.apply({"do": "set", "pane": 1, "knob": "paths.bounces", "value": 0})
    session.render()
    assert session._shown()[0].any()


def test_any_image_port_is_shown_also_one_that_nobody_reads(session):
    session.apply({"do": "show", "pane": 0, "port": "gbuffer.normal"})
    session.render()
    normal = session.panes[0].read("gbuffer.normal")
    np.testing.assert_allclose(np.linalg.norm(normal, axis=-1).max(), 1, rtol=1e-3)
    assert session.frame().images[0] != session.frame().images[1]
    with pytest.raises(restirpg.Error, match="no image port 'gbuffer.surface'"):
        session.apply({"do": "show", "pane": 0, "port": "gbuffer.surface"})


def test_a_pixel_tells_what_it_sees(session):
    session.apply({"do": "restart"})  # which leaves no picture: one is rendered
    pixel = session.inspector.pixel(8, 8)
    assert pixel["geometry"]["depth"] > 1
    np.testing.assert_allclose(pixel["panes"][0]["picture"], images(session)[0][8, 8])
    session.apply({"do": "focus", "x": 8, "y": 8})
    distance = np.linalg.norm(np.subtract(session.camera["target"], session.camera["position"]))
    assert distance == pytest.approx(pixel["geometry"]["depth"], rel=1e-5)


@pytest.mark.parametrize(
    "message, words",
    [
        ({"do": "vanish"}, "no command 'vanish'"),
        ({"do": ["show"]}, r"no command \['show'\]"),
        ({"do": "show", "pane": 0, "port": ["image"]}, "no image port"),
        ({"do": "show", "pane": 0, "port": {}}, "no image port"),
        ({"do": "orbit", "x": 1}, "missing a required argument: 'y'"),
        ({"do": "orbit", "x": float("nan"), "y": 0}, "no number"),
        ({"do": "pan", "x": "1", "y": 0}, "no number"),
        ({"do": "set", "pane": 2, "knob": "a.b", "value": 1}, "no graph 2"),
        ({"do": "view", "name": "../x"}, "no view"),
        ({"do": "set", "pane": 0, "knob": "paths.bounces", "value": "many"}, "bounces"),
        ({"do": "pose", "position": [0, 0, 0], "target": [0, 1, 0], "up": [0, 1, 0], "yfov": 1}, "span no view"),
        ({"do": "camera", "number": 1}, "the scene has 1"),
        ({"do": "reference", "source": "../x"}, "no reference"),
        ({"do": "film", "frames": 3, "kind": "png"}, "--captures"),
        ({"do": "__init__"}, "no command"),
        ({}, "no command None"),
    ],
)
def test_what_cannot_be_done_is_refused_and_changes_nothing(session, message, words):
    before, revision = session.camera, session.revision
    with pytest.raises((UserError, restirpg.Error), match=words):
        session.apply(message)
    assert session.camera == before and session.revision == revision
    session.render()


def test_a_reference_is_traced_while_the_view_rests(session):
    session.apply({"do": "reference", "source": "traced"})
    session.apply({"do": "orbit", "x": 0.1, "y": 0.0})
    assert session.errors() == [None, None] and not session.trace_reference()  # the move is not rendered yet
    session.render()
    for _ in range(3):
        assert session.trace_reference()
    truth = session.truth()
    np.testing.assert_allclose(
        session.errors(), [restirpg.measure_errors(picture, truth)["mape"] for picture in images(session)]
    )
    assert session.frame().header["reference_frames"] == 3 and truth.tobytes() != images(session)[0].tobytes()
    session.apply({"do": "set", "pane": 0, "knob": "paths.bounces", "value": 1})  # the reference's bounce cap follows
    assert session.errors() == [None, None]
    session.render()
    session.trace_reference()
    assert session.frame().header["reference_frames"] == 1 and session.truth().mean() < truth.mean()
    session.apply({"do": "view", "name": "error"})
    assert session._shown()[0].any()
    session.apply({"do": "reference", "source": "none"})
    assert session.view == "image" and session.errors() == [None, None] and not session.trace_reference()


def test_cameras_of_the_scene_and_what_is_copied_of_one(session):
    session.apply({"do": "orbit", "x": 0.1, "y": 0.2})
    state, moved = session.state(), session.camera
    assert state["cameras"] == ["Camera"]
    for pose in (json.loads(state["json"]), camera.from_option(camera.as_option(moved).partition("=")[2])):
        assert camera.same(pose, moved)
    session.apply({"do": "camera", "number": 0})
    assert camera.same(session.camera, session.home) and not camera.same(session.camera, moved)


def rendered_by_command(session, pane, file):
    """What the command line renders that a page copies of a frame."""
    _, *arguments = shlex.split(session.frame().header["panes"][pane]["command"])
    arguments[-1] = file
    subprocess.run([native_file().parents[2] / "bin" / "restirpg", *arguments], check=True)
    return restirpg.read_exr(file)


def test_the_command_line_that_is_copied_renders_the_picture(session, tmp_path):
    session.apply({"do": "orbit", "x": 0.1, "y": 0.2})
    session.apply({"do": "pose", **json.loads(session.state()["json"])})  # as many digits as the command line has
    session.apply({"do": "set", "pane": 1, "knob": "paths.bounces", "value": 1})
    session.render()
    session.render()
    file = tmp_path / "out.exr"
    assert rendered_by_command(session, 1, file).tobytes() == images(session)[1].tobytes()
    assert camera.same(camera.from_option(restirpg.read_exr_attributes(file)["restirpg.pose"]), session.camera)
    session.apply({"do": "show", "pane": 0, "port": "gbuffer.normal"})
    session.render()
    assert rendered_by_command(session, 0, file).tobytes() == session.panes[0].read("gbuffer.normal").tobytes()


def test_the_command_line_is_of_the_animation_as_it_is_now(flying, tmp_path):
    session = Session(flying, [GRAPH], SIZE, validation=True)
    session.apply({"do": "speed", "factor": 0.9})
    for _ in range(3):
        session.render()
    (picture,) = images(session)
    assert 0 < picture.mean() < 1  # the panel is on its way
    assert rendered_by_command(session, 0, tmp_path / "out.exr").tobytes() == picture.tobytes()


def test_the_options_of_the_viewer_are_in_the_command_line(scene, tmp_path):
    options = {"device": 0, "bounces": 1, "energy_compensation": True}
    session = Session(scene, [GRAPH], SIZE, allow_outside=True, validation=True, **options)
    session.apply({"do": "pose", **json.loads(session.state()["json"])})  # as many digits as the command line has
    session.render()
    command = session.frame().header["panes"][0]["command"]
    for words in ("--allow-outside", "--device 0", "--energy-compensation", "--set paths.bounces=1"):
        assert words in command
    assert rendered_by_command(session, 0, tmp_path / "out.exr").tobytes() == images(session)[0].tobytes()


def test_the_bounce_cap_of_the_viewer_is_a_setting_of_each_graph(scene):
    (pane,) = Session(scene, [GRAPH], SIZE, validation=True, bounces=1).panes
    assert pane.settings == {"paths.bounces": 1} and pane.bounces == 1 and not pane.changed
    pane.set("paths.bounces", 3)
    assert pane.settings == {"paths.bounces": 3} and pane.bounces == 3
    pane.set("paths.bounces", None)  # as the viewer began
    assert pane.settings == {"paths.bounces": 1} and pane.bounces == 1
    (entry,) = (entry for entry in json.loads(capture._graph(None, pane))["passes"] if entry["name"] == "paths")
    assert entry["knobs"]["bounces"] == 1


def test_a_port_that_nobody_reads_is_shown_at_the_time_of_the_scene(flying):
    session = Session(flying, [GRAPH], SIZE, validation=True)
    session.apply({"do": "time", "seconds": 1})
    session.render()
    assert not images(session)[0].any()
    old = session.panes[0].renderer
    session.apply({"do": "show", "pane": 0, "port": "gbuffer.normal"})
    session.render()
    assert session.panes[0].renderer is not old
    assert not session.panes[0].read("gbuffer.normal").any() and not images(session)[0].any()


def depth_graph():
    """A graph whose picture has one channel."""
    graph = restirpg.Graph("Depth")
    graph.output("depth", graph.add("gbuffer", "GBuffer").depth)
    return graph


def test_a_picture_of_one_channel_has_no_error_and_is_shown(scene):
    session = Session(scene, [depth_graph(), GRAPH, depth_graph()], SIZE, validation=True)
    session.apply({"do": "reference", "source": "traced"})
    session.render()
    assert session.trace_reference()
    session.apply({"do": "view", "name": "error"})
    assert [error is None for error in session.errors()] == [True, False, True]
    assert len(session.frame().images) == 3
    np.testing.assert_array_equal(session._shown()[0], session.pixels(session.panes[0]))


def test_depths_have_a_difference(scene):
    session = Session(scene, [depth_graph(), depth_graph()], SIZE, validation=True)
    session.apply({"do": "view", "name": "difference"})
    session.render()
    assert len(session.frame().images) == 1 and not session._shown()[0].any()


def test_a_film_is_numbered_pictures_of_every_graph(session, tmp_path, monkeypatch):
    monkeypatch.setattr(session, "captures", tmp_path)
    for kind, frames in (("png", 3), ("exr", 2)):
        session.apply({"do": "film", "frames": frames, "kind": kind})
        folder = session.film.folder
        while session.film:
            assert session.wants_frame() and session.film.told()["count"] == frames
            session.render()
        folders = sorted(folder.iterdir())
        assert folder.parent == tmp_path and [made.name[:2] for made in folders] == ["1_", "2_"]
        for made in folders:
            assert sorted(file.name for file in made.iterdir()) == [f"{i + 1:05}.{kind}" for i in range(frames)]
    assert restirpg.read_exr_attributes(folders[0] / "00002.exr")["restirpg.seed"] == "0"
    np.testing.assert_array_equal(restirpg.read_exr(folders[1] / "00002.exr"), images(session)[1])
    with Image.open(next(tmp_path.glob("film*/1_*/00003.png"))) as picture:
        assert (
            picture.size == SIZE
            and json.loads(picture.text["restirpg.graph"])["passes"]
            and picture.text["restirpg.seed"] == "0"
        )


def test_captures(session, tmp_path):
    session.apply({"do": "set", "pane": 0, "knob": "paths.alpha", "value": 0.25})
    session.render()
    exr = tmp_path / "capture.exr"
    exr.write_bytes(capture.make(session, "outputs.exr", "0")[0])
    np.testing.assert_array_equal(restirpg.read_exr(exr), images(session)[0])
    assert '"alpha":0.25' in restirpg.read_exr_attributes(exr)["restirpg.knobs"].replace(" ", "")
    graph = tmp_path / "graph.json"
    graph.write_bytes(capture.make(session, "graph.json", "0")[0])
    assert make_renderer(session.scene, restirpg.load_graph(graph), size=SIZE).get("paths.alpha") == 0.25
    assert capture.make(session, "picture.png", "1")[0].startswith(b"\x89PNG")
    for name, pane in (("secret.txt", "0"), ("picture.png", "2"), ("picture.png", "x")):
        with pytest.raises(UserError):
            capture.make(session, name, pane)


def test_a_reload_takes_edits_and_keeps_the_old_graph_when_they_are_wrong(scene, tmp_path):
    file = tmp_path / "own.py"
    file.write_text(GRAPH.read_text().replace("graph = ", "graph = ", 1))
    session = Session(scene, [file], SIZE, validation=True)
    session.apply({"do": "orbit", "x": 0.1, "y": 0.0})
    session.render()
    old = session.panes[0].renderer
    file.write_text("from restirpg import Graph\ngraph = Graph('broken')\ngraph.add('x', 'NoSuchPass')\n")
    with pytest.raises(UserError, match=r"own.py:3: .*NoSuchPass"):
        session.apply({"do": "reload"})
    assert session.panes[0].renderer is old
    file.write_text(GRAPH.read_text() + "\ngraph.name = 'Edited'\n")
    session.apply({"do": "reload"})
    assert session.panes[0].renderer is not old and session.panes[0].name == "Edited"
    session.render()
    assert session.panes[0].frames == 1


def test_a_shader_that_does_not_compile_is_located_and_the_old_one_goes_on(scene, tmp_path, monkeypatch):
    shaders = tmp_path / "shaders"
    shutil.copytree(GRAPH.parents[1] / "framework" / "shaders", shaders)
    monkeypatch.setenv("RESTIRPG_SHADERS", str(shaders))
    session = Session(scene, [GRAPH], SIZE, validation=True)
    watch = Watch([GRAPH])
    edited, good = shaders / "math/random.glsl", (shaders / "math/random.glsl").read_text()
    edited.write_text(good + "\nthis is no GLSL\n")
    monkeypatch.setattr("restirpg.viewer.watch._SECONDS", 0.0)
    assert watch.changed() == [str(edited)] and watch.changed() == []
    with pytest.raises(UserError, match=rf"random.glsl:{good.count(chr(10)) + 2}"):
        session.apply({"do": "reload"})
    session.render()
    assert session.panes[0].frames == 1
    edited.write_text(good)
    session.apply({"do": "reload"})
    session.render()
