"""Scenes whose picture is known without rendering them, and z-tests of pictures against a number or each other."""

import numpy as np
from renderer_scenes import GRAPH, check_samples, restirpg

from restirpg.scenes import shapes
from restirpg.scenes.gltf import Material, SceneFile, emitter, lambert, metal


def closed_box(folder, albedo):
    """A closed box of emission 1: light of k scatterings has the radiance albedo^k everywhere."""
    scene = SceneFile(f"closed_{albedo}".replace(".", "_"), 8)
    walls = lambert("Walls", (albedo,) * 3, emission=(1.0,) * 3)
    scene.add("Walls", (shapes.box((-1, -1, -1), (1, 1, 1)).inverted(), walls))
    scene.add_camera((0.5, 0.35, 0.8), (-0.4, -0.2, -0.6), 55.0)
    return scene.write(folder)


def body_in_environment(folder, albedo):
    """A convex Lambert body that fills the view: it sees nothing but the environment, of radiance 1."""
    scene = SceneFile(f"body_{albedo}".replace(".", "_"), 4, environment=(1.0, 1.0, 1.0))
    scene.add("Body", (shapes.icosphere(1.0, 2).faceted(), lambert("Paint", (albedo,) * 3)))
    scene.add_camera((0, 0.4, 2.0), (0, 0, 0), 25.0)
    return scene.write(folder)


def run_means(file, runs, frames, size=(16, 16), backend=None, seed=0, energy_compensation=False, **knobs):
    """Image means of independent runs, float (R,): stretches of `frames` frames, each of which draws fresh numbers."""
    renderer = restirpg.Renderer(
        restirpg.load_scene(file),
        restirpg.load_graph(GRAPH),
        size=size,
        seed=seed,
        backend=backend,
        validation=True,
        energy_compensation=energy_compensation,
    )
    for name, value in knobs.items():
        renderer.set(f"paths.{name}", value)
    sums = [0.0]
    for run in range(1, runs + 1):
        renderer.render(frames)
        sums.append(float(renderer.output("image").mean(dtype=float)) * run)
    check_samples(renderer)
    return np.diff(sums)


def standard_errors_off(means, expected):
    """How many standard errors the mean of the runs is from `expected`. Where the runs do not vary, rounding to 1e-5 is
    one."""
    error = max(means.std(ddof=1) / np.sqrt(len(means)), 1e-5 * abs(expected))
    return abs(means.mean() - expected) / error


WHITE = (1.0, 1.0, 1.0)
MIRROR, BRUSHED = metal("Mirror", WHITE, 0.0), metal("Brushed", WHITE, 0.12)
PANE = Material("Pane", WHITE, roughness=0.0, transmission=1.0)


def upright_strips(folder, *materials):
    """Strips of these materials, side by side, that fill the view before a sky of radiance 1."""
    scene = SceneFile("strips_" + "_".join(m.name for m in materials), 0, environment=WHITE)
    width = 2 / len(materials)
    for i, material in enumerate(materials):
        scene.add(material.name, (shapes.quad((i * width - 1, -1, 0), (width, 0, 0), (0, 2, 0)), material))
    scene.add_camera((0, 0, 3.0), (0, 0, 0), np.degrees(2 * np.arctan(1 / 3)))
    return scene.write(folder)


def dark_half(folder):
    """A floor with a black screen across: left of it a lamp and a white wall, right of it nothing that light could
    reach."""
    scene = SceneFile("dark_half", 2)
    scene.add("Floor", (shapes.quad((-2, 0, 2), (4, 0, 0), (0, 0, -4)), lambert("White", (0.8, 0.8, 0.8))))
    scene.add("Screen", (shapes.quad((0, -9, 9), (0, 0, -18), (0, 18, 0)), lambert("Black", (0.0, 0.0, 0.0))))
    scene.add("Wall", (shapes.quad((-2, 0, 2), (0, 0, -4), (0, 2, 0)), lambert("White", (0.8, 0.8, 0.8))))
    lamp = shapes.quad((-1.5, 2.0, -0.5), (1, 0, 0), (0, 0, 1))
    scene.add("Lamp", (lamp, emitter("Lamp", (5.0, 5.0, 5.0))))
    scene.add_camera((0, 5.0, 0.01), (0, 0, 0), 40.0)
    return scene.write(folder)
