"""Where rays start: panes far from the origin and small ones, large tilted surfaces, walls that touch the floor, tubes of
long thin triangles, the largest scenes.

RUNS independent runs of FRAMES frames, 16 x 16, seeds fixed; 4 standard errors are a false alarm of 0.5% a case. The
rays themselves are tested by tests/trace/clearance_test.
"""

import math

import numpy as np
import pytest
from furnace_scenes import run_means, standard_errors_off
from renderer_scenes import ROOT, check_samples, make_renderer, restirpg

from restirpg.scenes import shapes
from restirpg.scenes.gltf import SceneFile, emitter, glass, lambert

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
    renderer = make_renderer(
        restirpg.load_scene(slope(tmp_path, 37)), restirpg.load_graph(ROOT / "graphs" / f"{graph}.py"), size=(16, 16)
    )
    renderer.render(RUNS * FRAMES)
    check_samples(renderer)
    image = renderer.output("image")
    assert image.mean() == pytest.approx(0.5, rel=0.01)
    assert image.min() > 0.3  # no pixel is black


@pytest.mark.parametrize("graph", ["path_tracer", "restir_di"])
def test_no_light_enters_a_closed_tube(tmp_path, graph):
    """Triangles of 20 m by 2.5 mm, closed at both ends, under an even sky: rays start inside, not a width away."""
    scene = SceneFile("tube", 0, environment=(1.0, 1.0, 1.0))
    tube = shapes.tube(np.array([(-10.0, 0.0, 0.0), (10.0, 0.0, 0.0)]), 0.025, 64)
    scene.add("Tube", (tube, lambert("Tube", (0.5, 0.5, 0.5), double_sided=True)))
    scene.add_camera((0, 0, 0), (0.05, 0.025, 0.01), 60.0)
    renderer = make_renderer(
        restirpg.load_scene(scene.write(tmp_path)), restirpg.load_graph(ROOT / "graphs" / f"{graph}.py"), size=(16, 16)
    )
    renderer.render(FRAMES)
    check_samples(renderer)
    assert renderer.output("image").max() == 0


@pytest.mark.parametrize("graph", ["path_tracer", "restir_di"])
@pytest.mark.parametrize("half", [6.8e8, 1e-3])
def test_the_largest_scene_is_lit_as_a_small_one(tmp_path, graph, half):
    """The middle of a floor below a lamp of its size; the larger scene is close to what the reader accepts."""
    scene = SceneFile("large", 0)
    scene.add("Floor", (shapes.quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)).scaled(half), lambert("Floor", (0.5, 0.5, 0.5))))
    lamp = shapes.quad((-1, -1, 0.5), (0, 2, 0), (2, 0, 0)).scaled(half)
    scene.add("Lamp", (lamp, emitter("Lamp", (1.0, 1.0, 1.0))))
    scene.add_camera((0, 0, 0.45 * half), (0, 0, 0), 2.0, up=(0, 1, 0))
    renderer = make_renderer(
        restirpg.load_scene(scene.write(tmp_path)),
        restirpg.load_graph(ROOT / "graphs" / f"{graph}.py"),
        size=(16, 16),
        bounces=0,
    )
    renderer.render(RUNS * FRAMES)
    check_samples(renderer)
    # The share of the hemisphere that a square takes, seen from a quarter of its side.
    share = 4 / math.pi * 2 / math.sqrt(5) * math.atan(2 / math.sqrt(5))
    assert renderer.output("image").mean() == pytest.approx(0.5 * share, rel=0.01)


@pytest.mark.parametrize("slabs", [2, 3])
def test_slabs_that_nearly_touch_reflect_at_all_sides(tmp_path, slabs):
    """Glazing, and a liquid between glasses: 6 mm each, 0.1 mm apart, 300 m from the origin."""
    scene = SceneFile(f"slabs_{slabs}", 8)
    at = np.array([300.0, 0.0, 300.0])
    for k in range(slabs):
        scene.add(
            f"Slab{k}", (shapes.box((-1, -1, 0.0061 * k), (1, 1, 0.0061 * k + 0.006)), glass("Glass")), at=at.tolist()
        )
    scene.add(
        "Wall", (shapes.quad((-4, -4, -1), (8, 0, 0), (0, 8, 0)), emitter("Wall", (1.0, 1.0, 1.0))), at=at.tolist()
    )
    scene.add_camera((at + [0, 0, 2]).tolist(), at.tolist(), 10.0)
    means = run_means(scene.write(tmp_path), RUNS, 4 * FRAMES, bounces=32)
    reflectance = 0.04
    exact = (1 - reflectance) / (1 + (2 * slabs - 1) * reflectance)  # Stokes: a pile of plates, all orders
    assert standard_errors_off(means, exact) < LIMIT


def behind_a_sheet(folder, distance):
    """The mean of 0.2 mm of a table, `distance` m behind the edge of a sheet of 0.4 mm that lies on it, lit across it
    at 45 degrees."""
    scene = SceneFile("contact", 0)
    white = lambert("White", (0.9, 0.9, 0.9))
    at = np.array([80.0, 0.0, 30.0])
    scene.add("Table", (shapes.quad((-50, 0, 50), (100, 0, 0), (0, 0, -100)), white), at=at.tolist())
    scene.add("Sheet", (shapes.box((0, 0, -0.1), (0.2, 4e-4, 0.1)), white), at=at.tolist())
    scene.add_spot("Lamp", (at + [10, 10, 0]).tolist(), at.tolist(), (1000.0, 1000.0, 1000.0))
    scene.add_camera(
        (at + [-distance, 0.1, 0.05]).tolist(),
        (at + [-distance, 0, 0.05]).tolist(),
        math.degrees(2e-4 / 0.1),
        up=(0, 0, 1),
    )
    renderer = make_renderer(restirpg.load_scene(scene.write(folder)), size=(16, 16))
    renderer.render(1)
    check_samples(renderer)
    return renderer.output("image").mean()


def test_a_sheet_on_a_table_shadows_up_to_its_edge(tmp_path):
    # The shadow ends 0.4 mm behind the edge, less the clearance of a table of 100 m: 0.07 mm.
    assert behind_a_sheet(tmp_path, 1.6e-4) == 0
    assert behind_a_sheet(tmp_path, 6e-4) > 0.1
