"""GuidingScreen: paths guided live by one lobe per pixel have the path tracer's mean; where there are lobes.

Statistics of the rendered tests: see live_guides.py. Indirect light of the diffuse Cornell box, bounce cap 2. A guide
whose density is 10% too small must be found.
"""

import numpy as np
import pytest
from live_guides import check_mean, unguided, verdict_on
from mutants import mutant
from renderer_scenes import make_renderer, restirpg

REFERENCE_PATHS = 2048
TESTS = 3  # that share the false-alarm rate


def graph(output, **knobs):
    """ReSTIR PT over guided candidates. `output`: the port that is called radiance."""
    g = restirpg.Graph("Guided in screen space")
    gbuffer = g.add("gbuffer", "GBuffer", jitter=False)
    before = {"motion": gbuffer.motion, "previous_surface": restirpg.prev("gbuffer.surface")}
    guide = g.add(
        "guide",
        "GuidingScreen",
        surface=gbuffer.surface,
        **before,
        **knobs,
        samples=restirpg.prev("paths.samples"),
        history=restirpg.prev("guide.statistics"),
    )
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface, guide=guide.guide)
    g.add(
        "reuse",
        "ReSTIRReuse",
        surface=gbuffer.surface,
        candidates=paths.candidates,
        history=restirpg.prev("reuse.reservoirs"),
        **before,
    )
    name, port = output.split(".")
    g.output("radiance", getattr(g[name], port))
    return g


@pytest.fixture(scope="module")
def reference(scene):
    """The plain path tracer's indirect light."""
    return unguided(scene, REFERENCE_PATHS)


@pytest.mark.parametrize("lobe", ["gaussian", "vmf"])
def test_live_guiding_keeps_the_path_tracers_mean(scene, reference, lobe):
    check_mean(scene, graph("paths.radiance", lobe=lobe), reference, TESTS)


def test_restir_over_live_guiding_keeps_the_path_tracers_mean(scene, reference):
    check_mean(scene, graph("reuse.radiance", product=True, neighbours=24, prior=0.2), reference, TESTS)


def test_a_density_that_is_too_small_is_found(scene, reference):
    with mutant("screen_density"):
        assert verdict_on(scene, graph("paths.radiance"), reference, TESTS).biased


def test_the_same_seed_gives_the_same_bytes(scene):
    images = []
    for _ in range(2):
        renderer = make_renderer(scene, graph("reuse.radiance"), seed=3)
        renderer.render(8)
        images.append(renderer.output("radiance").tobytes())
    assert images[0] == images[1]


def test_lobes_point_away_from_their_surface_and_a_cut_forgets_them(scene):
    described = graph("guide.direction")
    described.output("normal", described["gbuffer"].geometric_normal)
    renderer = make_renderer(scene, described, seed=1)
    renderer.render(1)
    assert not renderer.output("radiance").any(), "a lobe before the first sample"
    renderer.render(15)
    directions = 2 * renderer.output("radiance") - 1
    guided = renderer.output("radiance").any(axis=2)
    assert guided.mean() > 0.95
    assert ((directions * renderer.output("normal")).sum(axis=2)[guided] > 0).all()
    renderer.cut()
    renderer.render(1)
    assert not renderer.output("radiance").any()


def test_what_the_camera_did_not_see_before_has_no_lobe(scene):
    renderer = make_renderer(scene, graph("guide.peak"), seed=1)
    renderer.render(8)
    camera = renderer.camera
    position, target = np.array(camera["position"]), np.array(camera["target"])
    renderer.move_camera(position=tuple(target + 1.2 * (position - target)))
    renderer.render(1)
    guided = renderer.output("radiance")[..., 0] > 0
    border = np.concatenate([guided[0], guided[-1], guided[:, 0], guided[:, -1]])
    assert not border.any(), "a lobe at the border"
    assert guided[4:-4, 4:-4].mean() > 0.9, "moments are lost on the way"
