"""Moves of the viewer's camera: what each leaves as it was, and which way it goes."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from restirpg.viewer import camera

POSE = {"position": [1.0, 2.0, 6.0], "target": [0.0, 1.0, 1.0], "up": [0.0, 1.0, 0.0], "yfov": 0.8}


def on_screen(pose, point):
    """Where a point appears: right and up over depth, and the depth."""
    right, up, forward = camera.axes(pose)
    offset = np.subtract(point, pose["position"])
    return np.array([offset @ right, offset @ up]) / (offset @ forward), offset @ forward


def test_an_orbit_keeps_target_and_distance_and_shows_the_other_side():
    moved = camera.orbit(POSE, 0.3, 0.1)
    assert moved["target"] == POSE["target"]
    assert camera.distance(moved) == pytest.approx(camera.distance(POSE))
    # The camera goes to the right: what is nearer than the target moves to the left.
    near = np.subtract(POSE["position"], POSE["target"]) * 0.5 + POSE["target"]
    assert on_screen(moved, near)[0][0] < on_screen(POSE, near)[0][0]
    assert moved["position"][1] > POSE["position"][1]


@pytest.mark.parametrize("move", [camera.orbit, camera.look])
@pytest.mark.parametrize("elevation", [10.0, -10.0])
def test_the_poles_are_never_reached(move, elevation):
    pose = POSE
    for _ in range(5):
        pose = move(pose, 1.0, elevation)
        assert np.isfinite(camera.axes(pose)).all()
        assert abs(np.dot(camera.axes(pose)[2], pose["up"])) < 0.99999


def test_a_look_keeps_the_position():
    moved = camera.look(POSE, 0.2, 0.0)
    assert moved["position"] == POSE["position"]
    assert on_screen(moved, POSE["target"])[0][0] > 0  # the head turned to the left


def test_a_pan_by_one_height_moves_the_target_by_one_height():
    moved = camera.pan(POSE, 0.25, 1.0)
    half = math.tan(POSE["yfov"] / 2)
    np.testing.assert_allclose(on_screen(moved, POSE["target"])[0], [-2 * half * 0.25, -2 * half], atol=1e-9)
    assert camera.distance(moved) == pytest.approx(camera.distance(POSE))


def test_a_dolly_shrinks_the_distance_and_never_passes_the_target():
    assert camera.distance(camera.dolly(POSE, math.log(2))) == pytest.approx(camera.distance(POSE) / 2)
    assert camera.distance(camera.dolly(POSE, 100.0)) > 0


def test_flying_forward_brings_the_target_nearer_without_turning():
    moved = camera.fly(POSE, 0.0, 0.0, 1.0)
    assert on_screen(moved, POSE["target"])[1] == pytest.approx(camera.distance(POSE) - 1)
    assert camera.distance(moved) == pytest.approx(camera.distance(POSE))  # the target flies along
    np.testing.assert_allclose(camera.axes(moved), camera.axes(POSE), atol=1e-12)
    np.testing.assert_allclose(np.subtract(moved["position"], POSE["position"]), camera.axes(POSE)[2], atol=1e-12)


def test_a_focus_changes_nothing_that_is_seen():
    moved = camera.focus(POSE, 2.5)
    assert camera.same(moved, POSE) and camera.distance(moved) == pytest.approx(2.5)
    assert not camera.same(camera.orbit(moved, 0.01, 0), POSE)


def test_poses_far_from_the_origin_are_told_apart():
    far = {**POSE, **{name: np.add(POSE[name], 4e6).tolist() for name in ("position", "target")}}
    assert camera.same(camera.focus(far, 2.5), far)
    assert not camera.same(camera.fly(far, 0.01, 0, 0), far)


def test_the_field_of_view_stays_a_pinhole_camera():
    assert math.tan(camera.zoom(POSE, 2.0)["yfov"] / 2) == pytest.approx(2 * math.tan(POSE["yfov"] / 2))
    assert 0 < camera.zoom(POSE, 1e-9)["yfov"] < camera.zoom(POSE, 1e9)["yfov"] < math.pi


def test_a_copied_pose_has_all_its_digits():
    values = np.random.default_rng(1).normal(size=10).tolist()
    pose = {"position": values[:3], "target": values[3:6], "up": values[6:9], "yfov": values[9]}
    for copied in (
        json.loads(camera.as_json(pose)),
        camera.from_option(camera.as_option(pose).partition("=")[2]),
        eval(camera.as_python(pose), {"renderer": SimpleNamespace(move_camera=dict)}),
    ):
        assert copied == pose
