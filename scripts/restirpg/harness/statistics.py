"""Statistics of comparisons. Every test is two-sided; families of tests are corrected by Holm's method."""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr, stdtrit

LEVEL = 0.01  # of a whole family of tests: one false alarm in a hundred reports
POWER = 0.8  # with which the "smallest detectable" difference would have been found


def t_quantile(p, dof):
    """Of Student's t. (scipy.stats has it, too, and takes half a second to import.)"""
    return stdtrit(dof, p)


def t_two_sided(t, dof):
    """The probability of a t at least as far from 0."""
    return 2 * stdtr(dof, -np.abs(t))


@dataclass(frozen=True)
class Test:
    """A t-test of a difference; p is not corrected for other tests."""

    difference: float
    se: float
    dof: float
    p: float

    def smallest_detectable(self, tests=1):
        """The difference found with probability POWER at LEVEL over `tests` tests (Holm's first step)."""
        if not self.dof > 0:
            return float("nan")
        return float((t_quantile(1 - LEVEL / tests / 2, self.dof) + t_quantile(POWER, self.dof)) * self.se)


def _t_test(difference, se, dof):
    if not dof > 0 or not np.isfinite(difference) or not np.isfinite(se):
        return Test(float(difference), float("nan"), 0, float("nan"))
    if se == 0:  # no spread at all: runs with the same random numbers
        return Test(float(difference), 0.0, float(dof), 1.0 if difference == 0 else 0.0)
    return Test(float(difference), float(se), float(dof), float(t_two_sided(difference / se, dof)))


def mean_se(values, axis=0):
    """Mean and its standard error over independent runs; the error of a single run is NaN."""
    values = np.asarray(values, float)
    count = values.shape[axis]
    se = values.std(axis=axis, ddof=1) / np.sqrt(count) if count > 1 else np.full_like(values.mean(axis=axis), np.nan)
    return values.mean(axis=axis), se


def ratio(values, baseline):
    """The ratio of two means over pairs that shared a seed, and its standard error to first order: that of
    what the ratio leaves. (A mean of ratios would be too large where the baseline is noisy.)"""
    values, baseline = np.asarray(values, float), np.asarray(baseline, float)
    quotient = values.mean() / baseline.mean()
    return quotient, mean_se((values - quotient * baseline) / baseline.mean())[1]


def paired(a, b):
    """Test of mean(a - b) = 0 over pairs that shared a seed."""
    difference, se = mean_se(np.asarray(a, float) - np.asarray(b, float))
    return _t_test(difference, se, len(a) - 1)


def welch(a, b):
    """Test of mean(a) = mean(b) of independent samples of unequal variance; b may be one exact number."""
    a = np.asarray(a, float)
    b = np.atleast_1d(np.asarray(b, float))
    if len(a) < 2:
        return _t_test(a.mean() - b.mean(), np.nan, 0)
    va, vb = a.var(ddof=1) / len(a), b.var(ddof=1) / len(b) if len(b) > 1 else 0.0
    squares = va**2 / (len(a) - 1) + (vb**2 / (len(b) - 1) if len(b) > 1 else 0.0)
    dof = (va + vb) ** 2 / squares if squares > 0 else len(a) - 1
    return _t_test(a.mean() - b.mean(), np.sqrt(va + vb), dof)


def block_bias_p_values(runs, reference):
    """p-value of each block's bias: Welch's test, guarded against tails that no run has sampled yet.

    runs: (runs, blocks...), at least 2; reference: (batches, blocks...), one row is exact. In a block that
    rare bright samples have missed in every run, the runs agree about a value that is far too dark. The
    variance of a block is therefore never taken for less than the mean relative variance of all blocks
    says.
    """
    runs, reference = np.asarray(runs, float), np.asarray(reference, float)
    truth = reference.mean(axis=0)
    own = runs.var(axis=0, ddof=1) / len(runs)
    lit = truth > 0
    floor = np.mean(own[lit] / truth[lit] ** 2) * truth**2 if lit.any() else np.zeros_like(truth)
    own = np.maximum(own, floor)
    other = reference.var(axis=0, ddof=1) / len(reference) if len(reference) > 1 else np.zeros_like(own)
    with np.errstate(divide="ignore", invalid="ignore"):
        dof = (own + other) ** 2 / (own**2 / (len(runs) - 1) + other**2 / max(len(reference) - 1, 1))
        t = np.abs(runs.mean(axis=0) - truth) / np.sqrt(own + other)
    p = t_two_sided(t, np.nan_to_num(dof, nan=1))
    return np.where(np.isnan(t), 1.0, p)  # no spread and no difference: a block that is black in every run


def holm(p_values):
    """Holm's adjusted p-values, valid under any dependence. NaN (untested) is no part of the family."""
    p = np.asarray(p_values, float)
    adjusted = np.full(p.shape, np.nan)
    tested = np.flatnonzero(~np.isnan(p))
    order = tested[np.argsort(p[tested], kind="stable")]
    steps = p[order] * np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(1, np.maximum.accumulate(steps)) if len(order) else []
    return adjusted


def block_means(images, size=8):
    """Means of size x size blocks of (..., H, W); a rest at the right and the bottom is left out."""
    images = np.asarray(images, float)
    height, width = (n // size for n in images.shape[-2:])
    if height == 0 or width == 0:
        return images.mean(axis=(-2, -1), keepdims=True)
    cut = images[..., : height * size, : width * size]
    return cut.reshape(*cut.shape[:-2], height, size, width, size).mean(axis=(-3, -1))


def block_correlation(images, size=8):
    """How strongly neighbouring pixels err together: the ratio of two variances, and its standard error.

    The ratio is the variance of the means of size x size blocks, divided by the variance that these means would
    have if pixels were independent; both are summed over all blocks. It is 1 for independent pixels and size^2
    where all pixels of a block have the same error. images: (runs, H, W) of independent runs. The standard error
    is the jackknife's over runs. Fewer than 2 runs give NaN for the ratio, fewer than 3 for its error.
    """
    images = np.asarray(images, float)
    if len(images) < 2 or min(images.shape[-2:]) < size:
        return float("nan"), float("nan")

    def ratio(runs):
        together = block_means(runs, size).var(axis=0, ddof=1).sum()
        alone = block_means(runs.var(axis=0, ddof=1), size).sum() / size**2
        return together / alone if alone > 0 else float("nan")

    count = len(images)
    if count < 3:
        return float(ratio(images)), float("nan")
    left_out = np.array([ratio(np.delete(images, run, axis=0)) for run in range(count)])
    return float(ratio(images)), float(np.sqrt((count - 1) / count * np.sum((left_out - left_out.mean()) ** 2)))


def temporal_correlation(sums, reference_variance):
    """Autocorrelation at lag 1 from measure.TemporalSums.sums.

    The reference's own variance (of luminance, mean over pixels) is in both products and is subtracted.
    """
    product, products, square, squares = sums
    if not products or not squares:
        return float("nan")
    variance = square / squares - reference_variance
    return float((product / products - reference_variance) / variance) if variance > 0 else float("nan")


def at_time(times, values, time):
    """A curve's value at `time`, log-linear between measured frames; NaN outside them."""
    times, values = np.asarray(times, float), np.asarray(values, float)
    if not times[0] <= time <= times[-1] * (1 + 1e-9):
        return float("nan")
    if np.any(values <= 0) or np.any(times <= 0):
        return float(np.interp(time, times, values))
    return float(np.exp(np.interp(np.log(time), np.log(times), np.log(values))))
