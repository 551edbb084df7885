"""Indirect light by the path tracer and by ReSTIR PT: graphs whose picture is called `image`, and means of their runs."""

import numpy as np
from path_scenes import add_reuse
from renderer_scenes import SIZE, check_samples, make_renderer, restirpg

from restirpg.colour import luminance

BOUNCES = 2


def path_tracer(trees=1):
    """The mean over frames by the plain path tracer."""
    g = restirpg.Graph("Indirect light, path traced")
    gbuffer = g.add("gbuffer", "GBuffer")
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface, trees=trees)
    image = g.add("accumulate", "Accumulate", indirect=paths.radiance, history=restirpg.prev("accumulate.sums"))
    g.output("image", image.mean)
    g.output("variance", image.variance)
    g.output("invalid", image.invalid)
    return g


def restir(accumulate=True, trees=1, **knobs):
    """By ReSTIR PT: the mean over frames, or the last frame."""
    g = restirpg.Graph("Indirect light, resampled")
    gbuffer = g.add("gbuffer", "GBuffer")
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface, trees=trees)
    reuse = add_reuse(g, gbuffer, paths, **knobs)
    image = g.add("accumulate", "Accumulate", indirect=reuse.radiance, history=restirpg.prev("accumulate.sums"))
    g.output("image", image.mean if accumulate else reuse.radiance)
    g.output("invalid", image.invalid)
    return g


def run_means(scene, graph, frames, first_seed, runs, size=SIZE, bounces=BOUNCES):
    """Luminance mean of the image after so many frames of each run, (runs,), and the renderer after the last. The graph
    has the output `invalid`: no frame may have a sample that is NaN or infinite."""
    renderer = make_renderer(scene, graph, size=size)
    renderer.set_everywhere("bounces", bounces)
    means = []
    for seed in range(first_seed, first_seed + runs):
        renderer.seed = seed
        renderer.cut()
        renderer.render(frames)
        image = luminance(renderer.output("image"))
        check_samples(renderer)
        assert np.isfinite(image).all() and (image >= 0).all()
        means.append(image.mean())
    return np.array(means), renderer
