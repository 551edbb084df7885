"""The comparison with Mitsuba on runs whose truth is known; Mitsuba itself is not needed."""

from contextlib import nullcontext
from types import SimpleNamespace

import error_over_time
import image_means
import numpy as np
import pytest
from compare_with_mitsuba import check_scenes, compare, decode_radiance, read_environment
from finished_rows import append_row, read_rows
from gltf_edits import environment_for_mitsuba, write_glb

from restirpg.harness import UserError
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


def test_means_that_are_near_by_luck_are_not_called_equal():
    """One ratio of exactly 1, whose standard error is 0.9%."""
    offsets = np.random.default_rng(4).normal(0, 0.05, (2, 64, 1, 1, 1)) * np.ones((16, 16, 3))
    offsets -= offsets.mean(axis=1, keepdims=True)
    result = compare(1 + offsets[0], 1 + offsets[1], 16)
    assert result.ratio == pytest.approx(1) and result.ratio_se > 0.005 and result.verdict == "undecided"


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
    np.testing.assert_allclose(decode_radiance(encode_hdr(image)), image, rtol=0.02, atol=0.05)
    rows = np.roll(environment_for_mitsuba(image), -8, axis=1)
    np.testing.assert_allclose(rows[1::2], image, rtol=1e-6)
    np.testing.assert_allclose(rows[2:-2:2], (image[1:] + image[:-1]) / 2, rtol=1e-6)


@pytest.mark.parametrize("case", ["exposure", "upside down", "run too long", "cut short", "not coded", "of no run"])
def test_a_radiance_file_of_another_kind_is_refused_in_one_line(tmp_path, case):
    whole = encode_hdr(np.full((8, 16, 3), 0.5))
    head, _, body = whole.partition(b"+X 16\n")
    damaged = {
        "exposure": whole.replace(b"FORMAT", b"EXPOSURE=2\nFORMAT"),
        "upside down": whole.replace(b"-Y", b"+Y"),
        "run too long": whole.replace(b"+X 16", b"+X 15"),
        "cut short": whole[:-3],
        "not coded": head + b"+X 16\n" + bytes(8 * 16 * 4),
        "of no run": head + b"+X 16\n" + body[:4] + bytes(len(body) - 4),
    }[case]
    assert damaged != whole
    (tmp_path / "sky.hdr").write_bytes(damaged)
    with pytest.raises(UserError, match=r"sky\.hdr: read for Mitsuba are"):
        read_environment(tmp_path / "sky.hdr")


@pytest.mark.parametrize(
    "setting, refused", [({"strength": 2.0}, True), ({"rotation": 90}, True), ({"strength": 1}, False)]
)
def test_light_that_mitsuba_would_not_get_is_refused(tmp_path, setting, refused):
    extras = {"restirpg": {"environment": [1, 1, 1], **setting}}
    scene = write_glb(tmp_path / "room.glb", {"asset": {"version": "2.0", "extras": extras}}, b"")
    with pytest.raises(UserError, match=f"not get the {next(iter(setting))}") if refused else nullcontext():
        check_scenes(SimpleNamespace(scenes=[scene], environment=None))
    check_scenes(SimpleNamespace(scenes=[scene], environment="1,1,1"))


def options_of(**changes):
    plain = {"environment": None, "backend": None, "size": (64, 36), "bounces": 4, "frames": 16, "samples": 16}
    return SimpleNamespace(**{**plain, **changes})


def append_mean(file, scene, renderer, seed, mean, **changes):
    key = image_means.key_of(scene, renderer, seed, options_of(**changes))
    append_row(file, image_means.COLUMNS, (*key, mean, mean, mean, 9))


@pytest.fixture
def room(tmp_path):
    return write_glb(tmp_path / "room.glb", {"asset": {"version": "2.0"}}, b"")


def test_a_run_of_another_scene_commit_environment_or_back_end_is_not_finished(tmp_path, room, monkeypatch):
    file = tmp_path / "means.csv"

    def finished(renderer, scene=room, **changes):
        return image_means.is_finished(scene, renderer, 1, options_of(csv=file, **changes))

    for renderer in ("ours", "mitsuba"):
        append_mean(file, room, renderer, 1, 1)
    assert finished("ours") and finished("mitsuba") and finished("mitsuba", backend="software")
    assert not finished("ours", backend="software") and not finished("ours", environment="1,1,1")
    assert not finished("mitsuba", environment="1,1,1")
    (tmp_path / "other").mkdir()
    other = write_glb(tmp_path / "other" / room.name, {"asset": {"version": "2.0", "generator": "b"}}, b"")
    assert not finished("ours", other) and not finished("mitsuba", other)
    monkeypatch.setattr(image_means, "commit", lambda: "another")
    assert not finished("ours")


def test_means_under_two_environments_are_two_rows(tmp_path, room, capsys):
    file = tmp_path / "means.csv"
    for environment, brightness in (("", 1), ("2,2,2", 2)):
        for renderer in ("ours", "mitsuba"):
            for seed in (1, 2):
                append_mean(file, room, renderer, seed, brightness + 0.01 * seed, environment=environment)
    image_means.print_table(read_rows(file), file)
    rows = capsys.readouterr().out.splitlines()[2:]
    assert [row.split(" | ")[0] for row in rows] == ["| room", "| room, 2,2,2"]
    assert " | 1.01500 +- " in rows[0] and " | 2.01500 +- " in rows[1]


@pytest.mark.parametrize(
    "changes, words",
    [({"backend": "rayquery"}, "backend none and rayquery"), ({"frames": 64}, "samples 16 and 64"), ({}, "and alike")],
)
def test_one_run_under_two_settings_is_not_two_runs(tmp_path, room, changes, words):
    """Both have the same random numbers."""
    file = tmp_path / "means.csv"
    for seed in (1, 2):
        for renderer in ("ours", "mitsuba"):
            append_mean(file, room, renderer, seed, 1 + 0.01 * seed)
    append_mean(file, room, "ours", 1, 1.01, **changes)
    with pytest.raises(UserError, match=rf"means\.csv: room: two rows are of ours, 64x36, seed 1: {words};"):
        image_means.print_table(read_rows(file), file)


def test_errors_over_time_have_standard_errors_and_a_table_for_each_size(tmp_path, capsys):
    file = tmp_path / "times.csv"
    for size, seconds in (("16x9", 1), ("32x18", 5)):
        for seed in (1, 2):
            append_row(
                file, error_over_time.COLUMNS, ("room", "mitsuba", size, 4, 16, seed, seconds + seed, 0.1 * seed)
            )
    append_row(file, error_over_time.COLUMNS, ("room", "mitsuba", "16x9", 4, 64, 1, 9, 0.05))
    error_over_time.print_tables(file)
    lines = capsys.readouterr().out.splitlines()
    assert "| 16 | 2.5 ± 0.5, 15.0 ± 5.0% |" in lines and "| 16 | 6.5 ± 0.5, 15.0 ± 5.0% |" in lines
    assert "| 64 | 9.0, 5.0% |" in lines and "| room, 32x18, cap 4: samples | mitsuba: s, MAPE |" in lines
