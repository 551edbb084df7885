"""scripts/compare.py while things move: each measured frame against the reference of that frame."""

import json
import os
import subprocess

import numpy as np
import pytest
from harness_runs import ROOT, SCRIPT, changed, compare, csv_rows, write_graph
from renderer_scenes import restirpg, write_flying_panel

from restirpg.harness import scenes
from restirpg.harness.motion import Motion

# The fake renderer's light grows by 1 a second: at 4 frames per second neighbours differ by 13% or more.
METHODS = ["plain.json@noise=0,label=quiet", "plain.json@label=noisy"]


def write_scene(folder, times=(0.0, 9.0), interpolation="LINEAR"):
    """A scene file of the fake renderer whose one animation has its keys at `times`; its name."""
    jump = interpolation == "STEP" and len(times) <= 2
    (folder / "moving.gltf").write_text(json.dumps([[times[0], times[-1], jump]]))
    return "moving.gltf"


def options_of(folder, **options):
    """Of a comparison whose reference, where none is given, has no noise."""
    rendered = {"reference_graph": write_graph(folder, "exact", noise=0), "reference_frames": 4, "reference_batches": 2}
    return {"scenes": "moving.gltf", "seeds": 3, **({} if "reference" in options else rendered), **options}


def frames(folder):
    """frames.csv: (method, frame) -> {column: value}."""
    return {
        (row["method"], int(row["frame"])): {
            name: float(row[name]) for name in row if "_" in name or name in ("mape", "relmse", "bias")
        }
        for row in csv_rows(folder / "out/frames.csv")
    }


def referred(folder):
    """The frames that references were rendered of."""
    labels = []
    for path in (folder / "out/cache").glob("*.npz"):
        with np.load(path) as file:
            labels.append(json.loads(str(file["meta"])).get("job", {}).get("label", ""))
    return sorted({int(label.split()[-1]) for label in labels if " of frame " in label})


def test_each_frame_is_measured_alone_and_against_its_own_reference(tmp_path):
    write_scene(tmp_path)
    run = compare(tmp_path, *METHODS, program=SCRIPT, **options_of(tmp_path, at="1,2,5", fps=4))
    assert run.returncode == 0, run.stderr
    rows = frames(tmp_path)
    assert sorted(rows) == [(method, frame) for method in ("noisy", "quiet") for frame in (1, 2, 5)]
    for frame in (1, 2, 5):
        assert rows["quiet", frame]["mape"] < 1e-5
        # One frame's noise, not that of the mean of five: it has the expected absolute value 2/e of its
        # exponential distribution less its mean, by all of 768 pixels.
        assert rows["noisy", frame]["mape"] == pytest.approx(2 / np.e, rel=0.1)
    assert "MAPE of single frames" in run.stdout and "higher (" in run.stdout


INJECTION = """
from restirpg.harness import plans
views = plans.views_of
plans.views_of = lambda *asked: {frame: view - 1 for frame, view in views(*asked).items()}
"""


def test_the_reference_of_the_frame_before_shows_as_an_error(tmp_path):
    write_scene(tmp_path)
    run = compare(tmp_path, *METHODS, program=changed(INJECTION), **options_of(tmp_path, at="2,5", fps=4))
    assert run.returncode == 0, run.stderr
    assert all(frames(tmp_path)["quiet", frame]["mape"] > 0.1 for frame in (2, 5))


def test_frames_that_show_the_same_share_a_reference(tmp_path):
    write_scene(tmp_path, (0.0, 1.0), "STEP")
    run = compare(tmp_path, METHODS[1], **options_of(tmp_path, at="1,4,5,6,12", fps=4))
    assert run.returncode == 0, run.stderr
    assert referred(tmp_path) == [1, 5]  # before the jump, and after it


def test_a_camera_on_a_circle_is_where_it_was_a_turn_ago(tmp_path):
    write_scene(tmp_path)
    run = compare(tmp_path, METHODS[0], **options_of(tmp_path, at="2,4,8", circle=0.5))
    assert run.returncode == 0, run.stderr
    assert referred(tmp_path) == [2, 4]
    assert all(row["mape"] < 1e-5 for row in frames(tmp_path).values())


def test_frames_of_a_still_scene_have_the_reference_of_its_mean(tmp_path):
    write_scene(tmp_path)
    run = compare(tmp_path, METHODS[0], **options_of(tmp_path, at="1,3"))
    assert run.returncode == 0, run.stderr
    assert referred(tmp_path) == []
    assert all(row["mape"] < 1e-5 for row in frames(tmp_path).values())


def test_what_is_wrong_with_the_reference_of_any_measured_frame_is_told(tmp_path):
    """Frames 1 and 4 share one, frame 5 has its own: two of two batches each."""
    write_scene(tmp_path, (0.0, 1.0), "STEP")
    options = {**options_of(tmp_path, at="1,4,5", fps=4), "reference_graph": write_graph(tmp_path, "holes", broken=3)}
    run = compare(tmp_path, METHODS[1], **options)
    assert run.returncode == 0, run.stderr
    assert "reference: 12 NaN or infinite pixels of its batches count as black" in run.stdout


@pytest.mark.parametrize(
    "times, interpolation, held",
    [
        ((1.0, 2.0), "LINEAR", {0.5: 0, 1.0: 0, 1.5: 1.5, 2.0: 2, 3.0: 2}),
        ((0.5, 2.0), "STEP", {0.5: 0, 1.5: 0, 2.0: 2, 3.0: 2}),
        ((0.0, 1.0, 2.0), "STEP", {1.5: 1.5}),  # what is between its keys is not looked up
    ],
)
def test_an_animation_stands_before_between_and_after_what_moves_it(tmp_path, times, interpolation, held):
    write_flying_panel(tmp_path / "panel.gltf", times, interpolation)
    facts = scenes.facts_of("", restirpg.load_scene(tmp_path / "panel.gltf"))
    assert {seconds: facts.held_since(seconds) for seconds in held} == held


@pytest.mark.parametrize(
    "options, words",
    [
        ({"fps": 4}, "say which, as in --at"),
        ({"at": "4,2"}, "no ascending list of frames"),
        ({"at": "32", "frames": 16}, "--at asks for frame 32, and --frames ends the runs after 16"),
        ({"at": "1,8", "frames": 100}, "--at ends the runs after frame 8, before --frames does; leave out --frames"),
        ({"fps": -1, "at": "2"}, "no positive number"),
        ({"fps": 4, "at": "1,2", "reference": "moving.reference.exr"}, "show different things"),
    ],
)
def test_a_mistake_is_one_line_and_exit_code_2(tmp_path, options, words):
    write_scene(tmp_path)
    run = compare(tmp_path, *METHODS, **options_of(tmp_path, **options))
    assert run.returncode == 2
    assert len([line for line in run.stderr.splitlines() if not line.startswith(("usage:", " "))]) == 1
    assert words in run.stderr


def test_a_scene_without_animation_is_played_under_a_warning(tmp_path):
    (tmp_path / "moving.gltf").touch()
    run = compare(tmp_path, METHODS[0], **options_of(tmp_path, at="1,2", fps=4))
    assert "no animation that --fps could play" in run.stdout


def test_the_renderer_shows_what_its_reference_shows(tmp_path):
    """A panel that flies out of the view, and nothing but its own emission: no noise, so no error at all."""
    write_flying_panel(tmp_path / "panel.gltf")
    graph = f"{ROOT}/graphs/path_tracer.py@gbuffer.jitter=false"
    command = [
        *SCRIPT,
        graph,
        "--scenes",
        "panel.gltf",
        "--size",
        "16x8",
        "--at",
        "1,2,3",
        "--fps",
        "16",
        "--circle",
        "0.3",
        "--seeds",
        "2",
        "--reference-frames",
        "2",
        "--reference-batches",
        "2",
        "--out",
        "out",
    ]
    environment = {**os.environ, "RESTIRPG_VALIDATION": "1"}
    run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    rows = frames(tmp_path)
    assert len(rows) == 3 and all(row["mape"] < 1e-5 for row in rows.values())
    assert Motion(0.3, 16).pose(2) == (0, 1 / 16)
