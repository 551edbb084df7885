"""Emitters whose texture lights a small part of them, that grow out of nothing, and that stand in an absorbing solid.

Null hypothesis of each comparison: both scenes have one expected image mean. RUNS independent runs of FRAMES frames,
16 x 16, seeds fixed; 4 standard errors of Welch's difference are a false alarm of 0.03% a case. Variances of RUNS runs
are within a factor of 3.4 of each other but for 0.5% of the time (F test, 23 degrees of freedom each).
"""

import numpy as np
import pytest
from furnace_scenes import run_means
from renderer_scenes import ROOT, check_samples, make_renderer, restirpg

from restirpg.scenes import shapes
from restirpg.scenes.gltf import SceneFile, Texture, emitter, lambert

RUNS, FRAMES, LIMIT, VARIANCE_RATIO = 24, 2, 4.0, 3.4
SIDE = 96  # texels of a sign


def room(name):
    """A floor that the camera looks down on; lamps hang above."""
    scene = SceneFile(name, 0)
    scene.add("Floor", (shapes.quad((-1, 0, 1), (2, 0, 0), (0, 0, -2)), lambert("White", (0.8, 0.8, 0.8))))
    scene.add_camera((0.0, 1.5, 1.2), (0, 0, 0), 40.0)
    return scene


def sign_scene(folder, name, pixels, nearest):
    """A square sign of these texels."""
    scene = room(name)
    texture = Texture(np.repeat(pixels[..., None], 3, axis=2), nearest)
    sign = shapes.quad((-0.5, 1, -0.5), (1, 0, 0), (0, 0, 1))
    scene.add("Sign", (sign, emitter("Sign", (1e4,) * 3, emission_texture=texture)))
    return scene.write(folder)


def texel_scene(folder, name, row, column):
    """The square that one texel of the sign covers, of the sign's radiance."""
    scene = room(name)
    sign = shapes.quad((-0.5, 1, -0.5), (1, 0, 0), (0, 0, 1))
    lit = np.array([column, row]) / SIDE
    # Texture coordinates are affine over the sign.
    place = np.linalg.lstsq(np.c_[sign.uvs, np.ones(4)], sign.positions, rcond=None)[0]
    corner, right, down = np.r_[lit, 1] @ place, place[0] / SIDE, place[1] / SIDE
    quad = shapes.quad(corner, right, down)
    if np.dot(quad.normals[0], sign.normals[0]) < 0:
        quad = shapes.quad(corner, down, right)
    scene.add("Texel", (quad, emitter("Texel", (1e4,) * 3)))
    return scene.write(folder)


def means_of(file, time=None, **options):
    if time is None:
        return run_means(file, RUNS, FRAMES, bounces=0, **options)
    renderer = make_renderer(restirpg.load_scene(file), size=(16, 16))
    renderer.set("paths.bounces", 0)
    renderer.render(1)
    renderer.set_time(time)
    renderer.cut()
    sums = [0.0]
    for run in range(1, RUNS + 1):
        renderer.render(FRAMES)
        sums.append(float(renderer.output("image").mean(dtype=float)) * run)
    check_samples(renderer)
    return np.diff(sums)


def difference(a, b):
    """In standard errors."""
    error = np.sqrt(a.var(ddof=1) / len(a) + b.var(ddof=1) / len(b))
    return abs(a.mean() - b.mean()) / error


@pytest.mark.parametrize("nearest", [True, False])
def test_one_bright_texel_is_the_light_that_its_square_is(tmp_path, nearest):
    """A bilinear filter spreads the texel's light over four times its area, and keeps it."""
    row, column = 37, 61
    pixels = np.zeros((SIDE, SIDE), np.uint8)
    pixels[row, column] = 255
    sign = means_of(sign_scene(tmp_path, "sign", pixels, nearest))
    square = means_of(texel_scene(tmp_path, "square", row, column), seed=1)
    print(f"sign {sign.mean():.5f} +- {sign.std():.5f}, square {square.mean():.5f} +- {square.std():.5f} a run")
    assert difference(sign, square) < LIMIT
    # Of all points drawn about one in two lies on the texel (uniform ones: one in 9216). One in n would give a relative
    # variance of n - 1 a sample.
    assert sign.var(ddof=1) / sign.mean() ** 2 * 256 * FRAMES < 4 * VARIANCE_RATIO


def test_columns_of_diodes_have_the_variance_of_a_panel_wherever_they_stand(tmp_path):
    """Two columns in eight are lit. Drawn blindly, moved by three texels, they had 10 to 20 times the variance."""
    means = []
    for shift in (0, 3):
        pixels = np.zeros((SIDE, SIDE), np.uint8)
        pixels[:, (np.arange(SIDE) + shift) % 8 < 2] = 255
        means.append(means_of(sign_scene(tmp_path, f"columns_{shift}", pixels, True), seed=shift))
    print([f"{m.mean():.3f} +- {m.std():.3f} a run" for m in means])
    assert 1 / VARIANCE_RATIO < means[0].var() / means[1].var() < VARIANCE_RATIO
    panel = means_of(sign_scene(tmp_path, "panel", np.full((SIDE, SIDE), 255, np.uint8), True), seed=1) / 4
    assert means[0].var() < 2 * VARIANCE_RATIO * panel.var()
    assert abs(means[0].mean() / panel.mean() - 1) < 0.05


def growing_lamp(folder, name, sizes):
    """A dim lamp, and a bright one whose size goes from the first of `sizes` to the last within a second."""
    scene = room(name)
    quad = shapes.quad((-0.2, 0, -0.2), (0.4, 0, 0), (0, 0, 0.4))
    scene.add("Dim", (quad, emitter("Dim", (1.0,) * 3)), at=(0.6, 1, 0))
    lamp = scene.add("Bright", (quad.moved(0), emitter("Bright", (20.0,) * 3)), at=(-0.3, 0.8, 0))
    scene.animate(lamp, "scale", [0, 1], [[size] * 3 for size in sizes])
    return scene.write(folder)


def test_a_lamp_that_grows_is_a_lamp(tmp_path):
    grown = means_of(growing_lamp(tmp_path, "grows", (0.0, 1.0)), time=1.0)
    still = means_of(growing_lamp(tmp_path, "still", (1.0, 1.0)), seed=1)
    print(f"grown {grown.mean():.4f} +- {grown.std():.4f}, still {still.mean():.4f} +- {still.std():.4f} a run")
    assert difference(grown, still) < LIMIT
    assert 1 / VARIANCE_RATIO < grown.var() / still.var() < VARIANCE_RATIO


@pytest.fixture(scope="module")
def lit_solid(tmp_path_factory):
    """A small white patch in the middle of a glowing solid of radius 1 that lets through 1/5 of the light a metre."""
    scene = SceneFile("lit_solid", 0)
    tinted = {"transmission": 1.0, "thickness": 1.0, "attenuation_color": (0.2,) * 3, "attenuation_distance": 1.0}
    shell = emitter("Shell", (1.0,) * 3, double_sided=True, **tinted)
    scene.add("Shell", (shapes.icosphere(1.0, 3).faceted(), shell))
    patch = shapes.quad((-0.05, 0, 0.05), (0.1, 0, 0), (0, 0, -0.1))
    scene.add("Patch", (patch, lambert("White", (0.8, 0.8, 0.8))))
    scene.add_camera((0, 0.05, 0), (0, 0, -0.001), 30.0)
    return scene.write(tmp_path_factory.mktemp("solid"))


@pytest.mark.parametrize("nee", [True, False])
def test_a_light_sample_is_absorbed_as_scattered_light_is(lit_solid, nee):
    means = run_means(lit_solid, RUNS, FRAMES, bounces=0, nee=nee)
    expected = 0.8 * 0.2
    print(f"light samples {nee}: {means.mean():.5f} of {expected}")
    # The shell is a polyhedron: up to 1% nearer. Without absorption the light is 5 times that.
    assert abs(means.mean() / expected - 1) < 0.03


def test_resampled_light_is_absorbed_too(lit_solid):
    graph = restirpg.load_graph(ROOT / "graphs" / "restir_di.py")
    renderer = make_renderer(restirpg.load_scene(lit_solid), graph, size=(16, 16))
    renderer.render(8)
    check_samples(renderer)
    assert abs(renderer.output("image").mean() / (0.8 * 0.2) - 1) < 0.03
