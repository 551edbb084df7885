"""Why shifts copy guided directions and do not replay the random numbers that drew them [shaders/README: Why guided
directions are copied and not replayed].

ReplayReuse carries one bounce that never reconnects from frame to frame, as a direction (variant U, what
ReSTIRReuse does) or as random numbers (variant P, what Lin et al. 2022 do without a guide), and a guide of
few samples a cell learns from what it has carried. Variant P's contribution weights then depend on the guide
that reads the numbers, because it was fitted to those very numbers; with a guide that has stopped learning they
do not.

Null hypothesis: direct light of the Cornell box has the mean of the same pass unguided and without history, by Welch's
test (means.py). The mean over the frames of each of RUNS independent runs is one sample.
"""

import guiding_oracle as oracle
import pytest
from indirect_light import run_means
from means import FALSE_ALARM, compared

FRAMES = 24
RUNS = 48
SIZE = (24, 24)
CELLS = 4096

pytestmark = pytest.mark.usefixtures("own_plugins")


def wire(port, delayed=False):
    """A reference to PASS.OUTPUT as graph descriptions have it."""
    name, output = port.split(".")
    return {"pass": name, "output": output, "delayed": delayed}


def entry(name, kind, knobs=None, **inputs):
    """A pass of a description."""
    return {"name": name, "type": kind, "inputs": inputs, "knobs": knobs or {}}


def one_bounce(mode=None, replay=False, cap=8):
    """The description: guided by HeldGuide in that mode, or unguided and without history."""
    history = {"history": wire("bounce.reservoirs", True), "guide": wire("held.guide")} if mode else {}
    passes = [
        entry("gbuffer", "GBuffer", {"jitter": False}),
        entry("bounce", "ReplayReuse", {"replay": replay, "cap": cap}, surface=wire("gbuffer.surface"), **history),
        entry("accumulate", "Accumulate", indirect=wire("bounce.radiance"), history=wire("accumulate.sums", True)),
    ]
    outputs = [
        {"name": "image", "pass": "accumulate", "output": "mean"},
        {"name": "invalid", "pass": "accumulate", "output": "invalid"},
    ]
    if mode:
        passes += [
            entry(
                "splat",
                "GuidingSplat",
                {"cells": CELLS, "cell_size": 0.6},
                guide=wire("fit.guide", True),
                samples=wire("bounce.samples"),
            ),
            entry(
                "fit",
                "GuidingFit",
                {"cells": CELLS},
                statistics=wire("splat.statistics"),
                history=wire("fit.guide", True),
            ),
            entry(
                "held",
                "HeldGuide",
                {"cells": CELLS, "mode": mode},
                guide=wire("fit.guide", True),
                history=wire("held.guide", True),
            ),
        ]
        outputs.append({"name": "guide", "pass": "fit", "output": "guide"})
    return {"name": "one bounce", "passes": passes, "outputs": outputs}


@pytest.fixture(scope="module")
def reference(scene):
    return run_means(scene, one_bounce(), 200, 100, 32, SIZE)[0]


def guided(scene, reference, runs=RUNS, **how):
    """The Test of the guided runs' mean; most cells guide, and none has many samples."""
    means, renderer = run_means(scene, one_bounce(**how), FRAMES, 9000, runs, SIZE)
    header = oracle.read_table(renderer.read_port("fit.guide"), oracle.CELL, oracle.MEMORY)[0]
    samples = header["samples"] / header["cells"]
    print(f"{how}: {header['cells']} cells, {header['guiding']} guide, {samples:.1f} samples per cell and frame")
    assert header["guiding"] > 0.5 * header["cells"]
    assert samples < 32
    return compared(means, reference)


@pytest.mark.parametrize(("mode", "replay"), [("live", False), ("frozen", False), ("frozen", True)])
def test_copied_directions_and_a_guide_that_learns_nothing_keep_the_mean(scene, reference, mode, replay):
    assert guided(scene, reference, mode=mode, replay=replay).p > FALSE_ALARM


def test_replaying_numbers_through_a_guide_that_learnt_from_them_is_biased(scene, reference):
    test = guided(scene, reference, RUNS // 3, mode="live", replay=True)
    assert test.p < FALSE_ALARM and test.difference < -0.2
