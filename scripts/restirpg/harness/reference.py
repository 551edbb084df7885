"""The reference picture: independent batches of the path tracer, so that its own standard error is known."""

import numpy as np

from restirpg.colour import luminance, mape_scale
from restirpg.harness import UserError, render, tiles
from restirpg.harness.jobs import digest
from restirpg.harness.statistics import block_means


def key_of_batches(jobs):
    """The key of the reference that these jobs make together."""
    return digest(" ".join(job.key for job in jobs).encode())


def finite(image):
    """The image with 0 in place of what is no finite number."""
    return np.nan_to_num(image, nan=0, posinf=0, neginf=0)


def combine(cache, jobs):
    """Merge finished batches into one result, keep it under key_of_batches, and return it.

    `mean` (H, W, 3), `variance`: of that mean, per pixel and channel (sample variance of the batches over
    their number), `luminance_variance`: the same of luminance, mean over pixels; `batch_means` (R): each
    batch's mean over pixels and channels; `batch_blocks` (R, H/8, W/8): luminance.
    """
    mean, squares, luminance_squares, means, blocks = 0.0, 0.0, 0.0, [], []
    sums = dict.fromkeys(("wall_ms", "invalid", "dropped"), 0)
    for number, job in enumerate(jobs, 1):  # Welford: one batch in memory at a time
        batch = cache.need(job.key)
        image = finite(batch["image"].astype(float))
        step = image - mean
        mean = mean + step / number
        squares = squares + step * (image - mean)
        luminance_squares += np.mean(luminance(step) * luminance(image - mean))
        means.append(image.mean())
        blocks.append(block_means(luminance(image)))
        sums = {name: value + batch["meta"][name] for name, value in sums.items()}
    count = len(jobs)
    scale = max(count - 1, 1) * count
    result = {
        "mean": mean.astype(np.float32),
        "variance": (squares / scale).astype(np.float32),
        "luminance_variance": np.array(luminance_squares / scale),
        "batch_means": np.array(means),
        "batch_blocks": np.array(blocks),
        "meta": {
            "source": jobs[0].graph,
            "batches": count,
            "frames": jobs[0].frames,
            **sums,
            "knobs": batch["meta"]["knobs"],
            "device": batch["meta"]["device"],
        },
    }
    cache.store(key_of_batches(jobs), result)
    return result


def read(file, size):
    """An EXR's picture; raises UserError where it cannot be a reference."""
    image = render.read_exr(file)
    if image.shape[:2] != (size[1], size[0]):
        raise UserError(
            f"{file}: the reference is {image.shape[1]}x{image.shape[0]}; give that as --size, not {size[0]}x{size[1]}"
        )
    if invalid := int(np.sum(~np.isfinite(image).all(axis=-1))):
        raise UserError(
            f"{file}: {invalid} of its pixels are NaN or infinite, so that it is no reference; "
            "give another picture, or leave out --reference"
        )
    return image


def from_exr(cache, file, size, corners=(), side=0):
    """An EXR as a reference, or its tiles at those corners, taken as exact. Returns (key, result); raises UserError."""
    image = read(file, size)
    if corners:
        image = tiles.stack(image, corners, side)
    result = {
        "mean": image,
        "variance": np.zeros_like(image),
        "luminance_variance": np.array(0.0),
        "batch_means": np.array([image.mean(dtype=float)]),
        "batch_blocks": block_means(luminance(image))[None],
        "meta": {
            "source": str(file),
            "batches": 0,
            "frames": 0,
            "wall_ms": 0.0,
            "knobs": {},
            "device": {},
        },
    }
    key = digest(image.tobytes() + str(image.shape).encode())
    cache.store(key, result)
    return key, result


def noise(reference):
    """What the reference's own noise adds: `relmse` (subtracted from measured ones), `mape` (its own expected
    MAPE, of a normal error: a floor, not subtracted), `relative_se` of the image's mean, `luminance_variance`
    (mean over pixels).
    """
    mean, variance = reference["mean"].astype(float), reference["variance"].astype(float)
    y = luminance(mean)
    error = np.sqrt(2 / np.pi * variance)
    batches = reference["batch_means"]
    se = batches.std(ddof=1) / np.sqrt(len(batches)) if len(batches) > 1 else 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        return {
            "relmse": float(np.mean(variance / (mean**2 + 0.01))),
            "mape": float(np.mean(error / mape_scale(y)[..., None])),
            "relative_se": float(se / batches.mean()),
            "luminance_variance": float(reference["luminance_variance"]),
        }
