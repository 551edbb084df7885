"""Sections of the reproduced paper: tables and figures of made-up runs, whose errors differ by method."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from harness_runs import csv_rows

from restirpg.harness import pictures
from restirpg.harness.paper import (
    ablation,
    cost,
    errors,
    experiments,
    figure_4,
    motion,
    page,
    resolution,
    table_1,
)  # fmt: skip
from restirpg.harness.paper.comparisons import CANDIDATES
from restirpg.harness.paper.paper import METHODS, OURS, QUICK, SHOWN, UNGUIDED, Results

TRUTH = np.random.default_rng(7).uniform(0.1, 1, (18, 32, 3))


def made_up(**frame_mape):
    """A Results of one scene whose methods (by label) have these errors in every frame and two seeds."""
    runs, found = {}, []
    for label, mape in frame_mape.items():
        runs[label] = [
            {
                "frame_mape": np.full(4, mape * (1 + 0.1 * seed)),
                "mape": np.full(4, 10 * mape * (1 + 0.1 * seed)),
                "frame": TRUTH * (1 + mape * np.random.default_rng(seed).normal(size=TRUTH.shape)),
                "meta": {
                    "passes": {"paths": 100 * mape, "reuse": 10 * mape, "splat": 2 * mape, "fit": mape},
                    "memory": {"paths.candidates": 5760, "fit.guide": 1 << 20, "scene": 99},
                },
            }
            for seed in range(2)
        ]
        found.append(
            SimpleNamespace(
                label=label,
                gpu_ms=np.full((2, 4), 4e3 * mape),
                frames=np.arange(1, 5),
                equal_time={"mape": (100 * mape, mape)},
            )  # fmt: skip
        )
    truth = {"mean": TRUTH.astype(np.float32)}
    scene = SimpleNamespace(scene="made_up.glb", runs=runs, at=(1, 2, 3, 4), reference=truth)
    return Results([scene], [SimpleNamespace(methods=found)])


KNOWN = {method.label: 0.1 * number for number, method in enumerate(METHODS, 1)}


class MadeUpPaper:
    """A paper.Paper whose studies have the errors of `made_up`, 1%, 2% ... in the order of their methods."""

    size, chosen, failures = QUICK, (), []

    def scenes(self, *own):
        return own or self.size.scenes

    def compare(self, study, folder=None):
        return made_up(**{method.label: 0.01 * number for number, method in enumerate(study.methods, 1)})

    def call(self, function, scene, graph, **settings):
        return None

    def answers(self, calls):
        bytes_of = {"bytes": {"guide": 160, "statistics": 152}}
        made_up = {"averages": np.ones((2, 5, 2, 3)), "cells": np.ones((2, 5, 2)), "guiding": np.ones((2, 5))}
        return [{**made_up, "meta": bytes_of} for _ in calls]


@pytest.mark.parametrize("name", [name for name in experiments.BY_NAME if name != "figure 4"])
def test_a_section_is_drawn_and_its_tables_are_written(name, tmp_path):
    section = experiments.BY_NAME[name].run(MadeUpPaper())
    assert section.pictures or section.tables
    for picture in section.pictures:
        assert picture.png().startswith(b"\x89PNG")
    for table in section.tables:
        table.write_csv(tmp_path)
        assert len(csv_rows(tmp_path / f"{table.name}.csv")) == len(table.rows) > 0


def test_the_report_says_how_many_frames_each_kind_of_reference_has(tmp_path):
    page.write([], SimpleNamespace(size=QUICK, code="", devices={}, failures=[]), tmp_path / "r.html", "reproduce.py")
    told = "2048 frames of path_tracer.py in 16 batches; of each frame of figure 7 and motion 512"
    assert told in (tmp_path / "r.html").read_text()


class LackingPaper(MadeUpPaper):
    """One in whose studies every run of the last method, ReSTIR PG in most, failed."""

    def compare(self, study, folder=None):
        return super().compare(replace(study, methods=study.methods[:-1]), folder)


@pytest.mark.parametrize("name", [name for name in experiments.BY_NAME if name != "figure 4"])
def test_a_method_that_failed_everywhere_leaves_a_section_of_the_others(name):
    section = experiments.BY_NAME[name].run(LackingPaper())
    assert all(picture.png() for picture in section.pictures)
    assert all(len(row) == len(table.header) for table in section.tables for row in table.rows)


def test_figure_4_scores_each_kind_by_its_own_histograms():
    product = np.full((1, 8, 32), 1 / 256)
    right = {
        "frames": np.array([1, 2]), "counts": np.full((2, 1, 2), 500.0), "effective": np.full((2, 1, 2), 500.0),
        "histograms": np.broadcast_to(product[0], (2, 1, 2, 8, 32)),
    }  # fmt: skip
    wrong = {**right, "histograms": np.zeros((2, 1, 2, 8, 32))}
    wrong["histograms"][..., 0, 0] = 1
    for row in figure_4.rows_of("scene", product, [right, wrong]):
        assert row[4].mean == pytest.approx(0, abs=1e-9) and row[7].mean == pytest.approx(np.log(256))
        assert row[4].mean < row[5].mean < row[7].mean


def test_each_method_has_its_own_errors():
    table = errors.table("t", "t", made_up(**KNOWN), SHOWN)
    rows = [dict(zip(table.header, row)) for row in table.rows]
    assert [row["method"] for row in rows] == [method.label for method in SHOWN]
    for row in rows:
        own = KNOWN[row["method"]]
        assert row["MAPE, single frames"].mean == pytest.approx(1.05 * own)
        assert row["MAPE, mean of all frames"].mean == pytest.approx(10.5 * own)
        assert row["MAPE at equal time"].mean == pytest.approx(100 * own)
        assert row["GPU ms/frame"].mean == pytest.approx(1e3 * own)
        if row["method"] != OURS.label:
            to_ours = row[f"change from it to {OURS.label}"].mean
            assert to_ours == pytest.approx(KNOWN[OURS.label] / own - 1)
        between = row["method"] not in (OURS.label, UNGUIDED.label)
        assert ("p = " in row[f"tested, to {OURS.label}"]) == between
        if row["method"] != UNGUIDED.label:
            assert row["change, single frames"].mean == pytest.approx(own / KNOWN[UNGUIDED.label] - 1)


def test_candidates_unguided_are_what_guided_ones_are_compared_with():
    table = errors.table("t", "t", made_up(**{CANDIDATES[0].label: 0.4, CANDIDATES[1].label: 0.3}), CANDIDATES)
    change = {row[1]: row[3] for row in table.rows}
    assert change[CANDIDATES[0].label] == "" and change[CANDIDATES[1].label].mean == pytest.approx(-0.25)


def in_frames(*errors):
    """A SceneRuns whose four frames have so many times the KNOWN errors, whatever the seed."""
    scene = made_up(**KNOWN).runs[0]
    for label, seeds in scene.runs.items():
        for run in seeds:
            run["mape"] = KNOWN[label] * np.array(errors, float)
    return scene


def test_frames_of_a_sequence_stand_under_their_methods():
    table = motion.table("t", "t", [("light", in_frames(1, 2, 3, 4))])
    for frame, row in enumerate(table.rows, 1):
        cells = dict(zip(table.header, row))
        assert cells["frame"] == f"{frame}"
        for method in METHODS:
            assert cells[method.label].mean == pytest.approx(frame * KNOWN[method.label])


def test_means_of_a_sequence_leave_its_first_frame_out():
    table = motion.means_table("t", "t", [("light", in_frames(9, 2, 3, 4))])
    rows = [dict(zip(table.header, row)) for row in table.rows]
    assert [row["method"] for row in rows] == [method.label for method in SHOWN]
    for row in rows:
        own = KNOWN[row["method"]]
        assert row["MAPE, mean of single frames"].mean == pytest.approx(3 * own)
        if row["method"] != OURS.label:
            to_ours = row[f"change from it to {OURS.label}"].mean
            assert to_ours == pytest.approx(KNOWN[OURS.label] / own - 1)


def test_a_run_of_one_frame_has_no_recovery():
    class BriefPaper(MadeUpPaper):
        def compare(self, study, folder=None):
            results = super().compare(study, folder)
            for scene in results.runs:
                scene.at = (1,)
                for run in (run for seeds in scene.runs.values() for run in seeds):
                    run["mape"] = run["mape"][:1]
            return results

    whole, brief = (motion.figure_7(paper()).tables for paper in (MadeUpPaper, BriefPaper))
    assert [table.name for table in brief] == ["figure_7_means", "figure_7"]
    assert [table.name for table in whole] == ["figure_7_means", "figure_7", "figure_7_recovery"]


def test_recovery_counts_frames_from_the_jump():
    """Measured are the frame before, the jump, and three more; 1.1 times the last error is 0.11."""
    values = np.array([[0.05, 0.5, 0.3, 0.105, 0.1], [0.05, 0.5, 0.12, 0.12, 0.1], [0.05, 0.1, 0.4, 0.2, 0.1]])
    assert list(motion.frames_to_recover(values)) == [3, 4, 1]


def test_overhead_is_splat_fit_and_what_reuse_and_tracing_take_more():
    parts = cost.overhead(cost.pass_times(made_up(**KNOWN).runs[0]))
    own, without = KNOWN[OURS.label], KNOWN[UNGUIDED.label]
    assert {name: values.mean() for name, values in parts.items()} == pytest.approx(
        {
            "collect and splat": 10 * (own - without) + 2 * own,
            "fit": own,
            "guided sampling": 100 * (own - without),
        }
    )
    rows = cost.shares_table(made_up(**KNOWN)).rows
    assert sum(row[3].mean for row in rows[:3]) == pytest.approx(1)


def test_memory_of_cells_is_their_number_times_their_bytes():
    """MadeUpPaper's cells: one that guides, of 160 and 152 bytes."""
    table = cost.guide_table(MadeUpPaper(), made_up(**KNOWN))
    row = dict(zip(table.header, table.rows[0]))
    assert row["cells that guide"].mean == 1 and row["MiB of these cells"].mean == pytest.approx(312 / 2**20)


def test_table_1_keeps_restir_and_raw_apart():
    averages = np.array([[[[6.0, 5, 4], [3, 2, 1]]]] * 2)
    cells = np.array([[[40, 30]], [[44, 32]]])
    row = table_1.row_of("scene", "method", averages, cells)
    assert [cell.mean for cell in row[2:]] == [42, 31, 6, 3, 2, 5, 2, 2.5, 4, 1, 4]


def test_variants_of_an_ablation_have_their_own_rows():
    labels = [ablation.DEFAULT, "without guiding"]
    labels += [f"{title}: {name}" for title, (_, variants) in ablation.FAMILIES.items() for name, _, _ in variants]
    values = {label: np.array([1.0, 1.1]) * number for number, label in enumerate(labels, 1)}
    rows, groups = ablation.rows_of_scene("s", {"shown": values})
    assert len(rows) == len(labels) and len(groups) == len(labels) - 1
    for number, (row, label) in enumerate(zip(rows, labels), 1):
        assert row[3].mean == pytest.approx(1.05 * number)
        assert label in (ablation.DEFAULT, "without guiding") or label == f"{row[1]}: {row[2]}"
        assert number == 1 or row[4].mean == pytest.approx(number - 1)


def test_a_resolution_s_pictures_are_halves_and_doubles_and_its_own_runs_are_figure_5_s():
    found = resolution.studies(MadeUpPaper())
    assert list(found) == [(48, 27), (96, 54), (192, 108)]
    assert found[96, 54].changes == () and found[48, 27].changes == (("size", (48, 27)),)


def test_a_resolution_s_rows_are_tested_against_no_guiding():
    values = {one.label: np.array([1.0, 1.1]) * number for number, one in enumerate(resolution.COMPARED, 1)}
    per_cell = [page.Estimate(7), page.Estimate(2)]
    found = {("s", (48, 27)): errors.compared(values, UNGUIDED.label, OURS.label)}
    rows = resolution.table_of(found, {("s", (48, 27)): per_cell}).rows
    assert [row[2] for row in rows] == list(values) and rows[0][4:6] == ["", "baseline"]
    ours = list(values).index(OURS.label) + 1
    for number, row in enumerate(rows, 1):
        assert row[1] == "48x27" and row[3].mean == pytest.approx(1.05 * number) and row[-2:] == per_cell
        assert number == 1 or (row[4].mean == pytest.approx(number - 1) and "p = " in row[5])
        assert number == ours or row[6].mean == pytest.approx(ours / number - 1)


def test_crops_are_where_methods_differ_most():
    maps = np.full((3, 36, 64), 0.5)
    maps[1, 20:26, 40:46] = 3.0
    maps[2, 4:8, 10:14] = 2.0
    maps[:, 28:36, 0:16] = 9.0  # large, but the same for all
    corners, side = pictures.crops_of(maps)
    for (x, y), (wanted_x, wanted_y) in zip(corners, ((43, 23), (12, 6))):
        assert x <= wanted_x < x + side and y <= wanted_y < y + side


def test_a_csv_has_means_and_errors_unscaled(tmp_path):
    rows = [["a", page.percent(0.25, 0.01)], ["b", "failed"]]
    page.Table("numbers", "", ("what", "error"), rows).write_csv(tmp_path)
    assert (tmp_path / "numbers.csv").read_text() == "what,error,error (se)\na,0.25,0.01\nb,failed,\n"
    assert str(page.percent(0.25, 0.01)) == "25.0 ± 1.0%"
