"""benchmarks/guide_sweep.py: a line a graph, and which passes it measures."""

import re
import subprocess
import sys
from types import SimpleNamespace

import guide_sweep
import pytest
from renderer_scenes import ROOT

import restirpg
from restirpg.harness.jobs import parse_method


def test_graphs_with_knobs_have_a_line_each(scene_file):
    graphs = [f"{ROOT}/graphs/restir_pt.py", f"{ROOT}/graphs/restir_pg.py@splat.cell_size=0.1"]
    numbers = "--size 16x9 --frames 2 --skip 1 --seeds 2 --reference-frames 4 --bounces 2".split()
    command = [sys.executable, ROOT / "benchmarks/guide_sweep.py", scene_file, *graphs, *numbers]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    reference, *lines = done.stdout.splitlines()
    assert reference.startswith("reference: ")
    assert [line.split(": ")[0] for line in lines] == ["restir_pt", "restir_pg splat.cell_size=0.1"]
    for line in lines:
        errors = re.findall(r"(\w+) ([\d.]+) \+- [\d.]+ \(", line)
        assert [name for name, _ in errors] == list(guide_sweep.COLUMNS) and all(
            float(value) > 0 for _, value in errors
        )


def sweep(*arguments):
    command = [sys.executable, ROOT / "benchmarks/guide_sweep.py", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


@pytest.mark.parametrize(
    "setting, words",
    [
        ("paths.bouncs=1", "has no knob 'bouncs'"),
        ("bouncs=1", "no pass has a knob 'bouncs'; did you mean 'bounces'?"),
        ("device=NoSuchGPU", "NoSuchGPU"),
        ("backend=magic", "no back end 'magic'"),
        ("output=albedo", "'output' changes nothing here"),
    ],
)
def test_a_wrong_setting_of_the_last_graph_is_told_before_the_reference_is_rendered(scene_file, setting, words):
    graph = ROOT / "graphs/restir_pt.py"
    done = sweep(scene_file, graph, f"{graph}@{setting}", "--size", "16x9")
    assert (done.returncode, done.stdout) == (2, "") and words in done.stderr and done.stderr.count("\n") == 1


def test_two_graphs_of_one_label_are_refused(scene_file):
    graph = ROOT / "graphs/restir_pt.py"
    done = sweep(scene_file, graph, f"{graph}@bounces=2,label=restir_pt")
    assert done.returncode == 2 and "two methods are called 'restir_pt'" in done.stderr


def test_candidates_have_no_reuse_whatever_is_set_on_every_pass(scene_file):
    method = parse_method(f"{ROOT}/graphs/restir_pt.py@rounds=2,temporal=true,bounces=2")
    arguments = SimpleNamespace(size=(16, 9), bounces=None)
    with guide_sweep.make_method(arguments, restirpg.load_scene(scene_file), method) as renderer:
        knobs = renderer.knobs()
    assert (knobs["reuse"]["rounds"], knobs["reuse"]["temporal"]) == (2, True)
    alone = knobs[guide_sweep.ALONE]
    assert (alone["rounds"], alone["temporal"]) == (0, False)


def test_one_seed_has_no_spread(scene_file):
    done = sweep(scene_file, ROOT / "graphs/restir_pt.py", "--seeds", 1)
    assert done.returncode == 2 and "'1' is not a whole number of at least 2" in done.stderr


def test_the_cap_is_the_scene_s_and_a_method_s_other_cap_is_told(scene_file, capsys):
    scene = restirpg.load_scene(scene_file)
    graph = ROOT / "graphs/restir_pt.py"
    methods = [parse_method(f"{graph}@bounces=2,label=short"), parse_method(str(graph))]
    arguments = SimpleNamespace(size=(16, 9), bounces=None)
    assert guide_sweep.bounce_cap(arguments, scene, methods[1:]) == scene.bounce_cap
    assert guide_sweep.bounce_cap(arguments, scene, methods) == scene.bounce_cap
    assert "short: its bounce cap is 2" in capsys.readouterr().err


def test_the_measured_reuse_is_the_one_that_is_shown_and_not_the_training_data_s():
    graph = guide_sweep.make_graph(ROOT / "graphs/guided_by_temporal.py")
    assert "temporal_reuse" in [entry["name"] for entry in graph["passes"]]
    [indirect] = [entry for entry in graph["outputs"] if entry["name"] == "indirect"]
    assert indirect["pass"] == "reuse"
