"""Table 1: samples a cell of the guiding grid gets in a frame, from what ReSTIR selects and from raw
candidates."""

import numpy as np

from harness import cell_counts
from harness import statistics as st
from harness.jobs import seed_of
from harness.paper.page import Estimate, Section, Table
from harness.paper.paper import OURS, name_of

AVERAGES = ("own cells", "cells of either", "sample-weighted")
PAPER = (
    "The paper has 3055 / 164 in Veach Ajar, 3326 / 1372 in Veach Bidir Room, 2282 / 95 in Living Room, at "
    "1920x1080."
)


def cell_calls(paper, scene):
    """One call a seed."""
    return [
        paper.call(
            cell_counts.measure,
            scene,
            OURS.graph,
            seed=seed_of("cells", number),
            first=min(8, paper.size.frames),
            last=min(12, paper.size.frames),
        )
        for number in range(paper.size.seeds)
    ]


def row_of(scene, answers):
    """ReSTIR, raw and their ratio for each average, over seeds. answers: arrays `averages` (frames, 2, 3)."""
    means = np.array([answer["averages"].mean(0) for answer in answers])  # seeds, (ReSTIR, raw), averages
    row = [scene]
    for at in range(len(AVERAGES)):
        restir, raw = means[:, 0, at], means[:, 1, at]
        row += [Estimate(*map(float, st.mean_se(values))) for values in (restir, raw, restir / raw)]
    return row


def run(paper):
    """Measure and tabulate."""
    rows = []
    for scene in paper.scenes():
        found = [answer for answer in paper.answers(cell_calls(paper, scene)) if answer]
        if found:
            rows.append(row_of(name_of(scene), found))
    header = ["scene"]
    for average in AVERAGES:
        header += [f"ReSTIR, {average}", f"raw, {average}", f"ratio, {average}"]
    text = (
        "Bounces of paths that carry light, a frame and a cell; candidates are unguided, so that both see "
        "the same frames. The paper does not say what it averages over: given are the means over the cells "
        "that a method touched, over those that either did, and weighted by the samples (what a sample "
        f"sees). {PAPER}"
    )
    table = Table("table_1", "Table 1: samples a cell and frame", tuple(header), rows)
    return Section("Table 1: samples a cell", text, tables=[table])
