"""Figure 2's flatland: its sampler, its estimators, and what is fitted to their samples.

Statistical: null hypothesis, the mean over runs of the image, and of each of 8 stretches of it, is that of
the midpoint rule; 400 runs of 128 pixels; false-alarm rate 1% over a whole test (Bonferroni). Neighbours
share samples within a run, runs are independent. Must be rejected: reuse weighted by the count of
participants instead of the balance heuristic (z = 6.2).
"""

import numpy as np
import pytest
from scipy import stats

from restirpg.harness.paper import flatland

PIXELS, RUNS = 128, 400
X = (np.arange(PIXELS) + 0.5) / PIXELS


def images(rounds, runs=RUNS, **options):
    """(runs, 8): mean radiance of stretches of 16 pixels."""
    found = []
    for seed in range(runs):
        random = np.random.default_rng(seed)
        reservoirs = flatland.candidates(X, random)
        for _ in range(rounds):
            reservoirs = flatland.reuse(X, reservoirs, random, radius=10, **options)
        found.append(flatland.estimate(X, reservoirs).reshape(8, -1).mean(1))
    return np.array(found)


def worst(found):
    """Largest |z| of the stretches and of the image, and the limit."""
    right = flatland.truth(X).reshape(8, -1).mean(1)
    z = (found.mean(0) - right) / (found.std(0, ddof=1) / len(found) ** 0.5)
    mean = found.mean(1)
    whole = (mean.mean() - right.mean()) / (mean.std(ddof=1) / len(mean) ** 0.5)
    return max(np.abs(z).max(), abs(whole)), stats.t.ppf(1 - 0.01 / 2 / 9, len(found) - 1)


@pytest.mark.parametrize("rounds", [0, 1, 3])
def test_path_traced_and_resampled_images_have_the_true_mean(rounds):
    z, limit = worst(images(rounds))
    assert z < limit


def test_a_reuse_that_ignores_what_others_could_have_found_is_rejected():
    z, limit = worst(images(3, weights="equal"))
    assert z > limit


def test_candidates_have_the_density_they_claim():
    """Chi-square of 2^18 draws at three points over 60 bins of the walls, 1% over the three."""
    for number, x in enumerate((0.05, 0.5, 0.8)):
        draws = flatland.candidates(np.full(2**18, x), np.random.default_rng(number)).s
        fine = (np.arange(60 * 200) + 0.5) * 3 / (60 * 200)
        share = flatland.density(np.full(len(fine), x), fine).reshape(60, -1).sum(1) * 3 / (60 * 200)
        assert share.sum() == pytest.approx(1, abs=1e-3)
        expected = share / share.sum() * len(draws)
        wide = expected > 10
        counts = np.histogram(draws, 60, (0, 3))[0]
        score = ((counts - expected)[wide] ** 2 / expected[wide]).sum()
        assert score < stats.chi2.ppf(1 - 0.01 / 3, wide.sum() - 1)


def test_reuse_lowers_the_error():
    right = flatland.truth(X).reshape(8, -1).mean(1)
    error = [np.abs(images(rounds, 50) - right).mean() for rounds in (0, 3)]
    assert error[1] < 0.8 * error[0]


def test_a_known_mixture_is_recovered():
    """4,000 draws of two lobes: directions to 2 degrees, weights to 3%."""
    random = np.random.default_rng(3)
    second = random.random(4000) < 0.3
    angle = np.where(second, random.vonmises(2.4, 60, 4000), random.vonmises(0.8, 20, 4000))
    model = flatland.fit(angle, np.ones(4000), lobes=2, steps=60)
    order = np.argsort(model.mean)
    assert np.degrees(np.abs(model.mean[order] - [0.8, 2.4])).max() < 2
    assert model.weight[order] == pytest.approx([0.7, 0.3], abs=0.03)
    assert model.kappa[order] == pytest.approx([20, 60], rel=0.15)


def test_the_screen_casts_a_shadow():
    """Straight up from below the screen nothing is seen; beside it the ceiling is."""
    assert not flatland.visible(np.array([0.5]), np.array([1.5]))[0]
    assert flatland.visible(np.array([0.1]), np.array([1.9]))[0]
