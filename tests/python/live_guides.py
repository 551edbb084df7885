"""The check that a guide which learns while it guides keeps the path tracer's mean, for tests of such guides.

Null hypothesis and false-alarm rate: see scripts/restirpg/harness/unbiased.py. A live guide learns from the very paths
that ReSTIR keeps: frame FRAME of each of RUNS runs is one sample. Graphs name their picture `radiance`.
"""

from direct_light import TREES
from indirect_light import BOUNCES, path_tracer
from means import independent_runs, reference_of
from renderer_scenes import make_renderer

from restirpg.harness.unbiased import compare

SIZE = (20, 20)
RUNS = 64
FRAME = 8
LARGEST_UNSEEN = 0.07  # of the image mean


def unguided(scene, paths):
    """The Reference: indirect light by the plain path tracer, so many paths per pixel."""
    renderer = make_renderer(scene, path_tracer(TREES), seed=1, size=SIZE)
    renderer.set("paths.bounces", BOUNCES)
    renderer.render(paths // TREES)
    return reference_of(renderer, paths // TREES)


def verdict_on(scene, graph, reference, tests):
    """Verdict on the mean of frame FRAME. `tests` share the false-alarm rate."""
    renderer = make_renderer(scene, graph, size=SIZE)
    renderer.set_everywhere("bounces", BOUNCES)
    images = independent_runs(renderer, RUNS, (FRAME,))[FRAME]
    verdict = compare(images, reference, tests)
    print(verdict)
    return verdict


def check_mean(scene, graph, reference, tests):
    """The mean of frame FRAME is the reference's."""
    verdict = verdict_on(scene, graph, reference, tests)
    assert not verdict.biased and verdict.detectable < LARGEST_UNSEEN, str(verdict)
