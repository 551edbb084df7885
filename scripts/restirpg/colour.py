"""What pictures are measured and shown by: luminance, sRGB, and the error of a pixel."""

import numpy as np

REC_709 = np.array([0.2126, 0.7152, 0.0722])  # luminance of red, green and blue


def luminance(image, dtype=float):
    """Rec. 709 luminance of linear (..., 3)."""
    return np.asarray(image, dtype) @ REC_709.astype(dtype)


def srgb(linear):
    """Linear values in [0, 1] as sRGB has them, in [0, 1] (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def mape_scale(y):
    """What MAPE divides differences by: the reference's luminance `y` plus 1% of its mean."""
    return 0.01 * y.mean() + y


def relative_error(image, reference, dtype=float):
    """|image - reference| over mape_scale(), mean over the channels: of images (..., H, W, C) and a reference (H, W, C) the
    pixels (..., H, W), whose mean is the MAPE. Where C is not 3, luminance is the mean of the channels."""
    reference = np.asarray(reference, dtype)
    y = luminance(reference, dtype) if reference.shape[-1] == 3 else reference.mean(axis=-1)
    return np.abs(np.asarray(image, dtype) - reference).mean(axis=-1) / (mape_scale(y) + dtype(1e-30))
