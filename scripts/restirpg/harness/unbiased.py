"""Is a method's mean the path tracer's? Independent runs, block means and their tests.

A run begins with a seed of its own and without history, and frame k of each run is one sample: frames of one
run are correlated. Null hypothesis: the mean over runs of the image, and of every block of pixels, is the
reference's. Both are compared with the two-sided quantile of Student's t at a false-alarm rate of LEVEL, the
blocks for all of them together (Bonferroni), either over the other tests that the caller names as well.

Heavy tails are guarded: in a block that rare bright samples have missed, the runs agree about a value that is
too dark, so that the relative variance of a block is never taken for less than the median of all blocks'
(the embedded scene door_ajar, 64 first frames: 5.8 standard errors too dark become 2.9). The mean, as in
statistics.block_bias_p_values, would guard more, but one block at a shadow's edge costs all others their power.
"""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from restirpg.harness import UserError
from restirpg.harness.jobs import seed_of
from restirpg.harness.statistics import LEVEL, Test, block_means, t_quantile, t_two_sided

BLOCK = 4  # pixels, the edge of a block
ROUNDING = 1e-6  # relative, of a mean in single precision: a standard error where runs do not vary


@dataclass(frozen=True)
class Reference:
    """What is taken for the truth, with its own error. Errors of different pixels are independent."""

    mean: np.ndarray  # (H, W), luminance
    variance: np.ndarray  # (H, W), of the error of `mean`


@dataclass(frozen=True)
class Verdict:
    """Outcome of the tests of one frame number."""

    runs: int
    z: np.ndarray  # standard scores of the blocks, guarded
    plain_z: np.ndarray  # the same by each block's own variance, of the blocks that have any
    limit: float  # largest |z| that chance explains
    image: Test  # of the image mean, relative to the reference's
    detectable_block: float  # median over blocks of the smallest relative bias that would be found
    tests: int  # that share LEVEL with this one

    @property
    def worst(self):
        """Largest |z| of a block over its limit: above 1 the null hypothesis falls."""
        return float(np.abs(self.z).max() / self.limit)

    @property
    def biased(self):
        """Whether the null hypothesis falls, for a block or for the image mean."""
        return bool(self.worst > 1 or self.image.p < LEVEL / self.tests)

    @property
    def mean(self):
        """|z| of the image mean."""
        return abs(self.image.difference) / self.image.se

    @property
    def detectable(self):
        """Relative bias of the image mean that would be found with a probability of 80%."""
        return self.image.smallest_detectable(self.tests)

    @property
    def normality(self):
        """Kolmogorov and Smirnov's p-value of the plain scores against Student's t: a hint on tails, for
        reuse correlates blocks.
        """
        if self.plain_z.size == 0:
            return float("nan")
        return float(stats.kstest(self.plain_z, stats.t(self.runs - 1).cdf).pvalue)

    def __str__(self):
        return (
            f"ratio {1 + self.image.difference:.4f} +- {self.image.se:.4f}, image z {self.mean:.2f}, "
            f"detectable {self.detectable:.3%}; largest |z| of {self.z.size} blocks "
            f"{np.abs(self.z).max():.2f}, limit {self.limit:.2f}, detectable {self.detectable_block:.2%}; "
            f"KS p {self.normality:.2g}"
        )


def run_seed(run, *parts):
    """The seed of a run, hashed: consecutive seeds are no independent ones everywhere."""
    return seed_of("unbiased", *parts, run)


def check(samples, reference):
    """Raise UserError where a comparison would say nothing: NaN is no farther from the truth than any limit."""
    for what, values in (("samples", samples), ("reference", reference.mean), ("its variance", reference.variance)):
        wrong = np.count_nonzero(~np.isfinite(values))
        if wrong:
            raise UserError(f"{what}: {wrong} of {np.size(values)} values are NaN or infinite; no mean can be tested")
    if not reference.mean.mean() > 0:
        raise UserError("the reference is black; no bias is relative to it")


def compare(samples, reference, tests=1, block=BLOCK):
    """Verdict on samples (runs, H, W) of one frame number; so many `tests` share the false-alarm rate. Raises
    UserError where a value is NaN or infinite."""
    check(samples, reference)
    runs = len(samples)
    expected = reference.mean.mean()
    differences = block_means(samples - reference.mean, block)
    own = differences.var(0, ddof=1) / runs
    other = block_means(reference.variance, block) / block**2
    level = np.maximum(block_means(reference.mean, block), 1e-3 * expected)
    plain = np.sqrt(own + other + (ROUNDING * level) ** 2)
    noisy = plain > 2 * ROUNDING * level  # the rest is the same in every run, as emission is
    floor = np.median((own / level**2)[noisy]) * level**2 if noisy.any() else 0.0
    guarded = np.where(noisy, np.sqrt(np.maximum(own, floor) + other), plain)
    z = differences.mean(0) / guarded
    count = tests * z.size
    typical = Test(0.0, float(np.median((guarded / level)[noisy])) if noisy.any() else 0.0, runs - 1, 1.0)
    means = samples.mean((1, 2)) / expected
    own_error = means.var(ddof=1) / runs + ROUNDING**2
    se = np.sqrt(own_error + reference.variance.mean() / reference.variance.size / expected**2)
    score = abs(means.mean() - 1) / se
    return Verdict(
        runs=runs,
        z=z.ravel(),
        plain_z=(differences.mean(0) / plain)[noisy],
        limit=float(t_quantile(1 - LEVEL / 2 / count, runs - 1)),
        image=Test(float(means.mean() - 1), float(se), runs - 1, float(t_two_sided(score, runs - 1))),
        detectable_block=typical.smallest_detectable(count),
        tests=tests,
    )
