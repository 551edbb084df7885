"""The CSV files of scripts/compare.py: the tables can be made from them again, and their columns are documented."""

import csv
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from harness_runs import ENVIRONMENT, ROOT, compare

METHODS = ("plain.json", "plain.json@ms=3.7,noise=0.5,label=dear")
OPTIONS = {"equal_frame_time": "paths.neighbours", "frames": 6, "seeds": 3}


def rows(folder, name):
    """A CSV file's rows."""
    with open(folder / "out" / name) as stream:
        return list(csv.DictReader(stream))


def column(found, name, **wanted):
    """The numbers of a column where others have these values."""
    chosen = [row for row in found if all(row[key] == value for key, value in wanted.items())]
    return np.array([float(row[name]) for row in chosen])


@pytest.fixture(scope="module", params=[{}, {"at": "3,6"}, {"at": "3,6", "tiles": 6, "tile_size": 8}])
def finished(request, tmp_path_factory):
    """The folder of a comparison with everything that can be asked for, and how it was measured."""
    packages = f"{Path(__file__).parent / 'fake_packages'}:{ENVIRONMENT['PYTHONPATH']}"
    folder = tmp_path_factory.mktemp("csv")
    denoise = {} if "tiles" in request.param else {"denoise": []}
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(ENVIRONMENT, "PYTHONPATH", packages)
        run = compare(folder, *METHODS, **OPTIONS, **denoise, **request.param)
    assert run.returncode == 0, run.stderr
    return folder, request.param


def test_lines_end_as_in_every_other_file(finished):
    written = [file for file in (finished[0] / "out").glob("*.csv") if b"\r" in file.read_bytes()]
    tracked = subprocess.run(["git", "-C", ROOT, "ls-files", "*.csv"], capture_output=True, text=True).stdout.split()
    assert not written and not [name for name in tracked if b"\r" in (ROOT / name).read_bytes()]


def test_the_runs_give_the_summary_again(finished):
    folder, how = finished
    runs, unit = rows(folder, "runs.csv"), "tile" if "tiles" in how else "seed"
    assert unit in runs[0] and len({"seed", "tile"} & runs[0].keys()) == 1
    counted = ["3", "6"] if how else ["4", "5", "6"]  # single frames that have settled, or all asked for
    for row in rows(folder, "summary.csv"):
        own = [run for run in runs if run["method"] == row["method"]]
        single = np.mean([column(own, "mape_single", frame=frame) for frame in counted], axis=0)
        assert len(single) == (6 if unit == "tile" else 3)
        for name, values in (
            ("mape_frame", column(own, "mape", frame="6")),
            ("mape_single", single),
            ("gpu_ms_per_frame", column(own, "gpu_ms_total", frame="6") / 6),
            *([] if unit == "tile" else [("flip", column(own, "flip", frame="6"))]),
        ):
            assert float(row[name]) == pytest.approx(np.mean(values), rel=1e-5), name
            if name != "gpu_ms_per_frame":
                assert float(row[f"{name}_se"]) == pytest.approx(np.std(values, ddof=1) / len(values) ** 0.5, rel=1e-5)


def test_the_runs_of_raised_settings_give_equal_frame_time_again(finished):
    folder, how = finished
    runs = rows(folder, "equal_time_runs.csv")
    counted = ["3", "6"] if how else ["4", "5", "6"]
    [row] = [row for row in rows(folder, "equal_time.csv") if row["method"] == "plain"]
    assert {(run["method"], run["knob"], run["value"]) for run in runs} == {
        ("plain", "paths.neighbours", value) for value in "34"
    }
    three, four = (
        np.mean([column(runs, "mape_single", value=value, frame=frame) for frame in counted]) for value in "34"
    )
    assert float(row["mape"]) == pytest.approx(0.6 * three + 0.4 * four, rel=1e-5)


def test_every_column_is_in_the_readme(finished):
    page = (ROOT / "scripts/README.md").read_text()
    told = {
        name: set(re.findall(r"`([\w.]+)`", text))
        for name, text in re.findall(r"^\| `(\w+\.csv)` \|.*?\| (.*) \|$", page, re.MULTILINE)
    }
    told["equal_time_runs.csv"] |= told["runs.csv"]
    for file in (finished[0] / "out").glob("*.csv"):
        names = {re.sub(r"(?<=.)_(se|p)$", "", name) for name in rows(finished[0], file.name)[0]}
        known = {re.sub(r"_(se|p)$", "", name) for name in told[file.name]}
        assert names <= known, (file.name, names - known)
