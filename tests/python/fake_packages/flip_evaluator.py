"""Stands in for flip_evaluator: the mean difference of the pictures."""

import numpy as np


def evaluate(reference, image, dynamic_range, applyMagma):
    """As flip_evaluator.evaluate: map, mean, parameters."""
    assert dynamic_range == "HDR" and not applyMagma and reference.min() >= 0 <= image.min()
    return None, float(np.abs(image - reference).mean()), {}
