"""What the viewer gives away: the command line of a picture, films, captures."""

import io
import json
import shlex
import subprocess

import numpy as np
import pytest
from PIL import Image
from renderer_scenes import GRAPH, make_renderer, restirpg, write_far
from viewer_sessions import SIZE, depth_graph, images

from restirpg.harness import UserError
from restirpg.harness.render import native_file
from restirpg.viewer import camera, capture
from restirpg.viewer.session import Session


def rendered_by_command(session, pane, file):
    """What the command line renders that a page copies of a frame."""
    _, *arguments = shlex.split(session.frame().header["panes"][pane]["command"])
    arguments[-1] = file
    subprocess.run([native_file().parents[2] / "bin" / "restirpg", *arguments], check=True)
    return restirpg.read_exr(file)


def test_the_command_line_that_is_copied_renders_the_picture(session, tmp_path):
    session.apply({"do": "orbit", "x": 0.1, "y": 0.2})
    session.apply({"do": "set", "pane": 1, "knob": "paths.bounces", "value": 1})
    session.render()
    session.render()
    file = tmp_path / "out.exr"
    assert rendered_by_command(session, 1, file).tobytes() == images(session)[1].tobytes()
    assert camera.same(camera.from_option(restirpg.read_exr_attributes(file)["restirpg.pose"]), session.camera)
    session.apply({"do": "show", "pane": 0, "port": "gbuffer.normal"})
    session.render()
    assert rendered_by_command(session, 0, file).tobytes() == session.panes[0].read("gbuffer.normal").tobytes()


def test_the_command_line_that_is_copied_renders_a_scene_far_from_the_origin(scene_file, tmp_path):
    far = restirpg.load_scene(write_far(scene_file, tmp_path / "far.glb", (4e6, 0, 0)))
    session = Session(far, [GRAPH], SIZE, validation=True)
    session.apply({"do": "orbit", "x": 0.1, "y": 0.2})
    session.render()
    assert rendered_by_command(session, 0, tmp_path / "out.exr").tobytes() == images(session)[0].tobytes()


def test_the_command_line_is_of_the_animation_as_it_is_now(flying, tmp_path):
    session = Session(flying, [GRAPH], SIZE, validation=True)
    session.apply({"do": "speed", "factor": 0.9})
    for _ in range(3):
        session.render()
    (picture,) = images(session)
    assert 0 < picture.mean() < 1  # the panel is on its way
    assert rendered_by_command(session, 0, tmp_path / "out.exr").tobytes() == picture.tobytes()


def test_a_file_of_the_scenes_own_camera_says_of_no_other(passing, tmp_path):
    def header():
        exr = tmp_path / "capture.exr"
        exr.write_bytes(capture.make(session, "outputs.exr", "0")[0])
        np.testing.assert_array_equal(restirpg.read_exr(exr), images(session)[0])
        np.testing.assert_array_equal(restirpg.read_exr(exr, "frame"), session.panes[0].renderer.output("frame"))
        return restirpg.read_exr_attributes(exr)

    session = Session(passing, [GRAPH], SIZE, validation=True, outputs=["frame", "surface"])
    session.apply({"do": "time", "seconds": 0.05})
    session.render()
    assert "restirpg.pose" not in header()
    assert rendered_by_command(session, 0, tmp_path / "out.exr").tobytes() == images(session)[0].tobytes()
    session.apply({"do": "orbit", "x": 0.1, "y": 0.0})
    assert "restirpg.pose" in header()
    session.apply({"do": "home"})
    assert "restirpg.pose" not in header() and header()["restirpg.time"] == "0.05"


def write_sky(file):
    """A sky that is bluer above. Returns the file's name."""
    restirpg.write_exr(file, {"": np.linspace((1, 2, 4), (1, 1, 1), 8).repeat(16, 0).reshape(8, 16, 3)})
    return str(file)


@pytest.mark.parametrize("sky", [lambda folder: "0.5,0.25,0.125", lambda folder: write_sky(folder / "a sky.exr")])
def test_the_options_of_the_viewer_are_in_the_command_line(scene_file, sky, tmp_path):
    scene = restirpg.load_scene(scene_file, environment=sky(tmp_path))
    options = {"device": 0, "bounces": 1, "energy_compensation": True}
    session = Session(scene, [GRAPH], SIZE, allow_outside=True, validation=True, **options)
    session.apply({"do": "home"})  # the command line moves the camera there too
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


def test_a_film_is_numbered_pictures_of_every_graph(session, tmp_path, monkeypatch):
    monkeypatch.setattr(session, "captures", tmp_path)
    for kind, frames in (("png", 3), ("exr", 2)):
        session.apply({"do": "film", "frames": frames, "kind": kind})
        folder = session.film.folder
        while session.film:
            assert session.wants_frame() and session.state()["film"]["count"] == frames
            session.render()
        assert session.state()["filmed"] == str(folder)  # though no page has seen it begin
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


def test_a_film_pauses_and_takes_single_steps(session, tmp_path, monkeypatch):
    monkeypatch.setattr(session, "captures", tmp_path)
    session.apply({"do": "film", "frames": 5, "kind": "png"})
    session.render()
    session.apply({"do": "play", "on": False})
    assert not session.wants_frame()
    session.apply({"do": "orbit", "x": 0.1, "y": 0.0})
    session.render()  # a paused picture follows the camera
    assert session.state()["film"] == {"done": 1, "count": 5}
    session.apply({"do": "step"})
    session.render()
    assert session.state()["film"]["done"] == 2 and not session.wants_frame()
    session.apply({"do": "play", "on": True})
    session.render()
    assert session.state()["film"]["done"] == 3
    session.apply({"do": "film", "frames": 0, "kind": "png"})


def test_a_second_film_takes_the_end_of_the_first(session, tmp_path, monkeypatch):
    monkeypatch.setattr(session, "captures", tmp_path)
    session.apply({"do": "film", "frames": 2, "kind": "png"})
    film = session.film
    with pytest.raises(UserError, match="stop it before the next one"):
        session.apply({"do": "film", "frames": 2, "kind": "png"})
    assert session.film is film
    session.apply({"do": "film", "frames": 0, "kind": "png"})
    assert session.state()["film"] is None


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
