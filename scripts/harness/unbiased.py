"""Is a method's mean the path tracer's? Independent runs, block means and their tests (ALGORITHMS O14, T1).

A run begins with a seed of its own and without history, and frame k of each run is one sample: frames of one
run are correlated. Null hypothesis: the mean over runs of every block of pixels is the reference's. |z| of a
block is compared with the two-sided quantile of Student's t at a false-alarm rate of LEVEL for the whole
family of tests (Bonferroni over blocks, and over the other tests that the caller names).
"""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from harness.jobs import seed_of
from harness.statistics import LEVEL, Test, block_means, luminance

BLOCK = 4  # pixels, the edge of a block


@dataclass(frozen=True)
class Reference:
    """What is taken for the truth, with its own error. Errors of different pixels are independent."""

    mean: np.ndarray  # (H, W), luminance
    variance: np.ndarray  # (H, W), of the error of `mean`


@dataclass(frozen=True)
class Verdict:
    """Outcome of the tests of one frame number."""

    runs: int
    z: np.ndarray  # standard scores of the blocks that have any spread
    limit: float  # largest |z| that chance explains
    image: Test  # of the image mean, relative to the reference's
    detectable_block: float  # median over blocks of the smallest relative bias that would be found
    tests: int  # blocks and others that share LEVEL

    @property
    def worst(self):
        """Largest |z| over its limit: above 1 the null hypothesis falls."""
        return float(np.abs(self.z).max() / self.limit)

    @property
    def mean(self):
        """|z| of the image mean."""
        return abs(self.image.difference) / self.image.se

    @property
    def detectable(self):
        """Relative bias of the image mean that would be found with a probability of 80%."""
        return self.image.smallest_detectable()

    @property
    def normality(self):
        """Kolmogorov and Smirnov's p-value of the scores against Student's t: a hint, for reuse correlates
        blocks.
        """
        return float(stats.kstest(self.z, stats.t(self.runs - 1).cdf).pvalue)

    def __str__(self):
        return (
            f"ratio {1 + self.image.difference:.4f} +- {self.image.se:.4f}, image z {self.mean:.2f}, "
            f"detectable {self.detectable:.3%}; largest |z| of {self.z.size} blocks "
            f"{np.abs(self.z).max():.2f}, limit {self.limit:.2f}, detectable {self.detectable_block:.2%}; "
            f"KS p {self.normality:.2g}"
        )


def run_seed(run, *parts):
    """The seed of a run, hashed: consecutive seeds are no independent ones everywhere (ALGORITHMS O22)."""
    return seed_of("unbiased", *parts, run)


def frames_of_run(renderer, seed, frames, before_frame=None, output="radiance"):
    """Luminance, (len(frames), H, W), of the frames (ascending, counted from 1) of one run.

    `output` shows one frame, no mean over frames. `before_frame`(renderer, k) may move the camera or nodes.
    """
    renderer.seed = seed
    renderer.cut()
    images = []
    for k in range(1, max(frames) + 1):
        if before_frame:
            before_frame(renderer, k)
        renderer.render(1)
        if k in frames:
            images.append(luminance(renderer.output(output)[..., :3]))
    return np.array(images)


def independent_runs(renderer, runs, frames, before_frame=None, output="radiance", family=0):
    """The given frames of each run: {k: (runs, H, W)}. Another `family` has other random numbers."""
    samples = [
        frames_of_run(renderer, run_seed(run, family), frames, before_frame, output) for run in range(runs)
    ]
    return dict(zip(frames, np.array(samples).swapaxes(0, 1)))


def compare(samples, reference, tests=1, block=BLOCK):
    """Verdict on samples (runs, H, W) of one frame number; so many `tests` share the false-alarm rate."""
    runs = len(samples)
    expected = reference.mean.mean()
    differences = block_means(samples - reference.mean, block)
    error = np.sqrt(
        differences.var(0, ddof=1) / runs + block_means(reference.variance, block) / block**2
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        z = differences.mean(0) / error
    z = z[~np.isnan(z)]  # 0 / 0: a block that is the same in every run and in the reference
    count = tests * max(z.size, 1)
    level = np.maximum(block_means(reference.mean, block), 1e-3 * expected)
    typical = Test(0.0, float(np.median(error / level)), runs - 1, 1.0)
    means = samples.mean((1, 2)) / expected
    se = np.sqrt(
        means.var(ddof=1) / runs + reference.variance.mean() / reference.variance.size / expected**2
    )
    score = abs(means.mean() - 1) / se if se > 0 else 0.0
    return Verdict(
        runs=runs,
        z=z,
        limit=float(stats.t.ppf(1 - LEVEL / 2 / count, runs - 1)),
        image=Test(float(means.mean() - 1), float(se), runs - 1, float(2 * stats.t.sf(score, runs - 1))),
        detectable_block=typical.smallest_detectable(count),
        tests=count,
    )
