"""ReSTIR PT against the path tracer: indirect light of the diffuse Cornell box.

Null hypothesis: both have one image mean. z of the difference over independent runs; |z| < 4 has a false-alarm rate of 6e-5 a test
for normal noise. A reuse that leaves out the pixels whose history is empty (O20) must be found.
"""

import numpy as np
import pytest
from renderer_scenes import make_renderer, restirpg, scene, scene_file  # noqa: F401

BOUNCES = 2
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def path_tracer():
    """Indirect light by the plain path tracer."""
    g = restirpg.Graph("Indirect light, path traced")
    gbuffer = g.add("gbuffer", "GBuffer")
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface)
    image = g.add("accumulate", "Accumulate", indirect=paths.radiance, history=restirpg.prev("accumulate.sums"))
    g.output("image", image.mean)
    return g


def restir(accumulate=True, **knobs):
    """Indirect light by ReSTIR PT: the mean over frames, or the last frame."""
    g = restirpg.Graph("Indirect light, resampled")
    gbuffer = g.add("gbuffer", "GBuffer")
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface)
    reuse = g.add("reuse", "ReSTIRReuse", surface=gbuffer.surface, candidates=paths.candidates, motion=gbuffer.motion,
                  previous_surface=restirpg.prev("gbuffer.surface"), history=restirpg.prev("reuse.reservoirs"), **knobs)
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
    print(f"ratio {values.mean() / reference.mean():.4f}, z {z:.2f}, smallest detectable bias {4 * error / reference.mean():.4f}")
    return z


@pytest.fixture(scope="module")
def reference(scene):
    return means_after(scene, path_tracer(), 100, 100, 8)


def test_candidates_alone_have_the_path_tracers_mean(scene, reference):
    """Without reuse, frames are independent: their mean over a run is one sample."""
    assert abs(z_of(means_after(scene, restir(temporal=False, rounds=0), 100, 200, 8), reference)) < 4


@pytest.mark.parametrize("knobs", [{"temporal": False, "rounds": 1}, {"temporal": True, "rounds": 0}, {}],
                         ids=["spatial", "temporal", "both"])
def test_reuse_keeps_the_mean(scene, reference, knobs):
    """Frame 4 of each run is one sample, for frames of one run are correlated."""
    assert abs(z_of(means_after(scene, restir(False, **knobs), 4, 300, 24), reference)) < 4


def test_leaving_out_empty_history_is_found(scene, reference):
    knobs = {"fault": "confidence", "temporal": True, "rounds": 0}
    assert abs(z_of(means_after(scene, restir(False, **knobs), 4, 400, 8), reference)) > 6


def test_the_same_seed_gives_the_same_bytes(scene):
    images = []
    for _ in range(2):
        renderer = make_renderer(scene, restir(), seed=3)
        renderer.render(4)
        images.append(renderer.output("image").tobytes())
    assert images[0] == images[1]
