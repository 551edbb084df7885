"""ReSTIR PT against the path tracer: indirect light of small scenes.

Null hypothesis in the diffuse Cornell box and through panes of rough glass: both have one image mean, by Welch's test
over independent runs (means.py).
A reuse that leaves out the pixels whose history is empty must be found. In the scenes of glass: the mean of the image
and of every 4 x 4 block is the path tracer's, by restirpg.harness.unbiased over RUNS runs, of which frames 1 and 8 are
samples; a false alarm of 1% a scene for the blocks and for the image. An image mean that is 6% off under every
kind of light is found, one that is 13% off in the scene of smooth glass.
"""

import numpy as np
import pytest
from direct_light import TREES, write_every_light
from indirect_light import BOUNCES, path_tracer, restir, run_means
from means import differ, independent_runs, reference_of
from mutants import mutant
from path_scenes import write_panes
from renderer_scenes import make_renderer, restirpg

from restirpg.colour import luminance
from restirpg.harness.unbiased import compare

RUNS, FRAMES, REFERENCE_PATHS = 64, (1, 8), 4096
LARGEST_UNSEEN = {"every_light": 0.06, "glass": 0.13}  # of the image mean; caustics of the glass are noisy


@pytest.fixture(scope="module")
def reference(scene):
    return run_means(scene, path_tracer(TREES), 2, 100, 25)[0]


def test_candidates_alone_have_the_path_tracers_mean(scene, reference):
    """Without reuse, frames are independent: their mean over a run is one sample."""
    assert not differ(run_means(scene, restir(temporal=False, rounds=0), 25, 200, 32)[0], reference)


@pytest.mark.parametrize(
    "knobs", [{"pool": 8, "radius": 400.0}, {"trees": 2}], ids=["compatible neighbours", "two trees"]
)
def test_reuse_keeps_the_mean(scene, reference, knobs):
    """Frame 4 of each run is one sample, for frames of one run are correlated. test_flat_energy tests other knobs."""
    assert not differ(run_means(scene, restir(False, **knobs), 4, 300, 24)[0], reference)


@pytest.mark.parametrize("port", ["paths.radiance", "reuse.radiance"])
def test_several_trees_are_the_mean_of_as_many_runs(scene, port):
    """Without reuse the luminance of n trees is the mean of n independent ones, path traced or resampled: the mean
    stays, each pixel's variance falls to 1 / n. Trees that shared their numbers would leave it; a sum in place of the
    mean would multiply both."""
    trees, frames = 4, 128
    statistics = []
    for n in (1, trees):
        graph = restir(trees=n, temporal=False, rounds=0).description()
        graph["outputs"].append({"name": "port", "pass": port.split(".")[0], "output": "radiance"})
        renderer = make_renderer(scene, graph, seed=500 + n)
        renderer.set_everywhere("bounces", BOUNCES)
        images = []
        for _ in range(frames):
            renderer.render(1)
            images.append(luminance(renderer.output("port")).ravel())
        images = np.array(images, float)
        statistics.append(
            (images.mean(), np.sqrt(images.var(0, ddof=1).mean() / images.size), images.var(0, ddof=1).mean())
        )
    (mean_1, error_1, variance_1), (mean_n, error_n, variance_n) = statistics
    print(f"{port}: mean {mean_1:.4f} and {mean_n:.4f}, variance ratio {variance_1 / variance_n:.3f}")
    assert abs(mean_1 - mean_n) < 4 * np.hypot(error_1, error_n)
    assert 0.85 * trees < variance_1 / variance_n < 1.15 * trees


def test_leaving_out_empty_history_is_found(scene, reference):
    with mutant("reuse_confidence"):
        assert differ(run_means(scene, restir(False, rounds=0), 4, 400, 8)[0], reference)


@pytest.mark.parametrize("knobs", [{"temporal": False, "rounds": 0}, {}], ids=["candidates", "reused"])
def test_light_arrives_through_many_panes_of_rough_glass(tmp_path, knobs):
    """Eight sharp lobes, each of up to 10^6 per solid angle: their product is beyond float32. Without the paths for
    which it is, candidates had 0.37 of the light, and what is reused 0.25."""
    scene, panes = restirpg.load_scene(write_panes(tmp_path, 4, 0.04)), {"size": (16, 16), "bounces": 8}
    expected = run_means(scene, path_tracer(), 4, 500, 8, **panes)[0]
    assert not differ(run_means(scene, restir(False, **knobs), 4, 600, 8, **panes)[0], expected)


def with_reference(file):
    """The scene, and its indirect light by the path tracer."""
    scene = restirpg.load_scene(file)
    tracer = make_renderer(scene, path_tracer(TREES), seed=77)
    tracer.set("paths.bounces", BOUNCES)
    frames = REFERENCE_PATHS // TREES
    tracer.render(frames)
    return scene, reference_of(tracer, frames)


@pytest.fixture(scope="module")
def every_light(tmp_path_factory):
    """Gloss and frosted glass under every kind of light, the sky too."""
    return with_reference(write_every_light(tmp_path_factory.mktemp("every_light")))


@pytest.fixture(scope="module")
def glass(embedded):
    """A ball of smooth glass and a mirror: deltas throughout."""
    return with_reference(embedded("cornell_glass"))


def block_verdicts(scene, reference, frames, runs):
    """Verdicts on the given frames of ReSTIR PT's runs, against the path tracer."""
    renderer = make_renderer(scene, restir(False))
    renderer.set("paths.bounces", BOUNCES)
    samples = independent_runs(renderer, runs, frames, output="image")
    return {k: compare(images, reference, len(frames)) for k, images in samples.items()}


@pytest.mark.parametrize("which", LARGEST_UNSEEN)
def test_every_blocks_mean_is_the_path_tracers(request, which):
    for k, verdict in block_verdicts(*request.getfixturevalue(which), FRAMES, RUNS).items():
        print(f"{which}, frame {k}: {verdict}")
        assert not verdict.biased
        assert verdict.detectable < LARGEST_UNSEEN[which]


def test_the_block_test_finds_a_mistake(every_light):
    """Leaving out empty history, in a quarter of the runs."""
    with mutant("reuse_confidence"):
        verdict = block_verdicts(*every_light, (8,), RUNS // 4)[8]
    print(verdict)
    assert verdict.biased


def test_the_same_seed_gives_the_same_bytes(scene):
    images = []
    for _ in range(2):
        renderer = make_renderer(scene, restir(), seed=3)
        renderer.render(4)
        images.append(renderer.output("image").tobytes())
    assert images[0] == images[1]
