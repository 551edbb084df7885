"""What guiding costs: time of its passes, memory, rays; against the paper's figures. Runs are figure 5's."""

import numpy as np

from restirpg.harness import plots
from restirpg.harness import statistics as st
from restirpg.harness.paper.comparisons import study_5
from restirpg.harness.paper.page import Estimate, Picture, Section, Table, estimate, percent
from restirpg.harness.paper.paper import OURS, SHOWN, UNGUIDED, name_of
from restirpg.harness.paper.table_1 import cell_call

from matplotlib.figure import Figure  # isort: skip

PASSES = ("gbuffer", "direct", "guide", "paths", "reuse", "splat", "fit", "accumulate")
PAPER_SHARES = {"collect and splat": "25%", "fit": "25%", "guided sampling": "50%"}  # of the overhead, about


def pass_times(runs):
    """{label: {pass: (seeds,) ms per frame}}."""
    return {
        label: {name: np.array([run["meta"]["passes"].get(name, 0.0) for run in seeds]) for name in PASSES}
        for label, seeds in runs.runs.items()
    }


def overhead(times):
    """{part: (seeds,) ms} of what ReSTIR PG adds to a frame without guiding, paired by seed."""
    ours, without = times[OURS.label], times[UNGUIDED.label]
    return {
        "collect and splat": ours["reuse"] - without["reuse"] + ours["splat"],
        "fit": ours["fit"],
        "guided sampling": ours["paths"] - without["paths"],
    }


def times_table(results):
    """Milliseconds per frame of each pass."""
    rows = []
    for runs in results.runs:
        times = pass_times(runs)
        for label in (method.label for method in SHOWN if method.label in times):
            total = sum(times[label].values())
            parts = [estimate(times[label][name]) for name in PASSES]
            rows.append([name_of(runs.scene), label, estimate(total), *parts])
    header = ("scene", "method", "all passes", *PASSES)
    return Table("cost_passes", "GPU milliseconds per frame, by the device's timestamps", header, rows)


def shares_table(results):
    """The overhead and its parts; shares are ratios of means, for a seed's own overhead may be near 0 or
    negative."""
    rows = []
    for runs in results.runs:
        if not {OURS.label, UNGUIDED.label} <= set(runs.runs):
            continue
        parts = overhead(pass_times(runs))
        total = sum(parts.values())
        for part, values in parts.items():
            rows.append(
                [
                    name_of(runs.scene),
                    part,
                    estimate(values),
                    percent(*st.ratio(values, total)),
                    PAPER_SHARES[part],
                ]
            )
        frame = sum(pass_times(runs)[UNGUIDED.label].values())
        rows.append(
            [
                name_of(runs.scene),
                "all, of the frame without guiding",
                estimate(total),
                percent(*st.ratio(total, frame)),
                "",
            ]
        )
    header = ("scene", "part of the overhead", "ms/frame", "share", "paper, about")
    return Table("cost_shares", "What ReSTIR PG adds to ReSTIR PT", header, rows)


def memory_table(results):
    """Bytes per pixel of each method's resources, without the scene's."""
    rows = []
    for runs in results.runs[:1]:
        height, width = runs.reference["mean"].shape[:2]
        for label in (method.label for method in SHOWN if method.label in runs.runs):
            memory = runs.runs[label][0]["meta"]["memory"]
            fixed = {name: size for name, size in memory.items() if name.startswith(("fit.", "splat."))}
            own = {name: size for name, size in memory.items() if name not in fixed and not name.startswith("scene")}
            groups = {}
            for name, size in own.items():
                groups[name.split(".")[0]] = groups.get(name.split(".")[0], 0) + size
            cells = [f"{groups.get(name, 0) / (width * height):.0f}" for name in PASSES if name not in ("splat", "fit")]
            rows.append(
                [
                    label,
                    f"{sum(own.values()) / (width * height):.0f}",
                    *cells,
                    f"{sum(fixed.values()) / 2**20:.2f}",
                ]
            )
    header = ["method", "bytes per pixel", *(name for name in PASSES if name not in ("splat", "fit"))]
    header.append("tables of cells, MiB, whatever the size")
    return Table(
        "cost_memory",
        "Memory of ports, where what a later frame reads is there twice, and of what passes keep within a frame",
        tuple(header),
        rows,
    )


def guide_table(paper, results):
    """Sizes of valid cells beside the paper's."""
    scenes = [runs.scene for runs in results.runs]
    rows = []
    for scene, answer in zip(scenes, paper.answers([cell_call(paper, scene) for scene in scenes])):
        if not answer:
            continue
        cells = estimate(answer["guiding"].mean(1))
        size = answer["meta"]["bytes"]
        mib = (size["guide"] + size["statistics"]) / 2**20
        rows.append(
            [
                name_of(scene),
                cells,
                f"{size['guide']} + {size['statistics']}",
                Estimate(mib * cells.mean, mib * cells.se),
            ]
        )
    rows.append(["paper, Veach Ajar at 1920x1080", "34,000", "152", "5"])
    header = (
        "scene", "cells that guide", "bytes per cell: guide + a frame's statistics", "MiB of these cells",
    )  # fmt: skip
    return Table("cost_guide", "Memory of the guide", header, rows)


def drawing(results):
    """Stacked times of the passes, a bar a method."""
    figure = Figure(figsize=(15.4, 0.9 + 0.28 * sum(len(runs.runs) for runs in results.runs)))
    axes = figure.subplots()
    labels, place = [], 0.0
    ticks = []
    for runs in results.runs:
        times = pass_times(runs)
        for label in (method.label for method in SHOWN if method.label in times):
            left = 0.0
            for number, name in enumerate(PASSES):
                value = times[label][name].mean()
                axes.barh(
                    place, value, left=left, height=0.75, color=plots.COLOURS[number % len(plots.COLOURS)],
                    label=name if not labels else None,
                )  # fmt: skip
                left += value
            axes.text(left, place, f" {left:.3g}", va="center", fontsize=8)
            labels.append(f"{name_of(runs.scene)}, {label}")
            ticks.append(place)
            place += 1
        place += 0.5
    axes.set_yticks(ticks, labels)
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("GPU ms/frame")
    axes.legend(loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def run(paper):
    """Tables and a drawing."""
    results = paper.compare(study_5(paper))
    if not results.runs:
        return Section("Cost", "Nothing was finished: see what failed.")
    text = (
        "Times are the device's timestamps in figure 5's runs, one run at a time unless --jobs says "
        "otherwise; they mean nothing if other work shared the machine. Guided sampling is what the tracing "
        "of paths takes more than without a guide; to collect and splat is what reuse (0, but for noise) and "
        "splatting take. Bounces are read from the reservoirs; the paper keeps 52 B per vertex, 102.8 MiB per bounce "
        "at 1920x1080. Rays are not counted here: a frame of ReSTIR PT casts 15 to 31 a pixel, a path tracer's 7 "
        "to 15 (benchmarks/results/restir_pt_cost)."
    )
    listed = [times_table(results), shares_table(results), memory_table(results), guide_table(paper, results)]
    return Section("Cost", text, [Picture("cost", "GPU time of a frame by pass.", drawing(results))], listed)
