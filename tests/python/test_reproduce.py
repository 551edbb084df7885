"""scripts/reproduce.py: each experiment small from end to end, and mistakes.

The small evaluation is 16x9, 2 frames, 2 seeds of the Cornell box: that its files are there and belong
together is tested, not its numbers. Those are tested in test_reproduced_sections.
"""

import json
import shutil
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from harness_runs import csv_rows
from renderer_scenes import ROOT, write_flying_panel, write_outside
from webdriver import Browser

import restirpg
from restirpg.harness import UserError, guide_maps, see_guide
from restirpg.harness import reproduce as program
from restirpg.harness.paper import (
    ablation,
    experiments,
    figure_4,
)  # fmt: skip
from restirpg.harness.paper.paper import METHODS, QUICK, Paper, Study
from restirpg.harness.render import describe_graph, load_scene
from restirpg.harness.scenes import facts
from restirpg.harness.workers import Pool

SMALL = "--quick --size 16x9 --frames 2 --seeds 2 --reference-frames 16".split()


def reproduce(folder, *arguments):
    """Run it to its end; a CompletedProcess with text output."""
    command = [sys.executable, ROOT / "scripts" / "reproduce.py", *arguments, "--out", folder / "out"]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True)


#: One variant of a knob, and of other graphs: to make a renderer for each is what takes the time.
FEW = {
    "alpha: share of BSDF sampling": ("0.5", [("0.2", "", {"paths__alpha": 0.2})]),
    "training data": ("ReSTIR", [("temporal only", "_by_temporal", {})]),
}


@pytest.fixture(scope="module")
def few_variants():
    """An ablation that is soon done."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ablation, "FAMILIES", FEW)
        yield


@pytest.fixture(scope="module")
def everything(tmp_path_factory, few_variants):
    """`all` of a small evaluation: its folder."""
    folder = tmp_path_factory.mktemp("reproduce") / "out"
    assert program.main(["all", "--scenes", "cornell_box", *SMALL, "--out", str(folder)]) == 0
    return folder


def finished(folder):
    """The cache's files with the times they were written."""
    return {path.name: path.stat().st_mtime_ns for path in (folder / "cache").glob("*.npz")}


def test_every_experiment_leaves_its_figure_and_its_numbers(everything):
    text = (everything / "report.html").read_text()
    titles = [f"Figure {number}" for number in (1, 2, 4, 5, 6, 7, 8)]
    for title in [*titles, "Table 1", "Cost", "Motion", "Ablations", "Resolution"]:
        assert f"<h2>{title}" in text
    names = [f"figure_{number}" for number in (1, 2, 4, 5, 6, 7, 8)]
    for name in [*names, "figure_7_errors", "cost", "motion", "motion_errors", "ablation", "resolution"]:
        assert (everything / f"{name}.png").stat().st_size > 10_000
        assert f'id="{name}"' in text
    for method in METHODS:
        assert (everything / "figure_5" / f"cornell_box.{method.label.replace(' ', '_')}.exr").is_file()
    assert text.count("scenes of its study, a family of its own (Holm)") == 6  # figures 5 to 8, and two sequences
    assert "http:" not in text.replace("http://www.w3.org", "") and "https:" not in text


def test_the_report_opens_and_its_folded_viewers_draw(everything):
    if not shutil.which("chromedriver"):
        pytest.skip("chromedriver is not installed: no browser has opened the report")
    with Browser() as browser:
        browser.open(everything / "report.html")
        loaded = "return Array.from(document.querySelectorAll('figure img')).every(i => i.naturalWidth > 0)"
        assert browser.run(loaded)
        assert browser.run("return viewers.length") == 6  # figures 5 to 8, and two sequences
        browser.run("document.querySelectorAll('details').forEach(details => { details.open = true; })")
        for _ in range(50):
            if browser.run("return viewers.every(viewer => viewer.panes[0].canvas.width > 100)"):
                break
            time.sleep(0.1)
        else:
            raise AssertionError("a viewer stays empty")
        assert browser.log() == []


def test_a_table_has_the_numbers_of_the_runs_beside_it(everything):
    """figure_5.csv against runs.csv, which the harness writes by seed and frame."""
    runs = csv_rows(everything / "figure_5" / "runs.csv")
    for row in csv_rows(everything / "figure_5.csv"):
        last = [float(run["mape"]) for run in runs if run["method"] == row["method"] and run["frame"] == "2"]
        assert float(row["MAPE, mean of all frames"]) == pytest.approx(np.mean(last), rel=1e-6)
        assert float(row["MAPE, mean of all frames (se)"]) == pytest.approx(np.std(last, ddof=1) / 2**0.5, rel=1e-6)
    assert {row["method"] for row in csv_rows(everything / "figure_5.csv")} == {method.label for method in METHODS}


def test_figures_share_runs_and_a_second_start_renders_nothing(everything):
    before = finished(everything)
    wanted = ["figure", "1", "5", "cost"]
    assert program.main([*wanted, "--scenes", "cornell_box", *SMALL, "--out", str(everything)]) == 0
    assert finished(everything) == before
    assert "Figure 6" not in (everything / "report.html").read_text()


def test_there_are_as_many_jobs_as_the_list_says(everything):
    """The cache holds besides them a combined reference of each view, and a probe a method and reference."""
    size = replace(QUICK, size=(16, 9), frames=2, seeds=2, reference_frames=16, scenes=("cornell_box",))
    paper = SimpleNamespace(size=size, chosen=("cornell_box",), scenes=lambda *own: ("cornell_box",))
    jobs, _ = experiments.jobs_and_minutes(paper, experiments.EXPERIMENTS)
    studies = {study for experiment in experiments.EXPERIMENTS for study in experiment.studies(paper)}
    references = {study.changes: study.views for study in studies}
    jobs -= size.reference_batches * sum(views - 1 for views in references.values())  # nothing moves in the box
    probes = {(method.graph, method.knobs, study.changes) for study in studies for method in study.methods}
    assert len(finished(everything)) == jobs + len(references) + len(probes) + len(references)


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["figure", "3"], "there is no 'figure 3'; there are: figure 1, figure 2"),
        (["tables"], "there is no 'tables'"),
        ([], "say what to reproduce, as in"),
        (["figure"], "say which figure; there are: figure 1, figure 2"),
        (["figure", "5", "table"], "say which table"),
        (["figure", "5", "--scenes", "absent"], "absent: neither a file nor an embedded scene"),
        (["figure", "5", "--scenes", "README.md"], "README.md"),
        (["figure", "5", "--size", "12"], "'12' is not WIDTHxHEIGHT"),
        (["figure", "5", "--quick", "--full"], "not allowed with"),
        (
            ["figure", "5", "--cache", "README.md"],
            "README.md: cannot be written to: not a folder; choose another folder with --cache",
        ),
    ],
)
def test_a_mistake_is_one_line_and_exit_code_2(tmp_path, arguments, words):
    run = reproduce(tmp_path, *arguments)
    assert run.returncode == 2
    lines = [line for line in run.stderr.splitlines() if not line.startswith(("usage:", " ", "figure "))]
    assert len(lines) == 1 and words in lines[0], run.stderr


@pytest.mark.parametrize("arguments, cap", [([], 12), (["--bounces", "2"], 2), (["--bounces", "0"], 0)])
def test_a_bounce_cap_takes_the_place_of_the_scene_s(tmp_path, arguments, cap):
    options = program.parse(["figure", "5", "--scenes", "cornell_glass", *arguments])
    with Pool(tmp_path, 1) as pool:
        evaluation = Paper(program.size_from(options), tmp_path, None, pool, None, options.scenes)
        settings = evaluation.settings(Study(METHODS, evaluation.scenes()))
        [scene] = settings.scenes
        assert facts(pool, scene).bounces(settings.bounces) == cap
        call = evaluation.call(figure_4.directions, "cornell_glass", "graphs/restir_pg.py")
        assert dict(call.settings)["bounces"] == cap


def test_scenes_read_outside_of_their_folders_only_where_that_is_allowed(tmp_path):
    outside = write_outside(write_flying_panel(tmp_path / "panel.gltf"))
    refused = reproduce(tmp_path, "figure", "5", *SMALL, "--scenes", outside)
    assert refused.returncode == 2 and "lies outside of the scene's folder" in refused.stderr, refused.stderr
    options = program.parse(["figure", "5", "--allow-outside", "--scenes", str(outside)])
    with Pool(tmp_path, 1) as pool:
        evaluation = program.evaluation_of(options, None, pool, None)
        assert evaluation.settings(Study(METHODS, evaluation.scenes())).allow_outside
        call = evaluation.call(figure_4.directions, str(outside), "graphs/restir_pg.py")  # asks a worker for its facts
    assert load_scene(call)[1].triangles == 2


def test_the_guide_is_seen_in_a_scene_that_reads_outside_of_its_folder_where_that_is_allowed(tmp_path):
    outside = write_outside(write_flying_panel(tmp_path / "panel.gltf"))
    (tmp_path / "none.py").write_text("graph = 0\n")  # a graph is read after the scene; rendering would take seconds
    command = [
        sys.executable,
        ROOT / "scripts" / "see_guide.py",
        "--scene",
        outside,
        "--pixel",
        "0",
        "0",
        "--graph",
        tmp_path / "none.py",
        "-o",
        tmp_path / "guide.png",
    ]
    for arguments, words in (([], "lies outside of the scene's folder"), (["--allow-outside"], "none.py")):
        run = subprocess.run([*command, *arguments], capture_output=True, text=True)
        assert run.returncode == 2 and len(run.stderr.splitlines()) == 1 and words in run.stderr, run.stderr


def test_the_product_at_a_point_has_the_bounces_of_the_paths_that_taught_the_guide(tmp_path, monkeypatch):
    scene, graph = write_flying_panel(tmp_path / "panel.gltf"), tmp_path / "graph.json"
    description = describe_graph(ROOT / "graphs/restir_pg.py")
    [paths] = [entry for entry in description["passes"] if entry["name"] == "paths"]
    paths["knobs"]["bounces"] = 3
    graph.write_text(json.dumps(description))
    seen = []

    def products(points, scene, bounces):
        seen.append(bounces)
        raise UserError("seen")

    honest = guide_maps.products_at
    monkeypatch.setattr(guide_maps.Learner, "run", lambda *_: ([], [], []))
    monkeypatch.setattr(guide_maps, "products_at", products)
    names = ["--scene", scene, "--graph", graph, "--pixel", 0, 0, "-o", tmp_path / "guide.png"]
    assert see_guide.main([*map(str, names)]) == 2
    with pytest.raises(UserError):
        figure_4.products(restirpg.load_scene(scene), json.dumps(description), (16, 9), 0, [])
    assert seen == [3, 0]
    assert not np.any(honest([None], None, 0))


def test_an_embedded_scene_is_not_written_over_one_that_is_named(tmp_path):
    names = ["door_ajar", str(tmp_path / "scenes/door_ajar.glb")]
    with pytest.raises(UserError, match="the embedded 'door_ajar' would be written over it"):
        Paper(QUICK, tmp_path, None, None, None, names).file("door_ajar")
    assert not list(tmp_path.iterdir())


def test_the_list_names_everything(tmp_path):
    run = reproduce(tmp_path, "--list", "--quick")
    assert run.returncode == 0 and not list(Path(tmp_path).rglob("*.npz"))
    for name in [*experiments.BY_NAME, "all"]:
        assert name in run.stdout
