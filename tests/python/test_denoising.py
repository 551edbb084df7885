"""Denoising: what is asked of the optional package pyoidn, which a stand-in plays where it is not installed."""

import importlib.util
import re
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from harness_runs import ENVIRONMENT, SCRIPT, compare, csv_rows
from renderer_scenes import make_renderer, restirpg

from restirpg import denoise_file
from restirpg.harness import statistics


def test_without_the_package_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyoidn", None)
    with pytest.raises(ImportError, match="pip install pyoidn"):
        restirpg.denoise(np.zeros((4, 4, 3)))


def test_the_denoiser_is_given_clean_pictures_of_one_shape(monkeypatch):
    given = {}
    stand_in = types.SimpleNamespace(
        denoise=lambda *images, **settings: given.update(images=images, **settings) or images[0]
    )
    monkeypatch.setitem(sys.modules, "pyoidn", stand_in)
    image = np.array([[[np.nan, -1, 2]]])
    restirpg.denoise(image, albedo=np.ones((1, 1, 3)))
    assert given["images"][0].tolist() == [[[0, 0, 2]]] and given["images"][2] is None and given["hdr"]
    with pytest.raises(ValueError, match="'normal' has the shape"):
        restirpg.denoise(image, normal=np.ones((2, 1, 3)))


@pytest.mark.skipif(not importlib.util.find_spec("pyoidn"), reason="pyoidn is not installed: no picture is denoised")
def test_a_denoised_picture_is_nearer_to_the_truth(scene):
    renderer = make_renderer(scene, outputs=["albedo", "normal"])
    renderer.render(2)
    noisy, aids = renderer.output("image"), [renderer.output(name) for name in ("albedo", "normal")]
    renderer.render(254)
    truth = renderer.output("image")
    errors = [restirpg.measure_errors(image, truth)["mape"] for image in (restirpg.denoise(noisy, *aids), noisy)]
    assert errors[0] < 0.8 * errors[1]


@pytest.fixture
def noisy(renderer, tmp_path, monkeypatch):
    """A rendered EXR file; a stand-in for pyoidn halves its values."""
    monkeypatch.setitem(sys.modules, "pyoidn", types.SimpleNamespace(denoise=lambda image, *_, **__: image / 2))
    renderer.render(1)
    renderer.save(tmp_path / "noisy.exr")
    return tmp_path / "noisy.exr"


def test_a_denoised_file_says_so_and_what_it_is_of(noisy):
    denoised = noisy.with_name("denoised.exr")
    assert denoise_file.main([str(noisy), str(denoised)]) == 0
    np.testing.assert_array_equal(restirpg.read_exr(denoised), restirpg.read_exr(noisy) / 2)
    own = restirpg.read_exr_attributes(noisy)
    assert restirpg.read_exr_attributes(denoised) == {**own, "restirpg.denoised": "true"} and "restirpg.seed" in own


@pytest.mark.parametrize("link", [None, "symlink_to", "hardlink_to"])
def test_a_file_is_not_denoised_into_itself(noisy, link, capsys):
    target, before = noisy, noisy.read_bytes()
    if link:
        target = noisy.with_name("link.exr")
        getattr(target, link)(noisy)
    assert denoise_file.main([str(noisy), str(target)]) == 2
    told = capsys.readouterr().err
    assert told == (
        f"restirpg.denoise_file: {target}: cannot write: it is the file {noisy}, which was read; choose another name\n"
    )
    assert noisy.read_bytes() == before


def test_errors_after_denoising_stand_apart(tmp_path, monkeypatch):
    """The stand-in halves the noise, and so the error of a picture that is measured beside a much better reference."""
    folder = Path(__file__).parent / "fake_packages"
    monkeypatch.setitem(ENVIRONMENT, "PYTHONPATH", f"{folder}:{ENVIRONMENT['PYTHONPATH']}")
    methods, options = ("plain.json", "plain.json@noise=0.5,label=quiet"), {"reference_frames": 4096, "cache": "runs"}
    assert compare(tmp_path, *methods, out="plain", **options).returncode == 0
    run = compare(tmp_path, *methods, program=SCRIPT, denoise=[], **options)
    assert run.returncode == 0, run.stderr
    assert not (tmp_path / "plain/denoised.csv").exists()
    for name in ("summary.csv", "runs.csv"):  # the other figures do not change
        assert (tmp_path / "out" / name).read_text() == (tmp_path / "plain" / name).read_text()
    assert (
        "Error after denoising" in run.stdout
        and "Error after denoising" not in (tmp_path / "plain/tables.txt").read_text()
    )
    before = {
        (row["method"], row["seed"]): float(row["mape"])
        for row in csv_rows(tmp_path / "out/runs.csv")
        if row["frame"] == "8"
    }
    after = {
        (row["method"], row["seed"]): float(row["mape_denoised_image"])
        for row in csv_rows(tmp_path / "out/denoised.csv")
    }
    assert len(after) == 8 and all(after[run] == pytest.approx(0.5 * before[run], rel=0.1) for run in after)
    page = (tmp_path / "out/report.html").read_text()
    assert "last frame, denoised" in page and "FLIP of the last frame" in page


def test_of_frames_measured_alone_one_picture_is_denoised_and_tested_once(tmp_path, monkeypatch):
    """The p in the table is that of a single test: nothing was corrected for a second one."""
    folder = Path(__file__).parent / "fake_packages"
    monkeypatch.setitem(ENVIRONMENT, "PYTHONPATH", f"{folder}:{ENVIRONMENT['PYTHONPATH']}")
    run = compare(tmp_path, "plain.json", "plain.json@blotch=2,label=blotchy", program=SCRIPT, denoise=[], at="4,8")
    assert run.returncode == 0, run.stderr
    found = csv_rows(tmp_path / "out/denoised.csv")
    assert list(found[0]) == ["scene", "method", "seed", "mape_denoised_frame"]
    plain, other = (
        np.array([float(row["mape_denoised_frame"]) for row in found if row["method"] == method])
        for method in ("plain", "blotchy")
    )
    table = run.stdout[run.stdout.index("Error after denoising") :]
    told = float(re.search(r"blotchy .*\(p = ([\d.e-]+)\)", table)[1])
    assert told == pytest.approx(statistics.paired(other, plain).p, rel=0.06)


def test_a_comparison_cannot_denoise_without_the_package(tmp_path, monkeypatch):
    hidden = tmp_path / "hidden"
    hidden.mkdir()
    (hidden / "sitecustomize.py").write_text('import sys\nsys.modules["pyoidn"] = None\n')  # also where it is installed
    monkeypatch.setitem(ENVIRONMENT, "PYTHONPATH", f"{hidden}:{ENVIRONMENT['PYTHONPATH']}")
    run = compare(tmp_path, denoise=[])
    assert run.returncode == 2 and "pip install pyoidn" in run.stderr and run.stderr.count("\n") == 1
