"""Next event estimation and scattering are two estimators of one integral: with and without it the mean picture is the
same.

Null hypothesis: every 4 x 4 block of 32 x 32 pixels has one expected luminance. 64 runs a side, Welch's t, |t| against
Student's quantile of a false alarm of 1% over all blocks; the seeds are fixed. Lights without a surface (spot, point,
directional) can only be connected to: they are tested against the irradiance that they are defined by.
"""

import json
import struct

import numpy as np
import pytest
from direct_light import LitScene, write_every_light
from furnace_scenes import run_means, standard_errors_off
from renderer_scenes import GRAPH, check_samples, restirpg
from scipy import stats

from restirpg.colour import luminance
from restirpg.harness.statistics import LEVEL, block_means
from restirpg.harness.unbiased import BLOCK
from restirpg.scenes import shapes
from restirpg.scenes.gltf import lambert

RUNS, FRAMES = 64, 4


def without_punctual_lights(file):
    """The scene, of a .glb file, with the lights that have a surface or surround everything only."""
    data = file.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    for node in document["nodes"]:
        node.pop("extensions", None)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    total = len(data) - length + len(text)
    file.write_bytes(struct.pack("<4sIII4s", b"glTF", 2, total, len(text), b"JSON") + text + data[20 + length :])
    return file


def block_runs(file, seed, backend, **knobs):
    """Block means of the luminance, (RUNS, 8, 8), of independent stretches of frames."""
    renderer = restirpg.Renderer(
        restirpg.load_scene(file),
        restirpg.load_graph(GRAPH),
        size=(32, 32),
        seed=seed,
        backend=backend,
        validation=True,
    )
    for name, value in knobs.items():
        renderer.set(f"paths.{name}", value)
    sums = [np.zeros((32, 32))]
    for run in range(1, RUNS + 1):
        renderer.render(FRAMES)
        sums.append(luminance(renderer.output("image")) * run)
    check_samples(renderer)
    return block_means(np.diff(sums, axis=0), BLOCK)


def worst_block(a, b):
    """Largest |t| over the blocks, as a multiple of what chance explains."""
    error = np.sqrt(a.var(axis=0, ddof=1) / RUNS + b.var(axis=0, ddof=1) / RUNS)
    limit = stats.t.ppf(1 - LEVEL / 2 / error.size, RUNS - 1)
    return float((np.abs(a.mean(axis=0) - b.mean(axis=0)) / error).max() / limit)


@pytest.fixture(scope="module")
def lit_scene(tmp_path_factory):
    """Lamps, a textured emitter and a sky over glossy paint and frosted glass."""
    return without_punctual_lights(write_every_light(tmp_path_factory.mktemp("lights")))


@pytest.mark.parametrize("backend", ["software", "rayquery"])
def test_next_event_estimation_changes_no_mean(lit_scene, backend):
    connected = block_runs(lit_scene, 1, backend, bounces=2, nee=True)
    scattered = block_runs(lit_scene, 2, backend, bounces=2, nee=False)
    assert worst_block(connected, scattered) < 1
    # 5% of the mean would have been found, and so would a missing bounce.
    assert worst_block(connected, scattered * 1.05) > 1
    assert worst_block(connected, block_runs(lit_scene, 2, backend, bounces=1, nee=False)) > 1


@pytest.mark.parametrize("backend", ["software", "rayquery"])
def test_lights_without_a_surface_give_the_irradiance_they_are_defined_by(tmp_path, backend):
    scene = LitScene("floor", 0, environment=(0.0, 0.0, 0.0))
    scene.add("Floor", (shapes.quad((-1, 0, 1), (2, 0, 0), (0, 0, -2)), lambert("Paint", (0.5,) * 3)))
    scene.add_punctual("point", (0, 2, 0), (0, 0, 0), (8.0,) * 3)
    scene.add_spot("spot", (0, 4, 0), (0, 0, 0), (16.0,) * 3)
    scene.add_punctual("directional", (3, 4, 0), (0, 0, 0), (2.0,) * 3)
    scene.add_camera((0.5, 1.5, 0), (0, 0, 0), 0.5)  # sees 2 cm of the floor: constant to 1e-4
    file = scene.write(tmp_path)
    irradiance = 8 / 2**2 + 16 / 4**2 + 2 * 4 / 5
    means = run_means(file, 32, 8, backend=backend, bounces=0)
    assert standard_errors_off(means, 0.5 / np.pi * irradiance) < 3
    assert standard_errors_off(means, 0.5 / np.pi * irradiance * 1.02) > 3
    assert run_means(file, 2, 2, backend=backend, bounces=0, nee=False).max() == 0
