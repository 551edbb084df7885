"""ReSTIR PT against the path tracer: indirect light of small scenes.

Null hypothesis in the diffuse Cornell box: both have one image mean. z of the difference over independent
runs; |z| < 4 has a false-alarm rate of 6e-5 a test for normal noise. A reuse that leaves out the pixels whose
history is empty must be found. In the scenes of glass: the mean of the image and of every 4 x 4 block is
the path tracer's, by restirpg.harness.unbiased over RUNS runs, of which frames 1 and 8 are samples; a false alarm of 1%
a scene for the blocks and for the image. An image mean 3% off under every kind of light is found.
"""

import subprocess
import sys

import numpy as np
import pytest
from direct_light import write_every_light
from mutants import mutant
from path_scenes import add_reuse
from renderer_scenes import ROOT, make_renderer, restirpg, scene, scene_file  # noqa: F401

from restirpg.harness.unbiased import Reference, compare, independent_runs

BOUNCES = 2
RUNS, FRAMES, REFERENCE_FRAMES = 64, (1, 8), 4096
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def path_tracer():
    """Indirect light by the plain path tracer."""
    g = restirpg.Graph("Indirect light, path traced")
    gbuffer = g.add("gbuffer", "GBuffer")
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface)
    image = g.add("accumulate", "Accumulate", indirect=paths.radiance, history=restirpg.prev("accumulate.sums"))
    g.output("image", image.mean)
    g.output("variance", image.variance)
    return g


def restir(accumulate=True, trees=1, **knobs):
    """Indirect light by ReSTIR PT: the mean over frames, or the last frame."""
    g = restirpg.Graph("Indirect light, resampled")
    gbuffer = g.add("gbuffer", "GBuffer")
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface, trees=trees)
    reuse = add_reuse(g, gbuffer, paths, **knobs)
    image = g.add("accumulate", "Accumulate", indirect=reuse.radiance, history=restirpg.prev("accumulate.sums"))
    g.output("image", image.mean if accumulate else reuse.radiance)
    return g


def means_after(scene, graph, frames, first_seed, runs):
    """Luminance mean of the image after so many frames of each run, float (runs,)."""
    renderer = make_renderer(scene, graph)
    renderer.set_everywhere("bounces", BOUNCES)
    means = []
    for run in range(runs):
        renderer.seed = first_seed + run
        renderer.cut()
        renderer.render(frames)
        image = renderer.output("image").astype(float)
        assert np.isfinite(image).all() and (image >= 0).all()
        means.append((image @ LUMINANCE).mean())
    return np.array(means)


def z_of(values, reference):
    """Standard score of the difference of two samples' means."""
    error = np.sqrt(values.var(ddof=1) / len(values) + reference.var(ddof=1) / len(reference))
    z = (values.mean() - reference.mean()) / error
    print(
        f"ratio {values.mean() / reference.mean():.4f}, z {z:.2f}, smallest detectable bias {4 * error / reference.mean():.4f}"
    )
    return z


@pytest.fixture(scope="module")
def reference(scene):
    return means_after(scene, path_tracer(), 100, 100, 8)


def test_candidates_alone_have_the_path_tracers_mean(scene, reference):
    """Without reuse, frames are independent: their mean over a run is one sample."""
    assert abs(z_of(means_after(scene, restir(temporal=False, rounds=0), 100, 200, 8), reference)) < 4


@pytest.mark.parametrize(
    "knobs",
    [{"temporal": False, "rounds": 1}, {"temporal": True, "rounds": 0}, {}, {"pool": 8, "radius": 400.0}, {"trees": 2}],
    ids=["spatial", "temporal", "both", "compatible neighbours", "two trees"],
)
def test_reuse_keeps_the_mean(scene, reference, knobs):
    """Frame 4 of each run is one sample, for frames of one run are correlated."""
    assert abs(z_of(means_after(scene, restir(False, **knobs), 4, 300, 24), reference)) < 4


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
            images.append(renderer.output("port").reshape(-1, 3) @ LUMINANCE)
        images = np.array(images, float)
        statistics.append(
            (images.mean(), np.sqrt(images.var(0, ddof=1).mean() / images.size), images.var(0, ddof=1).mean())
        )
    (mean_1, error_1, variance_1), (mean_n, error_n, variance_n) = statistics
    print(f"{port}: mean {mean_1:.4f} and {mean_n:.4f}, variance ratio {variance_1 / variance_n:.3f}")
    assert abs(mean_1 - mean_n) < 4 * np.hypot(error_1, error_n)
    assert 0.85 * trees < variance_1 / variance_n < 1.15 * trees


def test_leaving_out_empty_history_is_found(scene, reference):
    with mutant("reuse_confidence", "ReSTIRReuse"):
        assert abs(z_of(means_after(scene, restir(False, rounds=0), 4, 400, 8), reference)) > 6


def block_verdicts(file, frames, runs):
    """Verdicts on the given frames of ReSTIR PT's runs, against the path tracer."""
    scene = restirpg.load_scene(file)
    tracer = make_renderer(scene, path_tracer(), seed=77)
    tracer.set("paths.bounces", BOUNCES)
    tracer.render(REFERENCE_FRAMES)
    # The standard deviation of a luminance is at most that of fully correlated channels.
    error = np.sqrt(tracer.output("variance").astype(float)) @ LUMINANCE / np.sqrt(REFERENCE_FRAMES)
    reference = Reference(tracer.output("image").astype(float) @ LUMINANCE, error**2)
    renderer = make_renderer(scene, restir(False))
    renderer.set("paths.bounces", BOUNCES)
    samples = independent_runs(renderer, runs, frames, output="image")
    return {k: compare(images, reference, len(frames)) for k, images in samples.items()}


def cornell_glass(folder):
    """The embedded scene: a glass ball and a mirror, deltas throughout."""
    program = ROOT / "scripts" / "make_scenes.py"
    subprocess.run([sys.executable, program, "cornell_glass", "--out", folder], check=True)
    return folder / "cornell_glass.glb"


@pytest.mark.parametrize("write", [write_every_light, cornell_glass])
def test_every_blocks_mean_is_the_path_tracers(tmp_path, write):
    """Gloss and frosted glass under every kind of light, the sky too; smooth glass and a mirror."""
    for k, verdict in block_verdicts(write(tmp_path), FRAMES, RUNS).items():
        print(f"{write.__name__}, frame {k}: {verdict}")
        assert not verdict.biased


def test_the_block_test_finds_a_mistake(tmp_path):
    """Leaving out empty history, in a quarter of the runs."""
    with mutant("reuse_confidence", "ReSTIRReuse"):
        verdict = block_verdicts(write_every_light(tmp_path), (8,), RUNS // 4)[8]
    print(verdict)
    assert verdict.biased


def test_the_same_seed_gives_the_same_bytes(scene):
    images = []
    for _ in range(2):
        renderer = make_renderer(scene, restir(), seed=3)
        renderer.render(4)
        images.append(renderer.output("image").tobytes())
    assert images[0] == images[1]
