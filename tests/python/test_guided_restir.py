"""A guide that is learnt from the very paths it then guides leaves the mean as it is, as
do one that was frozen and one whose lobes, kappa 1000 in random directions, mean nothing.

Null hypothesis: indirect light of the diffuse Cornell box has the path tracer's image mean. The mean over the
first FRAMES frames of each of RUNS independent runs is one sample, for frames of one run are correlated; |z|
< 4 has a false-alarm rate of 6 x 10^-5 a test for normal noise. A guide whose density is 10% too small, which
makes the picture 2.5% too bright, must be found.
"""

import guiding_oracle as oracle
import numpy as np
import pytest
from renderer_scenes import ROOT, make_renderer, own_plugins, restirpg, scene, scene_file  # noqa: F401
from test_restir_pt import BOUNCES, LUMINANCE, path_tracer, z_of

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
        {"name": "guide", "pass": "fit", "output": "guide"},
    ]
    return g


def run_means(scene, graph, frames, first_seed, runs):
    """Luminance mean over all frames of each run, (runs,), and the renderer after the last."""
    renderer = make_renderer(scene, graph, size=SIZE)
    renderer.set_everywhere("bounces", BOUNCES)
    means = []
    for seed in range(first_seed, first_seed + runs):
        renderer.seed = seed
        renderer.cut()
        renderer.render(frames)
        means.append((renderer.output("image").astype(float) @ LUMINANCE).mean())
    return np.array(means), renderer


def guided_means(scene, graph, first_seed):
    """Means of RUNS runs in which most cells guide."""
    means, renderer = run_means(scene, graph, FRAMES, first_seed, RUNS)
    header = oracle.read_table(renderer.read_port("fit.guide"), oracle.CELL, oracle.MEMORY)[0]
    print(
        f"{header['cells']} cells, {header['guiding']} guide, "
        f"{header['samples'] / header['cells']:.1f} samples a cell and frame; "
        f"deviation of a run {means.std(ddof=1) / means.mean():.4f}"
    )
    assert header["guiding"] > 0.5 * header["cells"]
    return means


@pytest.fixture(scope="module")
def reference(scene):
    return run_means(scene, path_tracer(), 200, 100, 12)[0]


@pytest.mark.parametrize(
    ("mode", "learn_alpha"), [("live", False), ("frozen", False), ("garbage", False), ("live", True)]
)
def test_no_guide_moves_the_mean(scene, reference, mode, learn_alpha):
    graph = guided(mode=mode, learn_alpha=learn_alpha)
    assert abs(z_of(guided_means(scene, graph, 7000), reference)) < 4


def test_a_guide_with_a_wrong_density_is_found(scene, reference):
    assert abs(z_of(guided_means(scene, guided("wrong"), 8000), reference)) > 6
