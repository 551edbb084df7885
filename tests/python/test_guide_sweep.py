"""benchmarks/guide_sweep.py: a line a graph, and which passes it measures."""

import re
import subprocess
import sys

import guide_sweep
from renderer_scenes import ROOT, scene_file  # noqa: F401


def test_graphs_with_knobs_have_a_line_each(scene_file):
    graphs = [f"{ROOT}/graphs/restir_pt.py", f"{ROOT}/graphs/restir_pg.py@splat.cell_size=0.1"]
    numbers = "--size 16x9 --frames 2 --skip 1 --seeds 2 --reference-frames 4 --bounces 2".split()
    command = [sys.executable, ROOT / "benchmarks/guide_sweep.py", scene_file, *graphs, *numbers]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    reference, *lines = done.stdout.splitlines()
    assert reference.startswith("reference: ") and [line.split(": ")[0] for line in lines] == graphs
    for line in lines:
        errors = re.findall(r"(\w+) ([\d.]+) \+- [\d.]+ \(", line)
        assert [name for name, _ in errors] == list(guide_sweep.COLUMNS) and all(
            float(value) > 0 for _, value in errors
        )


def test_the_measured_reuse_is_the_one_that_is_shown_and_not_the_guide_s_teacher():
    graph = guide_sweep.make_graph(ROOT / "graphs/guided_by_temporal.py")
    assert "teacher" in [entry["name"] for entry in graph["passes"]]
    [indirect] = [entry for entry in graph["outputs"] if entry["name"] == "indirect"]
    assert indirect["pass"] == "reuse"
