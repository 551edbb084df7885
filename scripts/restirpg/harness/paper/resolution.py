"""Error and samples per cell against resolution. Not in the paper, whose pictures are all 1920x1080.

Cells of the guiding grid span a part of the picture's height: with twice the height a cell
gets four times as many samples per frame.
"""

import numpy as np

from restirpg.harness import plots  # it chooses matplotlib's backend and style
from restirpg.harness.paper import errors, table_1
from restirpg.harness.paper.page import Picture, Section, Table, estimate
from restirpg.harness.paper.paper import OURS, RUPPERT, UNGUIDED, Study, method, name_of

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
        size: Study(COMPARED, scenes_of(paper), () if size == own else (("size", size),)) for size in sizes_of(paper)
    }


def counts_of(paper):
    """{(scene, size): [Estimate, Estimate]}: samples per cell of what ReSTIR selects, and of raw candidates.

    Each is the mean over the cells that it touches.
    """
    wanted = [(scene, size) for scene in scenes_of(paper) for size in sizes_of(paper)]
    answers = paper.answers([table_1.cell_call(paper, scene, size=size) for scene, size in wanted])
    found = {}
    for (scene, size), answer in zip(wanted, answers):
        if answer:
            own = answer["averages"].mean(1)[:, :, 0]
            found[name_of(scene), size] = [estimate(own[:, at]) for at in (0, 1)]
    return found


def drawing(changes, counts):
    """Left the change of MAPE against no guiding, right the samples per cell, against the picture's height.

    Both are {(scene, label): {height: Estimate}}.
    """
    figure = Figure(figsize=(11, 3.6))
    heights = sorted({height for series in (changes, counts) for points in series.values() for height in points})
    for axis, series, scale in zip(figure.subplots(1, 2), (changes, counts), (100, 1)):
        for (scene, label), points in series.items():
            values = [scale * value.mean for value in points.values()]
            bars = np.nan_to_num([scale * value.se for value in points.values()])
            line = f"{scene}, {label}"
            axis.errorbar(list(points), values, bars, marker="o", markersize=4, capsize=2, label=line)
        axis.set_xscale("log")
        axis.set_xticks(heights)
        axis.xaxis.set_major_formatter("{x:g}")
        axis.minorticks_off()
        axis.set_xlabel("height, pixels")
        axis.legend(fontsize=7.5)
    figure.axes[0].axhline(0, color="#888", linewidth=0.8)
    figure.axes[0].set_ylabel("change of MAPE, %")
    figure.axes[1].set_yscale("log")
    plots.log_axis(figure.axes[1].yaxis)
    figure.axes[1].set_ylabel("samples per cell and frame")
    return figure


def table_of(found, counts):
    """found: {(scene, size): what errors.compared() gives}; counts: {(scene, size): Estimates}."""
    rows, groups = [], []
    for (scene, size), (cells, tested) in found.items():
        groups += tested
        per_cell = counts.get((scene, size), ["", ""])
        rows += [[scene, f"{size[0]}x{size[1]}", label, *row, *per_cell] for label, row in cells.items()]
    return Table(
        "resolution",
        "Single frames by resolution, changes paired by seed",
        ("scene", "size", "method", *errors.heads(OURS.label), *(f"{kind}, samples per cell" for kind in COUNTS)),
        errors.filled(rows, groups),
    )


def by_height(estimates):
    """{(scene, size, label): Estimate} as drawing() wants it."""
    series = {}
    for (scene, size, label), value in estimates.items():
        series.setdefault((scene, label), {})[size[1]] = value
    return series


def run(paper):
    """Render each size, count, and tabulate."""
    counts = counts_of(paper)
    found = {
        (name_of(runs.scene), size): errors.compared(errors.by_seed(runs, "frame"), UNGUIDED.label, OURS.label)
        for size, study in studies(paper).items()
        for runs in paper.compare(study, f"resolution/{size[0]}x{size[1]}").runs
    }
    changes = {
        (*place, label): change
        for place, (cells, _) in found.items()
        for label, (_, change, *_) in cells.items()
        if label != UNGUIDED.label
    }
    samples = {(*place, kind): value for place, pair in counts.items() for kind, value in zip(COUNTS, pair)}
    text = (
        "Single frames, over the second half of each run. A cell spans the same part of the picture at every "
        "size, so that it gets the more samples the larger the picture is; samples are counted of unguided "
        "candidates, over the cells that each kind touches. The statistics of ReSTIR PG last a frame, as the "
        "paper's do, but where a cell has too few samples: those are kept until there are enough. The last "
        "method's decay."
    )
    picture = Picture(
        "resolution",
        "Change of MAPE against no guiding, and samples per cell and frame.",
        drawing(by_height(changes), by_height(samples)),
    )
    return Section("Resolution", text, [picture] if changes else [], [table_of(found, counts)])
