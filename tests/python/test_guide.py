"""The guide as a plug: any distribution may guide the paths, and none may change their mean.

Null hypothesis: guided and unguided image means are equal. z of the means of RUNS independent runs each; |z| < 4 has a
false-alarm rate of 6e-5 a test. A guide whose density is wrong by 10% must be found by the same test.
"""

import numpy as np
import pytest
from renderer_scenes import make_renderer, own_plugins, restirpg, scene, scene_file  # noqa: F401

RUNS = 8
FRAMES = 48

pytestmark = pytest.mark.usefixtures("own_plugins")


def path_tracer(port=None, **knobs):
    """The path tracer, with one of FixedGuide's ports as its guide."""
    g = restirpg.Graph("Guided by a fixed lobe")
    gbuffer = g.add("gbuffer", "GBuffer", jitter=True)
    lobe = g.add("lobe", "FixedGuide", **({"kappa": knobs.pop("kappa")} if "kappa" in knobs else {}))
    paths = g.add(
        "paths",
        "PathTracerGuided",
        surface=gbuffer.surface,
        direct=True,
        bounces=2,
        guide=getattr(lobe, port) if port else None,
        **knobs,
    )
    image = g.add("accumulate", "Accumulate", indirect=paths.radiance, history=restirpg.prev("accumulate.sums"))
    g.output("image", image.mean)
    return g


def run_means(scene, first_seed, port=None, **knobs):
    """Image means of independent runs."""
    means = []
    renderer = make_renderer(scene, path_tracer(port, **knobs))
    for seed in range(first_seed, first_seed + RUNS):
        renderer.seed = seed
        renderer.cut()
        renderer.render(FRAMES)
        means.append(renderer.output("image").mean(dtype=float))
    return np.array(means)


def z_of(a, b):
    """Standard score of the difference of two sets' means."""
    z = (a.mean() - b.mean()) / np.sqrt(a.var(ddof=1) / len(a) + b.var(ddof=1) / len(b))
    print(
        f"ratio {a.mean() / b.mean():.4f}, z {z:.2f}, smallest detectable bias "
        f"{4 * np.sqrt(a.var(ddof=1) / len(a) + b.var(ddof=1) / len(b)) / b.mean():.4f}"
    )
    return z


@pytest.fixture(scope="module")
def unguided(scene):
    return run_means(scene, 1000)


@pytest.mark.parametrize("kappa, alpha", [(0.0, 0.5), (200.0, 0.5), (3.0, 0.1)])
def test_a_guide_leaves_the_mean_as_it_is(scene, unguided, kappa, alpha):
    assert abs(z_of(run_means(scene, 2000, "guide", kappa=kappa, alpha=alpha), unguided)) < 4


def test_a_guide_with_a_wrong_density_is_found(scene, unguided):
    assert abs(z_of(run_means(scene, 3000, "wrong", kappa=0.0), unguided)) > 6


def test_a_guide_without_influence_is_the_plain_path_tracer(scene):
    """alpha = 1: the guide's density has no weight, so that every byte is the plain path tracer's."""
    images = []
    for port, knobs in ((None, {}), ("guide", {"alpha": 1.0})):
        renderer = make_renderer(scene, path_tracer(port, **knobs), seed=5)
        renderer.render(4)
        images.append(renderer.output("image"))
    assert np.allclose(images[0], images[1], rtol=1e-5, atol=1e-6)
