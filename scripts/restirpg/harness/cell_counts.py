"""How many samples a cell of the guiding grid gets in a frame, from the paths that ReSTIR PT selected and
from its raw candidates.

A sample is a smooth bounce of a path that carries light. Candidates are unguided here (alpha = 1), so that
both see the same frames. [Zeng et al. 2025, table 1]
"""

import json

import numpy as np

import restirpg
from restirpg.harness.guiding import CELL, MEMORY, SUMS, VERTEX, GuidedGraph, header_of, is_valid, vertex_face
from restirpg.records import constant

KEY_BYTES = constant("GUIDING_KEY_BYTES")
BYTES = {
    "vertex": VERTEX.itemsize,
    "guide": KEY_BYTES + CELL.itemsize + MEMORY.itemsize,  # a cell's lobes, and what it remembers
    "statistics": KEY_BYTES + SUMS.itemsize,  # of a cell, in one frame
}


def counts_of(renderer, grid, port):
    """{key: samples} of the last frame."""
    v = renderer.read_port(port).view(VERTEX)
    v = v[is_valid(v)]
    keys = grid.keys(grid.positions(v["position"]), vertex_face(v), v["surface"] & 0xFFFF)[0]
    return dict(zip(*np.unique(keys, return_counts=True)))


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
    ports = f"{names.reuse}.vertices", f"{names.paths}.vertices"
    renderer = restirpg.Renderer(scene, description, size=tuple(size), bounces=bounces)
    renderer.set(f"{names.paths}.alpha", 1.0)
    found, cells, guiding = [], [], []
    for seed in seeds:
        renderer.seed = seed
        renderer.cut()
        renderer.render(first - 1)
        for _ in range(first, last + 1):
            renderer.render(1)
            grid = names.grid(renderer)
            restir, raw = (counts_of(renderer, grid, port) for port in ports)
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
