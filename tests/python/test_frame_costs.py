"""benchmarks/frame_costs.py: a row a method, its times in a file, and mistakes in a line."""

import subprocess
import sys

import frame_costs
import pytest
from harness_runs import csv_rows
from renderer_scenes import ROOT

TRACER = ROOT / "graphs/path_tracer.py"


def run(*arguments):
    return subprocess.run(
        [sys.executable, ROOT / "benchmarks/frame_costs.py", *map(str, arguments)], capture_output=True, text=True
    )


def test_methods_render_in_turn_and_every_pass_is_written(scene_file, tmp_path):
    file = tmp_path / "times.csv"
    done = run(
        TRACER, f"{TRACER}@bounces=1,label=short", "--scene", scene_file, "--size", "16x9", "--turns", 2, "--csv", file
    )
    assert done.returncode == 0, done.stderr
    first, short = done.stdout.splitlines()
    assert first.startswith("path_tracer ") and "x1.000 ± 0.000" in first and short.startswith("short ")
    rows = csv_rows(file)
    passes = ("gbuffer", "paths", "accumulate")
    assert {(row["method"], row["round"], row["pass"]) for row in rows} == {
        (method, number, name) for method in ("path_tracer", "short") for number in "0123" for name in passes
    }
    assert all(float(row["gpu_ms"]) > 0 for row in rows)
    assert b"\r" not in file.read_bytes()


def test_each_method_is_made_equally_often_at_each_place(monkeypatch):
    made = []

    class Made:
        def __init__(self, method):
            made.append(method)
            self.frames = 0

        def render(self, frames):
            self.frames += frames

        def total_gpu_times(self):
            return {"paths": 10.0 * self.frames}

    monkeypatch.setattr(frame_costs, "settled", lambda method, scene, options: Made(method))
    options = frame_costs.parse([str(TRACER), "--scene", "room.glb", "--frames", "2"])
    for first in range(3):
        assert frame_costs.one_round("abc", first, None, options) == [{"paths": 10.0}] * 3
    assert made == [*"abc", *"bca", *"cab"]


def test_a_bounce_cap_of_none_is_a_cap():
    assert frame_costs.parse([str(TRACER), "--scene", "room.glb", "--bounces", "0"]).bounces == 0


@pytest.mark.parametrize(
    "setting, words",
    [
        ("paths.bouncs=2", "has no knob 'bouncs'"),
        ("bouncs=2", "no pass has a knob 'bouncs'; did you mean 'bounces'?"),
        ("device=NoSuchGPU", "NoSuchGPU"),
        ("backend=magic", "no back end 'magic'"),
        ("output=albedo", "'output' changes nothing here; leave it out"),
    ],
)
def test_a_wrong_setting_is_one_line(scene_file, setting, words):
    done = run(f"{TRACER}@{setting}", "--scene", scene_file)
    assert done.returncode == 2 and words in done.stderr and done.stderr.count("\n") == 1


def test_two_methods_of_one_label_are_refused(scene_file):
    done = run(TRACER, f"{TRACER}@bounces=2,label=path_tracer", "--scene", scene_file)
    assert done.returncode == 2 and "two methods are called 'path_tracer'" in done.stderr
    assert done.stderr.count("\n") == 1


def test_one_turn_is_refused(scene_file):
    done = run(TRACER, "--scene", scene_file, "--size", "16x9", "--turns", 1)
    assert done.returncode == 2 and "'1' is not a whole number of at least 2" in done.stderr


def test_a_table_that_cannot_be_written_is_told_before_a_frame_is_rendered(scene_file, tmp_path):
    (tmp_path / "file").touch()
    done = run(TRACER, "--scene", scene_file, "--csv", tmp_path / "file/times.csv")
    assert (done.returncode, done.stdout) == (2, "") and "choose another folder with --csv" in done.stderr
