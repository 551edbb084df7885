"""ReSTIR PT while things move. Temporal reuse is biased then (its README says by how much), but must not feed on
itself.

The tower of the Cornell box moves by 3 cm a frame. When the history's domain was where its surface had been, which is
inside of the tower now, no path led anywhere from there, and the history counted again in every frame: 63% too much
indirect light after 8 frames. RUNS runs give a standard error of about 1%; LARGEST is three times the bias that is
left.
"""

import numpy as np
import pytest
from renderer_scenes import ROOT, make_renderer, restirpg, scene, scene_file  # noqa: F401
from test_flat_energy import resampled

from restirpg.harness.unbiased import independent_runs

RUNS, FRAMES, SIZE, BOUNCES, LARGEST = 24, 8, (24, 24), 2, 0.05
BATCHES, BATCH_FRAMES = 8, 64  # of the path tracer


def place_tower(renderer, frame):
    """Where the tower stands at that frame, counted from 1: at the last one where the scene has it."""
    pose = np.eye(4)
    pose[0, 3] = 0.03 * (frame - FRAMES)
    renderer.move_node("Tower", pose)


@pytest.mark.parametrize("rounds", [0, 1])
def test_light_on_and_around_what_moves_does_not_add_up(scene, rounds):
    still = make_renderer(scene, resampled(True), size=SIZE)
    moving = make_renderer(scene, resampled(False), size=SIZE)
    for renderer in (still, moving):
        renderer.set("paths.bounces", BOUNCES)
    moving.set("reuse.rounds", rounds)
    expected = independent_runs(still, BATCHES, (BATCH_FRAMES,))[BATCH_FRAMES].mean()
    means = independent_runs(moving, RUNS, (FRAMES,), place_tower)[FRAMES].mean((1, 2))
    print(f"ratio {means.mean() / expected:.4f} +- {means.std(ddof=1) / np.sqrt(RUNS) / expected:.4f}")
    assert abs(means.mean() / expected - 1) < LARGEST
