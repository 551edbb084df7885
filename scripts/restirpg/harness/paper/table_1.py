"""Table 1: samples a cell of the guiding grid gets in a frame, from what ReSTIR selects and from raw
candidates."""

from restirpg.harness import cell_counts
from restirpg.harness.jobs import seed_of
from restirpg.harness.paper.page import Section, Table, estimate
from restirpg.harness.paper.paper import OURS, PLUS, name_of

METHODS = (OURS, PLUS)  # whose paths are counted

AVERAGES = ("own cells", "cells of either", "sample-weighted")
PAPER = (
    "The paper has 3055 / 164 in Veach Ajar, 3326 / 1372 in Veach Bidir Room, 2282 / 95 in Living Room, at 1920x1080."
)


def cell_call(paper, scene, method=OURS, **settings):
    """What is counted in a scene, for all seeds; `settings` as a `size` of its own."""
    return paper.call(
        cell_counts.measure,
        scene,
        method.graph,
        seeds=[seed_of("cells", number) for number in range(paper.size.seeds)],
        first=min(8, paper.size.frames),
        last=min(12, paper.size.frames),
        **settings,
    )


def row_of(scene, method, averages, cells):
    """How many cells ReSTIR and raw candidates touch; ReSTIR, raw and their ratio for each average; over seeds.
    averages: (seeds, frames, 2, 3); cells: (seeds, frames, 2)."""
    means = averages.mean(1)
    row = [scene, method, *map(estimate, cells.mean(1).T)]
    for at in range(len(AVERAGES)):
        restir, raw = means[:, 0, at], means[:, 1, at]
        row += [estimate(values) for values in (restir, raw, restir / raw)]
    return row


def run(paper):
    """Measure and tabulate."""
    rows = []
    counted = [(scene, method) for scene in paper.scenes() for method in METHODS]
    for (scene, method), answer in zip(counted, paper.answers([cell_call(paper, *each) for each in counted])):
        if answer:
            rows.append(row_of(name_of(scene), method.label, answer["averages"], answer["cells"]))
    header = ["scene", "method", "ReSTIR, cells", "raw, cells"]
    for average in AVERAGES:
        header += [f"ReSTIR, {average}", f"raw, {average}", f"ratio, {average}"]
    text = (
        "Bounces of paths that carry light, a frame and a cell; candidates are unguided, so that both see "
        "the same frames. The paper does not say what it averages over: given are the means over the cells "
        "that a method touched, over those that either did, and weighted by the samples (what a sample "
        f"sees). {PAPER}"
    )
    table = Table("table_1", "Table 1: samples per cell and frame", tuple(header), rows)
    return Section("Table 1: samples per cell", text, tables=[table])
