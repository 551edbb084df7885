"""Means of runs: independent runs, a long run as a reference, and Welch's test of whether two sets of runs have one mean."""

import numpy as np
from renderer_scenes import check_samples

from restirpg.colour import luminance
from restirpg.harness.statistics import welch
from restirpg.harness.unbiased import Reference, run_seed

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


def frames_of_run(renderer, seed, frames, before_frame=None, output="radiance"):
    """Luminance, (len(frames), H, W), of the frames (ascending, counted from 1) of one run.

    `output` shows one frame, no mean over frames. `before_frame`(renderer, k) may move the camera or nodes. Fails
    where the graph's output `invalid` has counted a sample.
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
    if "invalid" in renderer.output_names:
        check_samples(renderer)
    return np.array(images)


def independent_runs(renderer, runs, frames, before_frame=None, output="radiance", family=0):
    """The given frames of each run: {k: (runs, H, W)}. Another `family` has other random numbers."""
    samples = [frames_of_run(renderer, run_seed(run, family), frames, before_frame, output) for run in range(runs)]
    return dict(zip(frames, np.array(samples).swapaxes(0, 1)))
