"""Error and samples a cell against resolution. Not in the paper, whose pictures are all 1920x1080.

Cells of the guiding grid span a part of the picture's height (ALGORITHMS O10): with twice the height a cell
gets four times as many samples a frame.
"""

import numpy as np

from harness import plots  # noqa: F401  (chooses matplotlib's backend and style)
from harness import statistics as st
from harness.paper import errors, table_1
from harness.paper.page import Estimate, Picture, Section, Table, percent
from harness.paper.paper import OURS, RUPPERT, UNGUIDED, Study, method, name_of

from matplotlib.figure import Figure  # isort: skip

REMEMBERING = method("restir_pg_decay", "ReSTIR PG, decay 0.9")
COMPARED = (UNGUIDED, RUPPERT, OURS, REMEMBERING)
COUNTS = ("ReSTIR", "raw")


def scenes_of(paper):
    """The user's scenes, or the evaluation's first."""
    return paper.chosen or paper.size.scenes[:1]


def sizes_of(paper):
    """Width and height of each picture, ascending."""
    width, height = paper.size.size
    return [(max(8, round(width * factor)), max(8, round(height * factor))) for factor in paper.size.scales]


def studies(paper):
    """{size: Study}; at the evaluation's own size figure 5 has made most of the runs."""
    own = tuple(paper.size.size)
    return {
        size: Study(COMPARED, scenes_of(paper), () if size == own else (("size", size),))
        for size in sizes_of(paper)
    }


def counts_of(paper):
    """{(scene, size): [Estimate, Estimate]}: samples a cell of what ReSTIR selects, and of raw candidates.

    Each is the mean over the cells that it touches.
    """
    wanted = [(scene, size) for scene in scenes_of(paper) for size in sizes_of(paper)]
    answers = paper.answers([table_1.cell_call(paper, scene, size=size) for scene, size in wanted])
    found = {}
    for (scene, size), answer in zip(wanted, answers):
        if answer:
            own = answer["averages"].mean(1)[:, :, 0]
            found[name_of(scene), size] = [Estimate(*map(float, st.mean_se(own[:, at]))) for at in (0, 1)]
    return found


def drawing(changes, counts):
    """Left the change of MAPE against no guiding, right the samples a cell, against the picture's height.

    changes: {(scene, label): [(height, Estimate)]}; counts: {(scene, kind): [(height, Estimate)]}.
    """
    figure = Figure(figsize=(11, 3.6))
    for axis, series, scale in zip(figure.subplots(1, 2), (changes, counts), (100, 1)):
        for (scene, label), points in series.items():
            heights = [height for height, _ in points]
            values = [scale * value.mean for _, value in points]
            bars = np.nan_to_num([scale * value.se for _, value in points])
            axis.errorbar(
                heights, values, bars, marker="o", markersize=4, capsize=2, label=f"{scene}, {label}"
            )
        axis.set_xscale("log")
        axis.set_xticks(sorted({height for points in series.values() for height, _ in points}))
        axis.xaxis.set_major_formatter("{x:g}")
        axis.minorticks_off()
        axis.set_xlabel("height, pixels")
        axis.legend(fontsize=7.5)
    figure.axes[0].axhline(0, color="#888", linewidth=0.8)
    figure.axes[0].set_ylabel("change of MAPE, %")
    figure.axes[1].set_yscale("log")
    figure.axes[1].set_ylabel("samples a cell and frame")
    return figure


def rows_of(scene, size, values, per_cell):
    """Rows of a picture, a method each, and the groups to be tested, in the order of the Nones.

    values: {label: by seed}; per_cell: Estimates.
    """
    rows, groups = [], []
    for label in (one.label for one in COMPARED if one.label in values):
        row = [scene, f"{size[0]}x{size[1]}", label, percent(*st.mean_se(values[label]))]
        if label == UNGUIDED.label or UNGUIDED.label not in values:
            row += ["", "baseline" if label == UNGUIDED.label else "not tested"]
        else:
            row += [errors.change(values[label], values[UNGUIDED.label]), None]
            groups.append((values[label], values[UNGUIDED.label]))
        rows.append([*row, *per_cell])
    return rows, groups


def run(paper):
    """Render each size, count, and tabulate."""
    counts = counts_of(paper)
    rows, groups, changes, samples = [], [], {}, {}
    for size, study in studies(paper).items():
        for runs in paper.compare(study, f"resolution/{size[0]}x{size[1]}").runs:
            scene = name_of(runs.scene)
            per_cell = counts.get((scene, size), ["", ""])
            more_rows, more_groups = rows_of(scene, size, errors.by_seed(runs, "frame"), per_cell)
            rows, groups = rows + more_rows, groups + more_groups
            for row in more_rows:
                if row[4]:
                    changes.setdefault((scene, row[2]), []).append((size[1], row[4]))
            for kind, estimate in zip(COUNTS, per_cell):
                if estimate:
                    samples.setdefault((scene, kind), []).append((size[1], estimate))
    words = iter(errors.verdicts(groups))
    header = ["scene", "size", "method", "MAPE, one frame", "change, one frame", "tested, one frame"]
    table = Table(
        "resolution",
        "Single frames by resolution, changes paired by seed",
        (*header, *(f"{kind}, samples a cell" for kind in COUNTS)),
        [[next(words) if cell is None else cell for cell in row] for row in rows],
    )
    text = (
        "Single frames, over the second half of each run. A cell spans the same part of the picture at every "
        "size, so that it gets the more samples the larger the picture is; samples are counted of unguided "
        "candidates, over the cells that each kind touches. The statistics of ReSTIR PG last a frame, as the "
        "paper's do; those of the last method decay."
    )
    picture = Picture(
        "resolution",
        "Change of MAPE against no guiding, and samples a cell and frame.",
        drawing(changes, samples),
    )
    return Section("Resolution", text, [picture] if changes else [], [table])
