"""ReSTIR DI and ReSTIR PT over a long animation: nothing but finite light that is not negative, and the same bytes
twice.

100 frames, or as many as the environment variable RESTIRPG_LONG_RUN says (1,000 are recorded in
benchmarks/results/restir_pt).
"""

import hashlib
import os

import numpy as np
import pytest
from pipeline import pipeline
from renderer_scenes import make_renderer, restirpg

FRAMES = int(os.environ.get("RESTIRPG_LONG_RUN", 100))
SIZE, FPS = (48, 32), 24


@pytest.fixture(scope="module")
def door(embedded):
    """The embedded scene whose door swings, in a loop of four seconds."""
    return restirpg.load_scene(embedded("door_ajar_animated"))


def digest_of_run(door):
    """Hash of every frame's direct and indirect light, which are looked at one by one, and of their mean."""
    graph = pipeline()
    for name in ("direct", "reuse"):
        graph.output(name, graph[name].radiance)
    renderer = make_renderer(door, graph, seed=11, size=SIZE, fps=FPS)
    digest, light = hashlib.sha256(), np.zeros(2)
    for frame in range(FRAMES):
        renderer.render(1)
        images = [renderer.output(name) for name in ("direct", "reuse")]
        for name, image in zip(("direct", "indirect"), images):
            assert np.isfinite(image).all() and image.min() >= 0, f"{name} light of frame {frame}"
            digest.update(image.tobytes())
        light += [image.mean(dtype=float) for image in images]
    assert renderer.output("invalid").max() == 0
    digest.update(renderer.output("image").tobytes())
    print(f"{FRAMES} frames, mean direct and indirect light {light / FRAMES}, sha256 {digest.hexdigest()[:16]}")
    assert (light > 0).all()
    return digest.hexdigest()


def test_every_frame_of_an_animation_is_finite_and_not_negative_and_the_same_twice(door):
    assert digest_of_run(door) == digest_of_run(door)
