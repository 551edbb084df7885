"""A renderer whose camera, nodes and animations move."""

import json

import numpy as np
import pytest
from renderer_scenes import (
    GRAPH,
    SIZE,
    frame_graph,
    image_after,
    make_renderer,
    refusal,
    restirpg,
    write_far,
    write_flying_panel,
)

from restirpg.scenes import shapes
from restirpg.scenes.gltf import SceneFile, lambert


def test_the_camera_is_moved_in_parts(renderer):
    before = image_after(renderer, 1)
    pose = renderer.camera
    renderer.move_camera(position=(0.2, 1.0, 3.0))
    moved = renderer.camera
    np.testing.assert_allclose(moved["position"], (0.2, 1.0, 3.0), rtol=1e-6)
    assert (moved["target"], moved["up"], moved["yfov"]) == (pose["target"], pose["up"], pose["yfov"])
    renderer.cut()
    assert np.abs(image_after(renderer, 1) - before).mean() > 0.01
    renderer.move_camera(**pose)
    renderer.cut()
    np.testing.assert_allclose(image_after(renderer, 1).mean((0, 1)), before.mean((0, 1)), rtol=0.05)
    assert "field of view" in refusal(renderer.move_camera, yfov=4.0)
    assert "span" in refusal(renderer.move_camera, target=renderer.camera["position"])


def test_the_scenes_own_camera_is_followed_again(scene, tmp_path):
    renderer = make_renderer(scene, seed=1)
    before, pose = image_after(renderer, 1), renderer.camera
    renderer.move_camera(position=(0.2, 1.0, 3.0))
    renderer.render(1)
    renderer.follow_scene_camera()
    assert renderer.camera == pose
    renderer.seed = 1
    renderer.cut()
    assert image_after(renderer, 1).tobytes() == before.tobytes()
    renderer.save(tmp_path / "own.exr")
    assert "restirpg.pose" not in restirpg.read_exr_attributes(tmp_path / "own.exr")


def test_a_camera_far_from_the_origin_is_moved_to_where_it_stands(tmp_path):
    scene, eye, place = SceneFile("box", 0, environment=(1.0, 1.0, 1.0)), (-1.86, 0.0, 2.48), (4e6, 0.0, 4e6)
    scene.add("Box", (shapes.box((-1, -1, -1), (1, 1, 1)), lambert("Box", (0.5, 0.5, 0.5))))
    scene.add_camera(eye, (0, 0, 0))
    renderer = make_renderer(restirpg.load_scene(write_far(scene.write(tmp_path), tmp_path / "far.glb", place)))
    before = image_after(renderer, 1)
    pose = renderer.camera
    np.testing.assert_allclose(np.subtract(pose["position"], place), eye, atol=1e-6)
    renderer.move_camera(**pose)
    assert renderer.camera == pose
    renderer.cut()
    assert image_after(renderer, 1).tobytes() == before.tobytes()
    renderer.save(tmp_path / "a.exr")
    told = restirpg.read_exr_attributes(tmp_path / "a.exr")["restirpg.pose"].split(",")
    assert [float(x) for x in told[:9]] == [*pose["position"], *pose["target"], *pose["up"]]


def test_a_node_is_moved_by_a_matrix_whose_last_column_is_the_translation(scene):
    renderer = make_renderer(scene)
    before = image_after(renderer, 1)
    away = np.eye(4)
    away[:3, 3] = (0, 0, 100)  # behind the camera
    for name in ("Tower", "Prism"):
        renderer.move_node(name, away)
    renderer.cut()
    after = image_after(renderer, 1)
    lower = slice(SIZE[1] // 2, None)
    assert np.abs(after[lower] - before[lower]).mean() > 0.02
    assert "no node is named 'Towel'" in refusal(renderer.move_node, "Towel", away)
    assert "matrix (4, 4)" in refusal(renderer.move_node, "Tower", np.eye(3))


def test_nothing_has_moved_in_the_first_frame_of_a_run(scene):
    """Whatever ended the run before."""
    renderer = make_renderer(scene, outputs=["motion"])
    aside = np.eye(4)

    def motion_after(ending):
        renderer.render(1)
        renderer.move_camera(position=np.add(renderer.camera["position"], (0.1, 0, 0)))
        aside[0, 3] += 0.1
        renderer.move_node("Tower", aside)
        ending()
        return np.abs(image_after(renderer, 1, "motion")).max()

    assert motion_after(lambda: None) > 1
    for ending in (renderer.cut, renderer.reload, lambda: renderer.set("paths.bounces", 1)):
        assert motion_after(ending) < 1e-3


def test_what_was_behind_the_camera_has_no_motion(scene):
    """The camera, outside of the open box, turns round to where nothing is, and back."""
    renderer = make_renderer(scene, outputs=["motion", "material"])
    home = renderer.camera
    away = np.subtract(home["position"], home["target"]) + home["position"]
    for target, hits in ((home["target"], True), (away, False), (home["target"], True)):
        renderer.move_camera(target=target)
        motion = image_after(renderer, 1, "motion")
        assert (renderer.output("material").max() >= 0) == hits
        assert np.isnan(motion).all() == (renderer.frame > 1)
    assert np.abs(image_after(renderer, 1, "motion")).max() < 1e-3


def test_what_moved_has_moved_in_the_frame_that_is_rendered_after_one_that_failed(scene):
    renderer = make_renderer(scene, restirpg.load_graph(GRAPH.with_name("raw_pt_ruppert2020.py")), outputs=["motion"])
    renderer.render(1)
    aside = np.eye(4)
    aside[0, 3] = 0.1
    renderer.move_node("Tower", aside)
    renderer.set("splat.final_edges", "none")
    assert "final_edges" in refusal(renderer.render)
    renderer.set("splat.final_edges", "all")
    assert np.abs(image_after(renderer, 1, "motion")).max() > 1
    assert renderer.frame == 2


def test_the_animation_stands_at_the_frames_time(tmp_path):
    panel = restirpg.load_scene(write_flying_panel(tmp_path / "panel.gltf"))
    assert panel.duration == 1
    here, gone = 1.0, 0.0
    still, late, moving = (make_renderer(panel, frame_graph(), **options) for options in ({}, {"time": 2}, {"fps": 1}))
    for shown, expected in [(still, (here, here)), (late, (gone, gone)), (moving, (here, gone))]:
        for value in expected:
            np.testing.assert_allclose(image_after(shown, 1, "emission"), value)
    still.set_time(1)
    np.testing.assert_allclose(image_after(still, 1, "emission"), gone)


def test_frame_after_frame_the_time_stays_exact(tmp_path):
    file = write_flying_panel(tmp_path / "panel.gltf", times=(0, 1000))
    description = json.loads(file.read_text())
    description["animations"][0]["channels"][0]["target"]["node"] = 1  # the camera flies 0.1 m a second
    file.write_text(json.dumps(description))
    graph = restirpg.Graph("One kernel")
    graph.output("image", graph.add("gbuffer", "GBuffer").albedo)
    renderer = make_renderer(restirpg.load_scene(file), graph, size=(8, 8), fps=10, time=0.5)
    renderer.render(600)

    def seconds():
        return renderer.camera["position"][0] * 10

    assert seconds() == pytest.approx(60.5, rel=1e-6)
    renderer.cut()
    assert seconds() == pytest.approx(60.5, rel=1e-6)
    renderer.set_time(2)
    renderer.render(3)
    assert seconds() == pytest.approx(2.3, rel=1e-6)
