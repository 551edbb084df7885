"""benchmarks/builds.py: two builds in turn, and mistakes in a line before anything is measured."""

import csv
import subprocess
import sys

import builds
import pytest
from renderer_scenes import ROOT

from restirpg.harness.render import native_file

BUILD = native_file().parents[2]
GRAPH = ROOT / "graphs/path_tracer.py"


def run(*arguments):
    command = [sys.executable, ROOT / "benchmarks/builds.py", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


def test_a_build_is_as_fast_as_itself_and_every_row_is_written(scene_file, tmp_path):
    table = tmp_path / "rows.csv"
    options = ["--graphs", GRAPH, "--scenes", scene_file, "--size", "16x9", "--frames", 1, "--pairs", 2, "--csv", table]
    done = run(BUILD, BUILD, *options)
    assert done.returncode == 0, done.stderr
    assert "nan" not in done.stdout
    with open(table, newline="") as stream:
        rows = {row["row"]: row for row in csv.DictReader(stream)}
    assert {"start, wall", "second, wall", "frame, CPU", "paths, device"} <= rows.keys()
    assert all(float(row["ratio"]) > 0 and float(row["spread"]) >= 1 for row in rows.values())


@pytest.mark.parametrize(
    "change, words",
    [
        ({"new": "absent"}, "absent: no build folder of restirpg"),
        ({"--graphs": "absent.py"}, "absent.py: no such graph"),
        ({"--scenes": "absent.glb"}, "absent.glb: no such scene"),
        ({"--csv": f"{GRAPH}/rows.csv"}, "choose another folder with --csv"),
        ({"--csv": str(GRAPH)}, "it would be written over"),
    ],
)
def test_a_mistake_is_one_line_before_anything_is_measured(scene_file, change, words):
    options = {"--graphs": GRAPH, "--scenes": scene_file, **change}
    new = options.pop("new", BUILD)
    done = run(BUILD, new, *(word for option in options.items() for word in option))
    assert (done.returncode, done.stdout) == (2, "") and words in done.stderr, done.stderr
    assert done.stderr.count("\n") == 1


def test_a_graph_that_a_build_refuses_is_one_line_that_names_the_build(scene_file, tmp_path):
    graph = tmp_path / "wrong.py"
    graph.write_text("from restirpg import Graph\ngraph = Graph('G')\ngraph.add('a', 'Nope')\n")
    done = run(BUILD, BUILD, "--graphs", graph, "--scenes", scene_file)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert done.stderr.startswith(f"builds.py: {BUILD}: ") and "no pass type 'Nope'" in done.stderr
    assert "WrongValueError" not in done.stderr and done.stderr.count("\n") == 1


def test_one_pair_has_no_spread():
    done = run(BUILD, BUILD, "--pairs", 1)
    assert done.returncode == 2 and "'1' is not a whole number of at least 2" in done.stderr


def test_ratios_are_geometric_means():
    [row] = builds.compare([({"frame": 2.0}, {"frame": 1.0}), ({"frame": 8.0}, {"frame": 1.0})])
    assert row[:3] == ("frame", 5.0, 1.0) and abs(row[3] - 4) < 1e-9 and abs(row[4] - 2) < 1e-9
