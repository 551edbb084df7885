"""A guide that is learnt from the very paths it then guides leaves the mean as it is, as
do one that was frozen and one whose lobes, kappa 1000 in random directions, mean nothing.

Null hypothesis: indirect light of the diffuse Cornell box has the path tracer's image mean, by Welch's test (means.py).
The mean over the first FRAMES frames of each of RUNS independent runs is one sample, for frames of one run are
correlated. A guide whose density is 10% too small, which makes the picture 2.5% too bright, must be found in half the
runs.
"""

import guiding_oracle as oracle
import pytest
from direct_light import TREES
from indirect_light import path_tracer, run_means
from means import differ
from renderer_scenes import ROOT, restirpg

SIZE = (24, 24)
FRAMES = 24
RUNS = 48
CELLS = 4096
#: Of the history's confidence: a short memory, so that frames of a run differ.
CAP = 4

pytestmark = pytest.mark.usefixtures("own_plugins")


def guided(port="guide", mode="live", learn_alpha=False):
    """ReSTIR PG whose paths are guided by what HeldGuide makes of the fitted guide."""
    g = restirpg.load_graph(ROOT / "graphs" / "restir_pg.py").description
    fitted = {"pass": "fit", "output": "guide", "delayed": True}
    passes = {p["name"]: p for p in g["passes"]}
    passes["paths"]["inputs"]["guide"] = {"pass": "held", "output": port}
    passes["reuse"]["knobs"]["cap"] = CAP
    for name, knobs in (
        ("splat", {"cells": CELLS, "cell_size": 0.15}),
        ("fit", {"cells": CELLS, "learn_alpha": learn_alpha}),
    ):
        passes[name]["knobs"].update(knobs)
    inputs = {"guide": fitted} | (
        {"history": {"pass": "held", "output": "guide", "delayed": True}} if port == "guide" else {}
    )
    g["passes"].append({"name": "held", "type": "HeldGuide", "inputs": inputs, "knobs": {"cells": CELLS, "mode": mode}})
    passes["accumulate"]["inputs"] = {name: passes["accumulate"]["inputs"][name] for name in ("indirect", "history")}
    g["outputs"] = [
        {"name": "image", "pass": "accumulate", "output": "mean"},
        {"name": "invalid", "pass": "accumulate", "output": "invalid"},
        {"name": "guide", "pass": "fit", "output": "guide"},
    ]
    return g


def guided_means(scene, graph, first_seed, runs=RUNS):
    """Means of runs in which most cells guide."""
    means, renderer = run_means(scene, graph, FRAMES, first_seed, runs, SIZE)
    header = oracle.read_table(renderer.read_port("fit.guide"), oracle.CELL, oracle.MEMORY)[0]
    print(
        f"{header['cells']} cells, {header['guiding']} guide, "
        f"{header['samples'] / header['cells']:.1f} samples per cell and frame; "
        f"deviation of a run {means.std(ddof=1) / means.mean():.4f}"
    )
    assert header["guiding"] > 0.5 * header["cells"]
    return means


@pytest.fixture(scope="module")
def reference(scene):
    return run_means(scene, path_tracer(TREES), 3, 100, 50, SIZE)[0]


@pytest.mark.parametrize(
    ("mode", "learn_alpha"), [("live", False), ("frozen", False), ("garbage", False), ("live", True)]
)
def test_no_guide_moves_the_mean(scene, reference, mode, learn_alpha):
    graph = guided(mode=mode, learn_alpha=learn_alpha)
    assert not differ(guided_means(scene, graph, 7000), reference)


def test_a_guide_with_a_wrong_density_is_found(scene, reference):
    assert differ(guided_means(scene, guided("wrong"), 8000, RUNS // 2), reference)
