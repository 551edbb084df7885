"""benchmarks/frame_costs.py: a row a method, its times in a file, and mistakes in a line."""

import csv
import subprocess
import sys

import frame_costs
from renderer_scenes import ROOT, scene_file  # noqa: F401

TRACER = ROOT / "graphs/path_tracer.py"


def run(*arguments):
    return subprocess.run(
        [sys.executable, ROOT / "benchmarks/frame_costs.py", *map(str, arguments)], capture_output=True, text=True
    )


def test_methods_render_in_turn_and_every_pass_is_written(scene_file, tmp_path):
    file = tmp_path / "times.csv"
    done = run(
        TRACER, f"{TRACER}@bounces=1,label=short", "--scene", scene_file, "--size", "16x9", "--rounds", 2, "--csv", file
    )
    assert done.returncode == 0, done.stderr
    first, short = done.stdout.splitlines()
    assert first.startswith("path_tracer ") and "x1.000 ± 0.000" in first and short.startswith("short ")
    with open(file, newline="") as stream:
        rows = list(csv.DictReader(stream))
    passes = ("gbuffer", "paths", "accumulate")
    assert {(row["method"], row["round"], row["pass"]) for row in rows} == {
        (method, number, name) for method in ("path_tracer", "short") for number in "01" for name in passes
    }
    assert all(float(row["gpu_ms"]) > 0 for row in rows)


def test_a_bounce_cap_of_none_is_a_cap():
    assert frame_costs.parse([str(TRACER), "--scene", "room.glb", "--bounces", "0"]).bounces == 0


def test_a_knob_that_is_not_there_is_one_line(scene_file):
    done = run(f"{TRACER}@paths.bouncs=2", "--scene", scene_file)
    assert done.returncode == 2 and "has no knob 'bouncs'" in done.stderr and done.stderr.count("\n") == 1
