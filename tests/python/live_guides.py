"""The check that a guide which learns while it guides keeps the path tracer's mean, for tests of such guides.

Null hypothesis and false-alarm rate: see scripts/restirpg/harness/unbiased.py. A live guide learns from the very paths
that ReSTIR keeps: frame FRAME of each of RUNS runs is one sample. Graphs name their picture `radiance`.
"""

import numpy as np
from renderer_scenes import make_renderer

from restirpg.harness.statistics import luminance
from restirpg.harness.unbiased import Reference, compare, independent_runs

SIZE = (20, 20)
RUNS = 64
FRAME = 8


def reference_of(scene, graph, frames):
    """The mean of an unguided graph, which has `variance` as an output, too."""
    renderer = make_renderer(scene, graph, seed=1, size=SIZE)
    renderer.render(frames)
    # The standard deviation of a luminance is at most that of fully correlated channels.
    deviation = luminance(np.sqrt(renderer.output("variance")))
    return Reference(luminance(renderer.output("radiance")), deviation**2 / frames)


def check_mean(scene, graph, reference, tests):
    """The mean of frame FRAME is the reference's. `tests` share the false-alarm rate."""
    images = independent_runs(make_renderer(scene, graph, size=SIZE), RUNS, (FRAME,))[FRAME]
    verdict = compare(images, reference, tests)
    print(verdict)
    assert verdict.worst < 1 and verdict.mean < 4, str(verdict)
