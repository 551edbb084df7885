"""Scenes whose picture is known without rendering them, and z-tests of pictures against a number or each other."""

import sys

import numpy as np
from renderer_scenes import GRAPH, ROOT, restirpg

sys.path.insert(0, str(ROOT / "scripts"))

from scenes import shapes  # noqa: E402
from scenes.gltf import SceneFile, lambert  # noqa: E402


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


def run_means(file, runs, frames, size=(16, 16), backend=None, seed=0, **knobs):
    """Image means of independent runs, float (R,): stretches of `frames` frames, each of which draws fresh numbers."""
    renderer = restirpg.Renderer(restirpg.load_scene(file), restirpg.load_graph(GRAPH), size=size, seed=seed, backend=backend,
                                 validation=True)
    for name, value in knobs.items():
        renderer.set(f"paths.{name}", value)
    sums = [0.0]
    for run in range(1, runs + 1):
        renderer.render(frames)
        sums.append(float(renderer.output("image").mean(dtype=float)) * run)
    return np.diff(sums)


def standard_errors_off(means, expected):
    """How many standard errors the mean of the runs is from `expected`. Where the runs do not vary, rounding to 1e-5 is one."""
    error = max(means.std(ddof=1) / np.sqrt(len(means)), 1e-5 * abs(expected))
    return abs(means.mean() - expected) / error
