"""Tiles of a large picture, drawn at random, in which alone a reference is rendered and errors are measured.

The tiles are some of those of a grid that covers the picture, each as likely as any other, so that the mean over the
drawn tiles of a mean over a tile's pixels is an unbiased estimate of the picture's. Its standard error is that
of the tiles' means: each tile is one independent sample, however much its pixels have in common.

MAPE divides by the pixel's reference luminance plus 1% of the reference's mean luminance, and the bias is relative to
the reference's mean. Both means are estimated from the same tiles. The delta method accounts for their sampling error:
each tile's value gets (derivative of the result by the mean) * (tile mean - mean over tiles). The mean of the values
stays the same, and their spread includes the uncertainty of the estimated mean. The remaining error is of second order:
below 1% of MAPE with 24 tiles of the test's picture, whose luminance spans a factor of 500.

A stack is the picture of the tiles one below the other: whatever measures pictures measures stacks.
"""

import numpy as np

from restirpg.colour import luminance, mape_scale
from restirpg.harness import UserError

METRICS = ("mape", "relmse", "bias")


def choose(size, count, side, seed):
    """((x, y), ...): the corners of `count` of the grid's tiles, each of side x side pixels. Raises UserError."""
    columns, rows = size[0] // side, size[1] // side
    if (columns * side, rows * side) != tuple(size):
        raise UserError(
            f"tiles of {side}x{side} pixels do not cover {size[0]}x{size[1]}; choose a side that divides both with --tile-size"
        )
    if count > columns * rows:
        raise UserError(
            f"{size[0]}x{size[1]} has only {columns * rows} tiles of {side}x{side} pixels, not {count}; ask for fewer with --tiles"
        )
    drawn = np.random.default_rng(seed).choice(columns * rows, count, replace=False)
    return tuple((int(tile % columns) * side, int(tile // columns) * side) for tile in sorted(drawn))


def stack(image, corners, side):
    """The tiles of an image (H, W, C) one below the other, (tiles * side, side, C)."""
    return np.concatenate([image[y : y + side, x : x + side] for x, y in corners])


def errors(picture, truth, side):
    """{metric: (tiles,)} of a stack against another: each tile's share, whose mean is the whole's."""
    valid = np.isfinite(picture).all(axis=-1, keepdims=True)
    truth = np.asarray(truth, float)
    difference = np.where(valid, picture - truth, 0.0)
    y = luminance(truth)[..., None]
    weight = 1 / mape_scale(y)
    counts = np.maximum(valid.reshape(-1, side * side).sum(axis=1), 1) * picture.shape[-1]

    def by_tile(pixels):
        return pixels.reshape(len(counts), -1).sum(axis=1) / counts

    mape = by_tile(np.abs(difference) * weight)
    slope = -0.01 * by_tile(np.abs(difference) * weight**2).mean()
    bias = by_tile(difference) / truth.mean()
    y_tiles, means = (each.reshape(len(counts), -1).mean(axis=1) for each in (y, truth))
    return {
        "mape": mape + slope * (y_tiles - y.mean()),
        "relmse": by_tile(difference**2 / (truth**2 + 0.01)),
        "bias": bias - bias.mean() * (means / means.mean() - 1),
    }


def leave_one_out(batches):
    """The mean of all stacks of (R, H, W, 3) but one, for each in turn."""
    total = np.sum(batches, axis=0, dtype=float)
    return [(total - batch) / (len(batches) - 1) for batch in batches]


def jackknife_se(values):
    """The standard error of an estimate, from its values with one batch of the reference left out at a time."""
    values = np.asarray(values, float)
    return float(np.sqrt((len(values) - 1) / len(values) * np.sum((values - values.mean()) ** 2)))


def reference_errors(runs, batches, side):
    """{label: {metric: (R,)}}: a method's error with one batch of the reference left out at a time.

    runs: label -> results with `pictures`, by seed; batches: (R, H, W, 3) for each measured frame.
    """
    without = {id(each): leave_one_out(each) for each in batches}
    found = {}
    for label, seeds in runs.items():
        means = [
            {name: values.mean() for name, values in errors(picture, truth, side).items()}
            for number in range(len(batches[0]))
            for result in seeds
            for picture, truth in zip(result["pictures"], (without[id(each)][number] for each in batches))
        ]
        found[label] = {
            name: np.array([mean[name] for mean in means]).reshape(len(batches[0]), -1).mean(axis=1) for name in METRICS
        }
    return found
