"""Stands in for pyoidn beside the fake renderer: takes half of the noise away."""

import numpy as np

import restirpg


def denoise(color, albedo, normal, hdr, quality):
    """Half way between the picture and the truth."""
    return (0.5 * (color + restirpg.truth(color.shape[1], color.shape[0]))).astype(np.float32)
