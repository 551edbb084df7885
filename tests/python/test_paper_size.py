"""scripts/reproduce.py --paper-size: what it makes of finished scenes, and what it refuses."""

import csv
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import restirpg

ROOT = Path(__file__).parents[2]
COLUMNS = ("scene", "method", "tiles", "frames", "mape", "mape_se", "mape_reference_se", "change", "change_se",
           "change_reference_se", "p", "gpu_ms", "wall_ms")  # fmt: skip
ROWS = {
    "restir_pt": (0.30, 0.01, 0.002, 0, 0, 0, "nan", 9000, 9100),
    "restir_pg": (0.27, 0.01, 0.002, -0.1, 0.01, 0.004, 1e-6, 11000, 11100),
    "raw_pt_ruppert2020": (0.26, 0.01, 0.002, -0.1333, 0.08, 0.004, 0.09, 12000, 12100),
}


def run(*arguments):
    """The program's finished process."""
    return subprocess.run(
        [sys.executable, ROOT / "scripts/reproduce.py", "--paper-size", *map(str, arguments)],
        capture_output=True,
        text=True,
    )


@pytest.fixture
def recorded(tmp_path):
    """A folder in which one scene is finished."""
    folder = tmp_path / "out" / "room"
    folder.mkdir(parents=True)
    with open(folder / "tiles.csv", "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(COLUMNS)
        writer.writerows(("scenes/room.glb", method, 64, 10, *numbers) for method, numbers in ROWS.items())
    return folder.parent


def test_the_table_says_plainly_who_errs_least(recorded, tmp_path):
    done = run("--collect", recorded, "--results", tmp_path / "results")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "results/tables.md").read_text()
    assert "| room | restir_pg | 27.00 ± 1.00 ± 0.20% | -10.00 ± 1.00 ± 0.40% | 1e-06 | 11.0 |" in text
    assert "the lowest mean error has raw_pt_ruppert2020, 26.0%; restir_pg does not have the lowest: 27.0%" in text
    assert (
        "restir_pg errs 10.0% less than restir_pt; raw_pt_ruppert2020 errs 13.3% less than restir_pt, which is not significant."
        in text
    )
    with open(tmp_path / "results/summary.csv", newline="") as stream:
        assert [(row["scene"], row["method"]) for row in csv.DictReader(stream)] == [
            ("room", method) for method in ROWS
        ]


def test_what_it_cannot_do_is_said_in_a_line(tmp_path):
    twice = ("room.glb@64x64", "room.glb@32x32")
    for arguments, words in (
        ((), "no scene given"),
        (("--collect", tmp_path), "no scene is finished there"),
        ((*twice, "--out", tmp_path), "two scenes would be called 'room'"),
    ):
        done = run(*arguments)
        assert done.returncode == 2 and words in done.stderr and done.stderr.count("\n") == 1


def test_the_hours_of_each_scene_are_told():
    done = run("--list", "veach_ajar.glb", "hall.glb@960x540")
    assert done.returncode == 0, done.stderr
    line = re.compile(r"(\S+) +\S+  (\S+) to (\S+) hours, ")
    (room, low, high), (hall, small, _) = (line.match(text).groups() for text in done.stdout.splitlines())
    assert (room, hall) == ("veach_ajar", "hall")
    assert 2 < float(low) / float(small) < 4 and 0.3 < float(low) < float(high) < 3


def figure(recorded, *arguments, crop="4,4"):
    """benchmarks/paper_figure.py, run to its end."""
    command = [sys.executable, ROOT / "benchmarks/paper_figure.py", recorded / "room", "--crop", "0,0", "--crop", crop]
    command += ["--scene", "room.glb", "--side", 4, "--bounces", 0, "--png", recorded / "figure.png", *arguments]
    return subprocess.run(list(map(str, command)), capture_output=True, text=True)


def test_a_figure_that_cannot_be_drawn_is_one_line(recorded):
    images = recorded / "room/images"
    images.mkdir()
    for method in ROWS:
        restirpg.write_exr(images / f"room.{method}.whole.exr", {"": np.ones((9, 16, 3), np.float32)})
    beyond = figure(recorded, crop="4,6")
    assert "--crop 4,6: 4x4 pixels from there reach beyond the picture of 16x9" in beyond.stderr
    scene = figure(recorded)
    assert "room.glb" in scene.stderr
    table = recorded / "room/tiles.csv"
    table.write_text(table.read_text().replace("restir_pg,", "other,"))
    other = figure(recorded)
    assert "tiles.csv: no row is of restir_pg" in other.stderr
    table.unlink()
    for done in (beyond, scene, other, figure(recorded)):
        assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
