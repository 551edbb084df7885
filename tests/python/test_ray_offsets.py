"""Where rays start: panes far from the origin and small ones, large tilted surfaces, walls that touch the floor.

RUNS independent runs of FRAMES frames, 16 x 16, seeds fixed; 4 standard errors are a false alarm of 0.3% a case. The rays themselves are
tested by tests/trace/clearance_test.
"""

import sys

import numpy as np
import pytest
from furnace_scenes import run_means, standard_errors_off
from renderer_scenes import ROOT, make_renderer, restirpg

sys.path.insert(0, str(ROOT / "scripts"))

from scenes import shapes  # noqa: E402
from scenes.gltf import SceneFile, emitter, glass, lambert  # noqa: E402

RUNS, FRAMES, LIMIT = 8, 8, 4.0


def pane_before_light(folder, thickness, distance, scale):
    """A pane of solid glass before a wall of radiance 1; all of it far from the origin, and scaled."""
    scene = SceneFile(f"pane_{thickness}_{distance}_{scale}".replace(".", "_"), 8)
    at = np.array([distance, 0, distance]) * scale
    half = thickness / 2
    pane = shapes.box((-1, -1, -half), (1, 1, half)).scaled(scale)
    scene.add("Pane", (pane, glass("Glass")), at=at.tolist())
    wall = shapes.quad((-4, -4, -1), (8, 0, 0), (0, 8, 0)).scaled(scale)
    scene.add("Wall", (wall, emitter("Wall", (1.0, 1.0, 1.0))), at=at.tolist())
    scene.add_camera((at + [0, 0, 2 * scale]).tolist(), at.tolist(), 10.0)
    return scene.write(folder)


@pytest.mark.parametrize("thickness, distance, scale", [(0.006, 1000.0, 1.0), (0.0005, 300.0, 1.0), (0.006, 0.0, 1e-4)])
def test_a_pane_reflects_at_both_sides(tmp_path, thickness, distance, scale):
    reflectance = 0.04
    means = run_means(pane_before_light(tmp_path, thickness, distance, scale), RUNS, FRAMES, bounces=8)
    assert standard_errors_off(means, (1 - reflectance) / (1 + reflectance)) < LIMIT


def slope(folder, degrees):
    """A floor of 300 m, tilted, that fills the view under an even sky."""
    scene = SceneFile(f"slope_{degrees}", 0, environment=(1.0, 1.0, 1.0))
    floor = shapes.quad((-150, 0, 150), (300, 0, 0), (0, 0, -300)).turned("x", degrees).turned("z", 20)
    scene.add("Floor", (floor, lambert("Floor", (0.5, 0.5, 0.5))))
    scene.add_camera((60 * floor.normals[0]).tolist(), (0, 0, 0), 90.0)
    return scene.write(folder)


@pytest.mark.parametrize("graph", ["path_tracer", "restir_di"])
def test_a_large_slope_does_not_shadow_itself(tmp_path, graph):
    renderer = make_renderer(restirpg.load_scene(slope(tmp_path, 37)), restirpg.load_graph(ROOT / "graphs" / f"{graph}.py"), size=(16, 16))
    renderer.render(RUNS * FRAMES)
    image = renderer.output("image")
    assert image.mean() == pytest.approx(0.5, rel=0.01)
    assert image.min() > 0.3  # no pixel is black


def test_no_light_leaks_in_where_walls_touch_the_floor(tmp_path):
    scene = SceneFile("contact", 8, environment=(10.0, 10.0, 10.0))
    white = lambert("White", (0.9, 0.9, 0.9))
    scene.add("Floor", (shapes.quad((-50, 0, 50), (100, 0, 0), (0, 0, -100)), white), at=[80, 0, 30])
    scene.add("Room", (shapes.box((-1, 0, -1), (1, 1, 1)).inverted(), white), at=[80, 0, 30])  # its bottom lies in the floor
    scene.add_camera((80.7, 0.6, 30.8), (79.6, 0.0, 29.4), 80.0)
    renderer = make_renderer(restirpg.load_scene(scene.write(tmp_path)), size=(16, 16))
    renderer.render(32)
    assert np.all(renderer.output("image") == 0)
