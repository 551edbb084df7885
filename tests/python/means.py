"""Means of runs: a long run as a reference, and Welch's test of whether two sets of runs have one mean."""

import numpy as np
from renderer_scenes import check_samples

from restirpg.colour import luminance
from restirpg.harness.statistics import welch
from restirpg.harness.unbiased import Reference

FALSE_ALARM = 6e-5  # of a test: what lies beyond four standard deviations of a normal distribution


def compared(values, reference):
    """The Test of a set's mean against another's, relative to the latter; prints it."""
    expected = reference.mean()
    test = welch(values / expected, reference / expected)
    print(
        f"ratio {1 + test.difference:.4f} +- {test.se:.4f}, p {test.p:.2g}, detectable {test.smallest_detectable():.4f}"
    )
    return test


def differ(values, reference):
    """Whether one mean of both is ruled out, at a false-alarm rate of FALSE_ALARM."""
    return compared(values, reference).p < FALSE_ALARM


def reference_of(renderer, frames, mean="image", variance="variance", invalid="invalid"):
    """The Reference that outputs of Accumulate make: the mean of so many frames and the variance of one, if no sample
    was left out."""
    check_samples(renderer, invalid)
    # The standard deviation of a luminance is at most that of fully correlated channels.
    deviation = luminance(np.sqrt(renderer.output(variance)))
    return Reference(luminance(renderer.output(mean)), deviation**2 / frames)
