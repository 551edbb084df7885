"""Images through Python: EXR, PNG and the error metrics, as NumPy arrays."""

import os

import numpy as np
import pytest
from renderer_scenes import one_line_refusal as refusal
from renderer_scenes import restirpg


def random_image(seed, shape=(9, 7, 3)):
    """Values over several orders of magnitude."""
    return np.random.default_rng(seed).lognormal(0, 2, shape).astype(np.float32)


def test_layers_of_any_float_array_come_back(tmp_path):
    colour, depth = random_image(1), random_image(2, (9, 7))
    restirpg.write_exr(
        tmp_path / "a.exr", {"": colour[:, ::-1], "depth": depth.astype(np.float64)}, attributes={"note": "two layers"}
    )
    np.testing.assert_array_equal(restirpg.read_exr(tmp_path / "a.exr"), colour[:, ::-1])
    np.testing.assert_array_equal(restirpg.read_exr(str(tmp_path / "a.exr"), layer="depth"), np.dstack([depth] * 3))
    assert restirpg.read_exr_attributes(tmp_path / "a.exr") == {"note": "two layers"}


def test_attributes_of_any_bytes_are_read(tmp_path):
    file, note = tmp_path / "a.exr", "caf\u00e9\t\u202e\nline"
    restirpg.write_exr(file, {"": random_image(1)}, attributes={"note": note})
    assert restirpg.read_exr_attributes(file) == {"note": note}
    file.write_bytes(file.read_bytes().replace("\u00e9".encode(), b"\xe9!"))
    assert restirpg.read_exr_attributes(file) == {"note": note.replace("\u00e9", "\\xe9!")}


def test_an_attribute_of_the_headers_own_is_refused(tmp_path):
    for name in ("compression", "dataWindow", ""):
        text = refusal(restirpg.write_exr, tmp_path / "a.exr", {"": random_image(1)}, attributes={name: "x"})
        assert f"a.exr: cannot write: attribute '{name}': " in text and text.endswith("; choose another name for it")
    assert os.listdir(tmp_path) == []


def test_half_floats_keep_three_digits(tmp_path):
    image = random_image(3)
    restirpg.write_exr(tmp_path / "a.exr", {"": image}, half=True)
    np.testing.assert_allclose(restirpg.read_exr(tmp_path / "a.exr"), image, rtol=5e-4)


def test_a_png_is_written_for_each_view(tmp_path):
    restirpg.write_png(tmp_path / "a.png", random_image(4), exposure=-1)
    restirpg.write_png(tmp_path / "b.png", random_image(4)[..., 0], view="ACES")
    for name in ("a.png", "b.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
    assert "choose from Standard, ACES" in refusal(restirpg.write_png, tmp_path / "c.png", random_image(4), view="Film")
    assert sorted(os.listdir(tmp_path)) == ["a.png", "b.png"]


def test_the_metrics_are_those_of_their_definition():
    image, reference = random_image(5), random_image(6)
    image[0, 0, 1] = np.nan
    errors = restirpg.measure_errors(image, reference)
    valid = np.isfinite(image).all(-1)
    i, r = image[valid].astype(float), reference[valid].astype(float)
    y = r @ [0.2126, 0.7152, 0.0722]
    expected = {
        "mape": np.mean(np.abs(i - r) / (0.01 * y.mean() + y)[:, None]),
        "relmse": np.mean((i - r) ** 2 / (r**2 + 0.01)),
        "rmse": np.sqrt(np.mean((i - r) ** 2)),
        "bias": (i.mean() - r.mean()) / r.mean(),
        "invalid": 1,
    }
    assert errors == pytest.approx(expected, rel=1e-12)


def test_wrong_shapes_and_files_are_refused_in_one_line(tmp_path):
    assert "9x7" not in refusal(restirpg.measure_errors, random_image(1), random_image(1, (9, 8, 3)))
    assert "shape (3,)" in refusal(restirpg.write_exr, tmp_path / "a.exr", {"": np.zeros(3)})
    assert "shape (0, 4, 3)" in refusal(restirpg.write_png, tmp_path / "a.png", np.zeros((0, 4, 3)))
    assert "layer 'b' is 7x9" in refusal(
        restirpg.write_exr, tmp_path / "a.exr", {"": random_image(1, (4, 4, 3)), "b": random_image(1)}
    )
    said = refusal(restirpg.write_exr, tmp_path / "a.exr", {"": "text"})
    assert said == "layer '' must be an array of numbers, not 'text'"
    assert "no layers" in refusal(restirpg.write_exr, tmp_path / "a.exr", {})
    (tmp_path / "text.exr").write_text("no image")
    assert "text.exr: cannot read" in refusal(restirpg.read_exr, tmp_path / "text.exr")
    assert "missing.exr: cannot read" in refusal(restirpg.read_exr, tmp_path / "missing.exr")
    assert os.listdir(tmp_path) == ["text.exr"]
