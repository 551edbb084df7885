"""The comparison with Mitsuba on runs whose truth is known; Mitsuba itself is not needed."""

import numpy as np
from compare_with_mitsuba import compare, decode_rgbe
from gltf_edits import environment_for_mitsuba

from restirpg.scenes.images import encode_hdr


def noisy_runs(image, seed):
    """64 runs of an image (H, W, 3) with a relative error of 2% a pixel."""
    return image * np.random.default_rng(seed).normal(1, 0.02, (64, *image.shape))


def test_equal_images_are_found_equal_and_one_dark_block_different():
    image = np.random.default_rng(1).uniform(0.5, 2, (32, 32, 3))
    assert compare(noisy_runs(image, 2), noisy_runs(image, 3), 8).verdict == "equal"
    dark = image.copy()
    dark[8:16, 16:24] *= 0.99  # 0.06% of the image mean: only its block can show it
    result = compare(noisy_runs(dark, 2), noisy_runs(image, 3), 8)
    assert result.verdict == "DIFFERENT" and np.unravel_index(result.p.argmin(), result.p.shape)[:2] == (1, 2)


def test_a_mean_off_by_one_per_cent_is_different_and_one_under_noise_undecided():
    image = np.ones((16, 16, 3))
    assert compare(noisy_runs(image * 1.01, 2), noisy_runs(image, 3), 16).verdict == "DIFFERENT"
    offsets = np.random.default_rng(4).normal(0, 0.05, (2, 64, 1, 1, 1)) * image
    offsets += 0.004 - (offsets[0].mean() - offsets[1].mean()) * np.array([1, 0]).reshape(2, 1, 1, 1, 1)
    offsets[1] -= 0.004
    assert compare(image + offsets[0], image + offsets[1], 16).verdict == "undecided"


def test_environments_survive_their_file_and_keep_their_function_for_mitsuba():
    image = np.random.default_rng(5).uniform(0.1, 5, (8, 16, 3))
    body = encode_hdr(image).split(b"\n", 4)[-1]
    np.testing.assert_allclose(decode_rgbe(body, 8, 16), image, rtol=0.02, atol=0.05)
    rows = np.roll(environment_for_mitsuba(image), -8, axis=1)
    np.testing.assert_allclose(rows[1::2], image, rtol=1e-6)
    np.testing.assert_allclose(rows[2:-2:2], (image[1:] + image[:-1]) / 2, rtol=1e-6)
