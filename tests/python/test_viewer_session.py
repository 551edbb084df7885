"""The viewer's session without a network: what its commands do to the pictures, and what they refuse."""

import io
import json
import shlex
import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image
from renderer_scenes import GRAPH, make_renderer, restirpg, write_far, write_flying_panel

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


@pytest.mark.parametrize("ask", [lambda session: session.inspector.pixel(8, 8), lambda session: session.frame(),
                                 lambda session: capture.make(session, "picture.png", "0")])  # fmt: skip
def test_what_is_asked_for_right_after_a_move_is_of_the_new_view(session, scene, ask):
    """Both commands may come between two frames."""
    session.apply({"do": "orbit", "x": 0.2, "y": 0.1})
    ask(session)
    alone = make_renderer(scene, size=SIZE)
    alone.move_camera(**session.camera)
    alone.render(1)
    np.testing.assert_array_equal(images(session)[0], alone.output("image"))


def test_a_pixel_is_told_whatever_the_renderers_are_made_with(scene):
    options = {"outputs": ["frame"], "bounces": 1, "seed": 3, "energy_compensation": True}
    session = Session(scene, [GRAPH], SIZE, validation=True, **options)
    assert session.inspector.pixel(8, 8)["geometry"]["depth"] > 1


def test_a_pixel_that_misses_has_no_geometry(flying):
    """A G-buffer has material -1 and normal 0 0 0 there."""
    session = Session(flying, [GRAPH], SIZE, validation=True)
    assert session.inspector.pixel(8, 8)["geometry"]["material"] == 0
    session.apply({"do": "time", "seconds": 1})
    session.render()
    assert session.inspector.pixel(8, 8)["geometry"] is None


def test_a_pose_is_taken_as_it_is(scene_file, tmp_path):
    far = restirpg.load_scene(write_far(scene_file, tmp_path / "box.glb", (5.4e6, 0, 0)))
    session = Session(far, [GRAPH], SIZE, validation=True)
    before = session.camera
    assert before["position"][0] > 5e6
    session.apply({"do": "pose", **before, "yfov": 0.02})
    session.render()
    assert session.camera == {**before, "yfov": 0.02}
    assert session.panes[0].renderer.camera == {**before, "yfov": pytest.approx(0.02)}


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
        ({"do": "pose", "position": [0, 0, 0], "target": [0, 1, 0], "up": [0, 1, 0], "yfov": 1}, "not span a view"),
        ({"do": "pose", "position": [1e30, 0, 0], "target": [0, 1, 0], "up": [0, 1, 0], "yfov": 1}, "nearer to 0"),
        ({"do": "pose", "position": [0, 0, 0], "target": [0, 0, 1], "up": [0, 1, 0], "yfov": 3.2}, "no pinhole camera"),
        ({"do": "pose", "position": [0, 0, 0], "target": [0, 0, 1], "up": [0, 1, 0], "yfov": 10**400}, "no number"),
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
    assert session.errors()[0] is not None and session.errors()[1] is None  # whose cap is another
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


def test_an_animation_stops_where_it_ends(flying, scene):
    session = Session(flying, [GRAPH], SIZE, validation=True)
    session.apply({"do": "time", "seconds": 0.95})
    session.apply({"do": "speed", "factor": 1})
    times, frames = [], []
    for _ in range(4):
        session.render()
        times.append(session.time)
        frames.append(session.panes[0].frames)
    assert times == pytest.approx([0.95 + 1 / 30, 1, 1, 1]) and frames == [1, 1, 2, 3]
    session.apply({"do": "speed", "factor": -100})
    session.render()
    assert session.time == 0
    still = Session(scene, [GRAPH], SIZE, validation=True)
    still.apply({"do": "speed", "factor": 1})
    for _ in range(2):
        still.render()
    assert (still.time, still.panes[0].frames) == (0, 2)  # nothing moves in this scene


def write_sky(file):
    """A sky that is bluer above. Returns the file's name."""
    restirpg.write_exr(file, {"": np.linspace((1, 2, 4), (1, 1, 1), 8).repeat(16, 0).reshape(8, 16, 3)})
    return str(file)


@pytest.mark.parametrize("sky", [lambda folder: "0.5,0.25,0.125", lambda folder: write_sky(folder / "a sky.exr")])
def test_the_options_of_the_viewer_are_in_the_command_line(scene_file, sky, tmp_path):
    scene = restirpg.load_scene(scene_file, environment=sky(tmp_path))
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


def test_the_traced_reference_has_the_pixel_filter_of_the_graphs(scene):
    """At the centres of pixels a picture's mean is another than over their area."""
    session = Session(scene, [GRAPH.with_name("restir_pt.py"), GRAPH], SIZE, validation=True)
    session.apply({"do": "reference", "source": "traced"})
    session.render()
    session.trace_reference()
    centres = session.truth()
    assert [error is None for error in session.errors()] == [False, True]
    session.apply({"do": "set", "pane": 0, "knob": "gbuffer.jitter", "value": True})
    session.render()
    session.trace_reference()
    assert None not in session.errors() and session.truth().tobytes() != centres.tobytes()


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
        assert session.frame().header["filmed"] == str(folder)  # though no page has seen it begin
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


def test_with_kept_history_files_are_of_what_is_shown_and_no_command_line_is(session, tmp_path, monkeypatch):
    monkeypatch.setattr(session, "captures", tmp_path)
    session.apply({"do": "keep", "on": True})
    session.render()
    session.apply({"do": "pan", "x": 0.1, "y": 0.0})
    session.apply({"do": "film", "frames": 3, "kind": "exr"})
    folder = session.film.folder
    while session.film:
        session.render()
    exr = tmp_path / "capture.exr"
    data, _, name = capture.make(session, "outputs.exr", "1")
    exr.write_bytes(data)
    for file in (exr, next(folder.glob("2_*/00003.exr"))):
        np.testing.assert_array_equal(restirpg.read_exr(file), images(session)[1])
        header = restirpg.read_exr_attributes(file)
        assert header["restirpg.frames"] == "3" and header["restirpg.history"] == "kept over moves of the camera"
        assert camera.same(camera.from_option(header["restirpg.pose"]), session.camera)
    assert name.endswith("_3.exr")
    with Image.open(io.BytesIO(capture.make(session, "picture.png", "1")[0])) as picture:
        assert picture.text["restirpg.history"] == "kept over moves of the camera"
    assert [pane["command"] for pane in session.frame().header["panes"]] == [None, None]
    session.apply({"do": "keep", "on": False})
    session.render()
    exr.write_bytes(capture.make(session, "outputs.exr", "1")[0])
    assert "restirpg.history" not in restirpg.read_exr_attributes(exr)
    assert None not in [pane["command"] for pane in session.frame().header["panes"]]


def test_with_kept_history_a_picture_of_one_channel_is_saved(scene, tmp_path):
    session = Session(scene, [depth_graph()], SIZE, validation=True)
    session.apply({"do": "keep", "on": True})
    session.render()
    exr = tmp_path / "depth.exr"
    exr.write_bytes(capture.make(session, "outputs.exr", "0")[0])
    np.testing.assert_array_equal(restirpg.read_exr(exr)[..., :1], images(session)[0])


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


def test_a_port_that_an_edit_takes_away_gives_way_to_the_picture(scene, tmp_path):
    file, text = tmp_path / "own.py", GRAPH.read_text()
    file.write_text(text)
    session = Session(scene, [file], SIZE, validation=True)
    session.apply({"do": "show", "pane": 0, "port": "paths.radiance"})
    file.write_text(text + "\ngraph.name = 'Edited'\n")
    session.apply({"do": "reload"})
    assert session.panes[0].name == "Edited" and session.panes[0].port == "paths.radiance"
    file.write_text("from restirpg import Graph\ngraph = Graph('broken')\ngraph.add('x', 'NoSuchPass')\n")
    with pytest.raises(UserError, match=r"own.py:3: .*NoSuchPass"):
        session.apply({"do": "reload"})
    assert session.panes[0].port == "paths.radiance"
    file.write_text(text.replace('"paths"', '"tracer"'))
    session.apply({"do": "reload"})
    session.render()
    assert "tracer.radiance" in session.panes[0].ports and session.panes[0].port is None
    assert len(session.frame().images) == 1


@pytest.fixture
def shaders(tmp_path, monkeypatch):
    """A copy of the GLSL library, which renderers take from here on."""
    folder = tmp_path / "shaders"
    shutil.copytree(GRAPH.parents[1] / "framework" / "shaders", folder)
    monkeypatch.setenv("RESTIRPG_SHADERS", str(folder))
    return folder


def test_the_reference_and_the_probe_are_of_the_edited_shaders_too(scene, shaders):
    def looked_at(session):
        session.render()
        session.trace_reference()
        assert session.frame().header["reference_frames"] == 1
        return images(session)[0], session.truth(), session.inspector.geometry(2, 5)

    session, fresh = (Session(scene, [GRAPH], SIZE, validation=True) for _ in range(2))
    session.apply({"do": "reference", "source": "traced"})
    before = looked_at(session)
    camera_file = shaders / "scene/camera.glsl"
    left_to_right = camera_file.read_text()
    mirrored = left_to_right.replace("2.0 * point.x / size.x - 1.0", "1.0 - 2.0 * point.x / size.x")
    assert mirrored != left_to_right
    camera_file.write_text(mirrored + "\nthis is no GLSL\n")
    with pytest.raises(UserError, match="camera.glsl"):
        session.apply({"do": "reload"})
    np.testing.assert_equal((session.truth(), session.inspector.geometry(2, 5)), before[1:])
    camera_file.write_text(mirrored)
    session.apply({"do": "reload"})
    fresh.apply({"do": "reload"})
    fresh.apply({"do": "reference", "source": "traced"})
    after = looked_at(session)
    np.testing.assert_equal(after, looked_at(fresh))
    assert after[2] != before[2]


def test_a_shader_that_does_not_compile_is_located_and_the_old_one_goes_on(scene, shaders, monkeypatch):
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
