"""Energy is flat over what ReSTIR PT reuses: rounds, neighbours and cap change the noise, never the mean.

Null hypothesis: the path tracer and all SETTINGS have one image mean (indirect light of the diffuse Cornell box).
Chi-square over their means, of RUNS runs each of which frame FRAME is one sample; a false alarm of 1.3%: the quantile
is that of 1%, and the variances are estimates. Darkening with rounds is a mistake in the MIS weights, with the cap one
in the confidences.
"""

import numpy as np
import pytest
from direct_light import TREES
from indirect_light import BOUNCES, path_tracer, restir
from means import independent_runs
from mutants import mutant
from renderer_scenes import make_renderer
from scipy import stats

from restirpg.harness.statistics import LEVEL

RUNS, FRAME, SIZE = 96, 6, (24, 24)
BATCHES, BATCH_FRAMES = 96, 2  # of the path tracer, with TREES
CHOSEN_PAIRS = {"rounds": 2, "neighbours": 6, "reciprocal": True, "pool": 4}
SETTINGS = [
    {"temporal": False, "rounds": 0},
    {"rounds": 0, "cap": 1.0},
    {"rounds": 0, "cap": 100.0},
    {"temporal": False, "rounds": 2, "neighbours": 6},
    {"rounds": 1, "neighbours": 1, "cap": 20.0},
    {"rounds": 1, "neighbours": 6, "cap": 100.0},
    {"rounds": 3, "neighbours": 2, "cap": 1.0},
    {"rounds": 4, "neighbours": 6, "cap": 20.0},
    {"rounds": 2, "neighbours": 4, "reciprocal": True},
    CHOSEN_PAIRS,
]
DEFAULTS = {"temporal": True, "reciprocal": False, "pool": 1, "neighbours": 3, "cap": 20.0}


def make_resampled(scene):
    renderer = make_renderer(scene, restir(False), size=SIZE)
    renderer.set("paths.bounces", BOUNCES)
    return renderer


@pytest.fixture(scope="module")
def path_traced(scene):
    """Image means of the path tracer's batches."""
    renderer = make_renderer(scene, path_tracer(TREES), size=SIZE)
    renderer.set("paths.bounces", BOUNCES)
    batches = independent_runs(renderer, BATCHES, (BATCH_FRAMES,), output="image", family="reference")
    return batches[BATCH_FRAMES].mean((1, 2))


def means_of(renderer, settings):
    """Image means of the runs, float (RUNS,)."""
    for name, value in {**DEFAULTS, **settings}.items():
        if renderer.get(f"reuse.{name}") != value:
            renderer.set(f"reuse.{name}", value)
    # Without history, all frames are alike.
    frame = FRAME if settings.get("temporal", True) else 1
    return independent_runs(renderer, RUNS, (frame,), output="image", family=str(settings))[frame].mean((1, 2))


def flatness(samples):
    """p-value of all sets of samples having one mean (chi-square of the means about their weighted mean)."""
    means = np.array([values.mean() for values in samples])
    errors = np.array([values.std(ddof=1) / np.sqrt(len(values)) for values in samples])
    weights = errors**-2
    average = weights @ means / weights.sum()
    for mean, error in zip(means, errors):
        print(f"    ratio {mean / average:.4f} +- {error / average:.4f}")
    return float(stats.chi2.sf(np.sum(((means - average) / errors) ** 2), len(means) - 1))


def test_energy_does_not_depend_on_what_is_reused(scene, path_traced):
    renderer = make_resampled(scene)
    samples = [path_traced, *(means_of(renderer, settings) for settings in SETTINGS)]
    p = flatness(samples)
    print(f"p of one mean: {p:.3g}")
    assert p > LEVEL
    # The test could have failed: six standard errors too little light in one setting, or a mistake of reuse.
    last = samples[-1] - samples[-1].mean()
    darker = last + path_traced.mean() - 6 * last.std(ddof=1) / np.sqrt(RUNS)
    assert flatness([*samples[:-1], darker]) < LEVEL
    with mutant("reuse_confidence"):
        mistaken = means_of(make_resampled(scene), {"rounds": 0, "cap": 20.0})
    assert flatness([*samples, mistaken]) < LEVEL
    with mutant("reuse_one_sided"):
        mistaken = means_of(make_resampled(scene), CHOSEN_PAIRS)
    assert flatness([*samples, mistaken]) < LEVEL
