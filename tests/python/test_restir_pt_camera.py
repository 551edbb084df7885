"""ReSTIR PT under a moving camera: the only motion under which temporal reuse is unbiased and its Jacobians are not 1.

Null hypothesis: after FRAMES frames of a moving camera, indirect light of a staircase has the path tracer's mean at the
last pose, in the image and in every 4 x 4 block (restirpg.harness.unbiased: RUNS runs, whose frame FRAMES is a sample;
a false alarm of 1% a case). An image mean that is 2.5% off is found. Each mistake must be found in MUTANT_RUNS runs.

Much is asked of the shifts: a step is but two or three pixels high, the camera moves by 27 cm a frame, and
pixels take paths of any surface, however it is turned and however far it is.
"""

import numpy as np
import pytest
from direct_light import TREES
from indirect_light import BOUNCES, path_tracer, restir
from means import independent_runs, reference_of
from mutants import mutant
from renderer_scenes import make_renderer, restirpg

from restirpg.harness.unbiased import compare
from restirpg.scenes import shapes
from restirpg.scenes.gltf import Material, SceneFile, emitter, lambert

RUNS, MUTANT_RUNS, FRAMES, SIZE, REFERENCE_PATHS = 256, 192, 8, (16, 16), 4096
LARGEST_UNSEEN = 0.025  # of the image mean
#: Many Jacobians far from 1, and a cap that is reached after some frames.
KNOBS = {"normal_threshold": -1.0, "depth_threshold": 1000.0, "cap": 4.0}
STEPS, CAMERA = 6, np.array((0.5, 1.6, 2.2))


def write_staircase(folder):
    """Steps, white and glossy in turn, between a floor and a glossy wall, under a large lamp."""
    scene = SceneFile("staircase", BOUNCES)
    white = lambert("White", (0.8, 0.8, 0.8))
    gloss = Material("Gloss", (0.8, 0.7, 0.6), roughness=0.45)
    for i in range(STEPS):
        step = shapes.box((-1, 0, -1.6 / STEPS * (i + 1)), (1, 1.2 / STEPS * (i + 1), -1.6 / STEPS * i))
        scene.add(f"Step{i}", (step, gloss if i % 2 else white))
    scene.add("Floor", (shapes.quad((-2, 0, 2), (4, 0, 0), (0, 0, -4)), white))
    scene.add("Wall", (shapes.quad((-1, 0, -2), (0, 0, 4), (0, 2.5, 0)), gloss))
    lamp = emitter("Lamp", (3.0, 2.7, 2.4), double_sided=True)
    scene.add("Lamp", (shapes.quad((-0.8, 2.4, -0.6), (1.6, 0, 0), (0, 0, 1.6)), lamp))
    scene.add_camera(CAMERA, (-0.3, 0.6, -0.6), 26.0)
    return scene.write(folder)


def approach(renderer, frame):
    """Where the camera is at that frame, counted from 1: at the last one where the scene has it."""
    renderer.move_camera(position=CAMERA + (FRAMES - frame) * np.array((0.24, 0.0, 0.12)))


@pytest.fixture(scope="module")
def staircase(tmp_path_factory):
    """The scene, and its indirect light by the path tracer from where the camera stands at last."""
    staircase = restirpg.load_scene(write_staircase(tmp_path_factory.mktemp("staircase")))
    tracer = make_renderer(staircase, path_tracer(TREES), size=SIZE, seed=77)
    frames = REFERENCE_PATHS // TREES
    tracer.set("paths.bounces", BOUNCES)
    tracer.render(frames)
    return staircase, reference_of(tracer, frames)


def verdict_of(staircase, rounds, runs):
    scene, reference = staircase
    renderer = make_renderer(scene, restir(False, rounds=rounds, **KNOBS), size=SIZE)
    renderer.set("paths.bounces", BOUNCES)
    samples = independent_runs(renderer, runs, (FRAMES,), approach, output="image")
    verdict = compare(samples[FRAMES], reference)
    print(verdict)
    return verdict


@pytest.mark.parametrize("rounds", [0, 1])
def test_the_mean_is_the_path_tracers_under_a_moving_camera(staircase, rounds):
    verdict = verdict_of(staircase, rounds, RUNS)
    assert not verdict.biased
    assert verdict.detectable < LARGEST_UNSEEN


@pytest.mark.parametrize(
    ("mistake", "rounds"), [("reuse_temporal_jacobian", 0), ("reuse_cap", 0), ("reuse_spatial_jacobian", 1)]
)
def test_a_mistake_shows_in_the_mean(staircase, mistake, rounds):
    with mutant(mistake):
        assert verdict_of(staircase, rounds, MUTANT_RUNS).biased
