"""ReSTIR DI is unbiased, whatever is reused, and each mistake of tests/mutants turns a test red.

Null hypothesis and false-alarm rate of the rendered tests: see scripts/restirpg/harness/unbiased.py.
"""

import numpy as np
import pytest
from direct_light import direct_graph, make_reference, write_every_light, write_open_floor
from means import independent_runs
from mutants import mutant
from renderer_scenes import SIZE, make_renderer, restirpg

from restirpg.harness.statistics import LEVEL
from restirpg.harness.unbiased import compare

RUNS = 64
FRAMES = 8
REFERENCE_PATHS = 4096
LARGEST_UNSEEN = 0.02  # of the image mean
# Weights are sums of a few floats; a shadow ray that two participants judge differently would show as 1e-2 or more.
PARTITION_TOLERANCE = 1e-4


@pytest.fixture(scope="module")
def every_light(tmp_path_factory):
    """The scene with every kind of light."""
    return restirpg.load_scene(write_every_light(tmp_path_factory.mktemp("every_light")))


@pytest.fixture(scope="module")
def every_light_reference(every_light):
    return make_reference(every_light, REFERENCE_PATHS)


@pytest.fixture(scope="module")
def box_reference(scene):
    return make_reference(scene, REFERENCE_PATHS)


def check(samples, reference):
    """Every frame of the runs agrees with the reference."""
    for k, images in samples.items():
        verdict = compare(images, reference, len(samples))
        print(f"frame {k}, {len(images)} runs: {verdict}")
        assert not verdict.biased, f"frame {k}: {verdict}"
        assert verdict.detectable < LARGEST_UNSEEN


def test_the_mean_is_the_path_tracers_under_every_kind_of_light(every_light, every_light_reference):
    renderer = make_renderer(every_light, direct_graph())
    check(independent_runs(renderer, RUNS, (1, FRAMES)), every_light_reference)


def test_the_mean_is_the_path_tracers_at_shadow_edges(scene, box_reference):
    check(independent_runs(make_renderer(scene, direct_graph()), RUNS, (1, FRAMES)), box_reference)


def orbit(renderer, k):
    """The camera of frame k of a run: a few pixels per frame, nearer and nearer. In frame FRAMES it is the scene's."""
    renderer.move_camera(position=(0.2 - 0.06 * (k - FRAMES), 1.0, 3.4 - 0.03 * (k - FRAMES)))


def test_the_mean_is_the_path_tracers_under_a_moving_camera(every_light, every_light_reference):
    renderer = make_renderer(every_light, direct_graph())
    check(independent_runs(renderer, RUNS, (FRAMES,), orbit), every_light_reference)


def swing(renderer, k):
    """The lamp of frame k of a run: it moves, tilts and grows."""
    cosine, sine = np.cos(0.08 * k), np.sin(0.08 * k)
    pose = np.eye(4)
    pose[:2, :2] = np.array([[cosine, -sine], [sine, cosine]]) * (1 + 0.02 * k)
    pose[:3, 3] = (-0.9 + 0.15 * k, 1.5, 0.1 * k)
    renderer.move_node("Lamp", pose)


def test_light_points_follow_a_light_that_moves_turns_and_grows(tmp_path):
    floor = restirpg.load_scene(write_open_floor(tmp_path))
    reference = make_reference(floor, REFERENCE_PATHS // 2, lambda renderer: swing(renderer, FRAMES))
    check(independent_runs(make_renderer(floor, direct_graph()), RUNS, (FRAMES,), swing), reference)


def test_what_is_not_direct_through_rough_lobes_is_the_path_tracers(embedded):
    """With mirrors and smooth glass, ReSTIRDI and the path tracer share the light, none of it twice."""
    glass = restirpg.load_scene(embedded("cornell_glass"))
    samples = independent_runs(make_renderer(glass, direct_graph()), RUNS // 2, (2,))
    check(samples, make_reference(glass, REFERENCE_PATHS // 2, deltas=True))


# At which the mutant di_mixture must be found.
MOSTLY_SCATTERED = {"candidates": 1, "bsdf_candidates": 4, "rounds": 0}
SETTINGS = [
    {"rounds": 0, "cap": 1},
    {"rounds": 0, "cap": 100},
    {"rounds": 1, "neighbours": 1, "cap": 20},
    {"rounds": 2, "neighbours": 3, "cap": 5},
    {"rounds": 4, "neighbours": 6, "cap": 20},
    {"rounds": 1, "neighbours": 6, "cap": 100, "radius": 150.0, "normal_threshold": -1.0, "depth_threshold": 10.0},
    {"rounds": 2, "neighbours": 3, "cap": 20, "mis": "balance"},
    {"rounds": 3, "neighbours": 2, "cap": 20, "candidates": 2, "bsdf_candidates": 4, "feedback": False},
    MOSTLY_SCATTERED,
]


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_the_mean_does_not_depend_on_what_is_reused(scene, box_reference, settings):
    samples = independent_runs(make_renderer(scene, direct_graph(**settings)), RUNS // 2, (FRAMES,))
    verdict = compare(samples[FRAMES], box_reference)
    print(verdict)
    assert verdict.image.p > LEVEL / len(SETTINGS)


# The mistake, and settings under which it matters. The weights' sums below find that of the previous camera.
@pytest.mark.parametrize(
    ("mistake", "settings"),
    [
        ("di_visibility", {}),
        ("di_cap", {}),
        ("di_confidence", {}),
        ("di_light_measure", {}),
        ("di_mixture", MOSTLY_SCATTERED),
    ],
)
def test_a_mistake_shows_in_the_mean(scene, box_reference, mistake, settings):
    with mutant(mistake):
        renderer = make_renderer(scene, direct_graph(**settings))
    samples = independent_runs(renderer, RUNS // 4, (FRAMES,))
    verdict = compare(samples[FRAMES], box_reference)
    print(f"{mistake}: {verdict}")
    assert verdict.biased


def weight_sums(every_light, pairwise=True):
    """Farthest from 1 that the MIS weights of a point add up to, in temporal and in spatial reuse."""
    graph = direct_graph()
    direct, gbuffer = graph["direct"], graph["gbuffer"]
    probe = graph.add(
        "probe",
        "MergeProbe",
        surface=gbuffer.surface,
        motion=gbuffer.motion,
        previous_surface=restirpg.prev("gbuffer.surface"),
        reservoirs=direct.reservoirs,
        history=restirpg.prev("direct.reservoirs"),
        pairwise=pairwise,
    )
    graph.output("temporal", probe.temporal)
    graph.output("spatial", probe.spatial)
    renderer = make_renderer(every_light, graph)
    worst, tried = np.zeros(2), np.zeros(2)
    for k in range(1, 5):
        orbit(renderer, k)
        renderer.render(1)
        sums = np.array([renderer.output(name) for name in ("temporal", "spatial")], float)
        worst = np.maximum(worst, sums[..., 0].max((1, 2)))
        tried += sums[..., 1].sum((1, 2))
    print(f"weights add up to 1 within {worst}, {tried.astype(int)} points")
    assert tried.min() > 3 * SIZE[0] * SIZE[1] / 2
    return worst


@pytest.mark.parametrize("pairwise", [True, False])
def test_the_weights_of_every_point_add_up_to_one(own_plugins, every_light, pairwise):
    assert weight_sums(every_light, pairwise=pairwise).max() < PARTITION_TOLERANCE


@pytest.mark.parametrize("mistake", ["di_visibility", "di_cap", "di_previous_camera"])
def test_a_mistake_breaks_the_weights_sum(own_plugins, every_light, mistake):
    with mutant(mistake, "MergeProbe"):
        assert weight_sums(every_light).max() > 100 * PARTITION_TOLERANCE


def test_reuse_lowers_the_error(scene, box_reference):
    def errors(**settings):
        samples = independent_runs(make_renderer(scene, direct_graph(**settings)), 8, (1, FRAMES))
        return [((images - box_reference.mean) ** 2).mean() for images in samples.values()]

    (alone, temporal), (spatial, _) = errors(rounds=0), errors()
    print(f"mean squared error: no reuse {alone:.1e}, spatial {spatial:.1e}, temporal {temporal:.1e}")
    assert spatial < 0.8 * alone and temporal < 0.4 * alone


def test_the_same_seed_gives_the_same_bytes(every_light):
    images = []
    for seed in (3, 3, 4):
        renderer = make_renderer(every_light, direct_graph(), seed=seed)
        renderer.render(4)
        images.append(renderer.output("radiance").tobytes())
    assert images[0] == images[1] != images[2]


@pytest.mark.parametrize("missing", ["motion", "previous_surface", "history"])
def test_half_a_history_is_refused(scene, missing):
    graph = restirpg.Graph("Half a history")
    gbuffer = graph.add("gbuffer", "GBuffer")
    inputs = {
        "motion": gbuffer.motion,
        "previous_surface": restirpg.prev("gbuffer.surface"),
        "history": restirpg.prev("direct.reservoirs"),
    }
    del inputs[missing]
    direct = graph.add("direct", "ReSTIRDI", surface=gbuffer.surface, **inputs)
    graph.output("image", direct.radiance)
    with pytest.raises(restirpg.Error, match=rf"test_restir_di\.py:\d+: pass 'direct'.* wired, but not '{missing}'"):
        make_renderer(scene, graph)


def test_without_history_each_frame_stands_alone(scene):
    graph = restirpg.Graph("No history")
    gbuffer = graph.add("gbuffer", "GBuffer")
    direct = graph.add("direct", "ReSTIRDI", surface=gbuffer.surface)
    graph.output("radiance", direct.radiance)
    alone = make_renderer(scene, graph)
    wired = make_renderer(scene, direct_graph(temporal=False))
    for renderer in (alone, wired):
        renderer.render(3)
    assert alone.output("radiance").tobytes() == wired.output("radiance").tobytes()
