"""The guide as a plug: any distribution may guide the paths, and none may change their mean.

Null hypothesis: guided and unguided image means are equal, by Welch's test of RUNS independent runs each (means.py). A
guide whose density is wrong by 10% must be found by the same test.
"""

import numpy as np
import pytest
from indirect_light import run_means
from means import differ
from renderer_scenes import make_renderer, restirpg

RUNS = 48
FRAMES = 8

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
    g.output("invalid", image.invalid)
    return g


def means_of(scene, first_seed, port=None, **knobs):
    """Image means of independent runs."""
    return run_means(scene, path_tracer(port, **knobs), FRAMES, first_seed, RUNS)[0]


@pytest.fixture(scope="module")
def unguided(scene):
    return means_of(scene, 1000)


@pytest.mark.parametrize("kappa, alpha", [(0.0, 0.5), (200.0, 0.5), (3.0, 0.1)])
def test_a_guide_leaves_the_mean_as_it_is(scene, unguided, kappa, alpha):
    assert not differ(means_of(scene, 2000, "guide", kappa=kappa, alpha=alpha), unguided)


def test_a_guide_with_a_wrong_density_is_found(scene, unguided):
    assert differ(means_of(scene, 3000, "wrong", kappa=0.0), unguided)


def test_a_guide_without_influence_is_the_plain_path_tracer(scene):
    """alpha = 1: the guide's density has no weight, so that the picture is the plain path tracer's but for rounding."""
    images = []
    for port, knobs in ((None, {}), ("guide", {"alpha": 1.0})):
        renderer = make_renderer(scene, path_tracer(port, **knobs), seed=5)
        renderer.render(4)
        images.append(renderer.output("image"))
    assert np.allclose(images[0], images[1], rtol=1e-5, atol=1e-6)
