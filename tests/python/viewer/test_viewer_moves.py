"""The viewer's session: poses and cameras, moved by the user or by the scene's animation."""

import json

import numpy as np
import pytest
from renderer_scenes import GRAPH, restirpg, write_far
from viewer_sessions import SIZE, images

from restirpg.viewer import camera
from restirpg.viewer.session import Session


def test_a_pose_is_taken_as_it_is(scene_file, tmp_path):
    far = restirpg.load_scene(write_far(scene_file, tmp_path / "box.glb", (5.4e6, 0, 0)))
    session = Session(far, [GRAPH], SIZE, validation=True)
    before = session.camera
    assert before["position"][0] > 5e6
    session.apply({"do": "pose", **before, "yfov": 0.02})
    session.render()
    assert session.camera == {**before, "yfov": 0.02}
    assert session.panes[0].renderer.camera == {**before, "yfov": pytest.approx(0.02)}


def test_cameras_of_the_scene_and_what_is_copied_of_one(session):
    session.apply({"do": "orbit", "x": 0.1, "y": 0.2})
    state, moved = session.state(), session.camera
    assert state["cameras"] == ["Camera"]
    for pose in (json.loads(state["json"]), camera.from_option(camera.as_option(moved).partition("=")[2])):
        assert camera.same(pose, moved)
    session.apply({"do": "camera", "number": 0})
    assert camera.same(session.camera, session.home) and not camera.same(session.camera, moved)


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


def test_the_scenes_camera_moves_until_the_user_moves_it(passing):
    session = Session(passing, [GRAPH, GRAPH], SIZE, validation=True)
    session.render()
    start, revision = session.camera, session.revision
    assert images(session)[0].any()
    session.apply({"do": "speed", "factor": 30})
    session.render()
    assert session.time == 1 and not images(session)[0].any()
    assert session.camera["position"] == [100, 0, 0] and session.state()["camera"] == session.camera
    assert session.revision > revision + 1  # the page is told
    session.apply({"do": "speed", "factor": 0})
    session.apply({"do": "pose", **start})
    session.render()
    assert session.camera == start and images(session)[0].any()
    session.apply({"do": "time", "seconds": 0.5})
    session.render()
    assert session.camera == start  # a pose of the user's stays
    session.apply({"do": "home"})
    session.render()
    assert session.camera["position"] == [50, 0, 0] and session.panes[1].renderer.camera == session.camera
    session.apply({"do": "time", "seconds": 1})
    session.render()
    assert session.camera["position"] == [100, 0, 0] and session.panes[1].renderer.camera == session.camera


def test_a_camera_of_the_scene_is_taken_where_it_is_at_the_time_that_was_chosen(passing):
    """Both commands may come between two frames."""
    session = Session(passing, [GRAPH], SIZE, validation=True)
    session.apply({"do": "time", "seconds": 0.5})
    session.apply({"do": "camera", "number": 0})
    session.render()
    assert session.panes[0].renderer.camera["position"] == [50, 0, 0] and not session.follows


def test_a_moving_camera_is_at_home_in_its_reference_at_0_s(passing):
    truth = np.ones((*SIZE, 3), np.float32)
    session = Session(passing, [GRAPH], SIZE, truth, validation=True)
    session.render()
    assert session.truth() is not None
    session.apply({"do": "time", "seconds": 1})
    session.render()
    assert session.truth() is None
    session.apply({"do": "time", "seconds": 0})
    session.render()
    assert session.truth() is not None


def test_the_field_of_view_is_set_alone(session):
    session.apply({"do": "orbit", "x": 0.1, "y": 0.2})
    moved = session.camera
    session.apply({"do": "fov", "yfov": 0.5})
    assert session.camera == {**moved, "yfov": 0.5}
    session.apply({"do": "fov", "yfov": 7})
    assert 2.6 < session.camera["yfov"] < np.pi
    session.render()


@pytest.mark.parametrize("kind", [tuple, np.array, lambda values: np.array(values, np.float32)])
def test_a_pose_is_of_any_three_numbers(session, kind):
    pose = {"position": kind([0.0, 1.0, 5.0]), "target": kind([0.0, 1.0, 0.0]), "up": kind([0.0, 1.0, 0.0])}
    session.apply({"do": "pose", **pose, "yfov": np.float32(0.5)})
    assert session.camera == {"position": [0, 1, 5], "target": [0, 1, 0], "up": [0, 1, 0], "yfov": 0.5}
    session.frame()
    json.dumps(session.state())
