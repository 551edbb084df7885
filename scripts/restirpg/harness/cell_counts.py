"""How many samples a cell of the guiding grid gets in a frame, from the paths that ReSTIR PT selected and
from its raw candidates.

A sample is a smooth bounce of a path that carries light. Candidates are unguided here (alpha = 1), so that
both see the same frames. [Zeng et al. 2025, table 1]
"""

import json

import numpy as np

import restirpg
from restirpg.harness.guiding import CELL, MEMORY, SUMS, GuidedGraph, header_of, read_table
from restirpg.records import constant

KEY_BYTES = constant("GUIDING_KEY_BYTES")
RAW = "raw_splat"
BYTES = {
    "guide": KEY_BYTES + CELL.itemsize + MEMORY.itemsize,  # a cell's lobes, and what it remembers
    "statistics": KEY_BYTES + SUMS.itemsize,  # of a cell, in one frame
}


def counts_of(renderer, splat):
    """{key: samples} of the last frame, as this GuidingSplat has added them."""
    table = read_table(renderer.read_port(f"{splat}.statistics"), SUMS)[1]
    return {key: int(sums["count"]) for key, (sums,) in table.items()}


def with_raw_counts(description, names):
    """The description with a second GuidingSplat, RAW, which adds the candidates in place of the selected paths. Both add
    all rows of pixels."""
    passes = [dict(entry) for entry in description["passes"]]
    at = next(i for i, entry in enumerate(passes) if entry["name"] == names.splat)
    splat = passes[at] = {**passes[at], "knobs": {**passes[at]["knobs"], "rows": 1 << 16}}
    candidates = {"pass": names.paths, "output": "candidates", "delayed": False}
    passes.append({**splat, "name": RAW, "inputs": {**splat["inputs"], "paths": candidates}})
    shown = {"name": RAW, "pass": RAW, "output": "statistics"}
    return {**description, "passes": passes, "outputs": [*description["outputs"], shown]}


def averages(mine, other):
    """Means over the cells of `mine`, over those of both, and weighted by the samples: sum n^2 / sum n."""
    n = np.array(list(mine.values()), float)
    if not n.size:
        return 0.0, 0.0, 0.0
    return n.mean(), n.sum() / len(mine.keys() | other.keys()), (n**2).sum() / n.sum()


def measure(scene, description, size, seeds, bounces=None, first=8, last=12):
    """Frames `first` to `last` of runs of ReSTIR PG, a graph's description as JSON: `averages` (seeds,
    frames, 2, 3) of ReSTIR and raw, `cells` (seeds, frames, 2) that they touched, `guiding` (seeds, frames):
    cells fit to guide.
    """
    description = json.loads(description)
    names = GuidedGraph(description)
    renderer = restirpg.Renderer(scene, with_raw_counts(description, names), size=tuple(size), bounces=bounces)
    renderer.set(f"{names.paths}.alpha", 1.0)
    found, cells, guiding = [], [], []
    for seed in seeds:
        renderer.seed = seed
        renderer.cut()
        renderer.render(first - 1)
        for _ in range(first, last + 1):
            renderer.render(1)
            restir, raw = (counts_of(renderer, splat) for splat in (names.splat, RAW))
            found.append([averages(restir, raw), averages(raw, restir)])
            cells.append([len(restir), len(raw)])
            header = header_of(renderer.read_port(f"{names.fit}.guide"))
            guiding.append(int(header["guiding"]))
    frames = last - first + 1
    return {
        "averages": np.array(found).reshape(len(seeds), frames, 2, 3),
        "cells": np.array(cells).reshape(len(seeds), frames, 2),
        "guiding": np.array(guiding).reshape(len(seeds), frames),
        "meta": {"bytes": BYTES},
    }
