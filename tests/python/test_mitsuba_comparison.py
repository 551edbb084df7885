"""The comparison with Mitsuba on runs whose truth is known; Mitsuba itself is not needed."""

from pathlib import Path
from types import SimpleNamespace

import image_means
import numpy as np
import pytest
from compare_with_mitsuba import compare, decode_rgbe
from finished_rows import append_row, read_rows
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


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of variances
def test_without_a_test_nothing_is_called_equal():
    image = np.ones((16, 16, 3))
    one = compare(image[None], image[None], 8)
    assert np.isnan(one.corrected_p) and one.verdict == "undecided"
    broken = noisy_runs(image, 2)
    broken[0, 3, 3] = np.nan
    assert compare(broken, noisy_runs(image, 3), 8).verdict == "undecided"


def test_a_block_that_is_black_in_every_run_is_equal_and_one_that_is_lit_in_one_renderer_alone_is_not():
    image = np.ones((16, 16, 3))
    image[:8, :8] = 0
    result = compare(noisy_runs(image, 2), noisy_runs(image, 3), 8)
    assert result.verdict == "equal" and (result.p[0, 0] == 1).all()
    lit = image + 1e-3 * (image == 0)
    assert compare(noisy_runs(image, 2), noisy_runs(lit, 3), 8).verdict == "DIFFERENT"


def test_environments_survive_their_file_and_keep_their_function_for_mitsuba():
    image = np.random.default_rng(5).uniform(0.1, 5, (8, 16, 3))
    body = encode_hdr(image).split(b"\n", 4)[-1]
    np.testing.assert_allclose(decode_rgbe(body, 8, 16), image, rtol=0.02, atol=0.05)
    rows = np.roll(environment_for_mitsuba(image), -8, axis=1)
    np.testing.assert_allclose(rows[1::2], image, rtol=1e-6)
    np.testing.assert_allclose(rows[2:-2:2], (image[1:] + image[:-1]) / 2, rtol=1e-6)


def test_a_run_under_another_environment_or_back_end_is_not_finished(tmp_path):
    """The file is from before both were noted."""
    file, room = tmp_path / "means.csv", Path("room.glb")
    file.write_text(
        "scene,renderer,seed,width,height,bounces,samples,r,g,b,seconds\n"
        "room,ours,1,64,36,4,256,1,1,1,9\nroom,mitsuba,1,64,36,4,256,1,1,1,9\n"
    )

    def finished(renderer, **changes):
        plain = {"environment": None, "backend": None, "size": (64, 36), "bounces": 4, "frames": 256, "samples": 256}
        return image_means.is_finished(room, renderer, 1, SimpleNamespace(csv=file, **{**plain, **changes}))

    for _ in range(2):
        assert finished("ours") and finished("mitsuba") and finished("mitsuba", backend="software")
        assert not finished("ours", backend="software") and not finished("ours", environment="1,1,1")
        assert not finished("mitsuba", environment="1,1,1")
        append_row(file, image_means.COLUMNS, ("room", "ours", 2, 64, 36, 4, 256, "", "", 1, 1, 1, 9))  # written anew


def test_means_under_two_environments_are_two_rows(tmp_path, capsys):
    file = tmp_path / "means.csv"
    for environment, brightness in (("", 1), ("2,2,2", 2)):
        for renderer in ("ours", "mitsuba"):
            for seed in (1, 2):
                mean = 3 * (brightness + 0.01 * seed,)
                append_row(
                    file, image_means.COLUMNS, ("room", renderer, seed, 64, 36, 4, 16, environment, "", *mean, 9)
                )
    image_means.print_table(read_rows(file))
    rows = capsys.readouterr().out.splitlines()[2:]
    assert [row.split(" | ")[0] for row in rows] == ["| room", "| room, 2,2,2"]
    assert " | 1.01500 +- " in rows[0] and " | 2.01500 +- " in rows[1]
