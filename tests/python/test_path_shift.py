"""The hybrid shift and the MIS weights of ReSTIR PT, path by path through its own GLSL (restir/ShiftProbe).

No statistics: paths are checked one by one. Each of the classes below must have occurred, with endings by light
samples and by scattering. Tolerances are those of float32, several times what 270,000 paths of six seeds have (in
brackets):

  weights of a path over all who could hold it add up to 1 within 1e-2 (2.4e-3), 99.9% within 1e-5 (4e-7)
  there and back: 99.9% of f within 5e-4 (3e-5), all but one in 2,000 within 1e-2 (one in 40,000 is further off: glossy
     lobes seen at grazing, up to 0.46, and others if rays and triangles are intersected by another formula), 99% of
     each ending within 1e-4 (2e-5); J J' = 1 within 1e-4 (3e-5); nothing is lost on the way back; each domain
     classifies the path as it would its own
  J against finite differences: 98% within 1% (99% are within 0.5%; the rest are third derivatives of
     narrow lobes)
"""

import numpy as np
import pytest
from mutants import mutant
from path_scenes import OUTPUTS, probe_graph, write_every_bounce
from renderer_scenes import SIZE, restirpg

FRAMES = 96
FEWER_FRAMES = 24
LEAST_PATHS, LEAST_TRIPS = 60, 5  # of a class
TRIP_NO_PATH, TRIP_NO_IMAGE, TRIP_RETURNED = range(3)  # then failures, see ShiftProbe/Shared.h
WAYS = ("stay", "neighbour", "previous")

END = 7  # bits of a kind that say how the path ends
ENDS = {"surface": 0, "emitter": 1, "environment": 2, "punctual": 3, "delta": 4}
CONNECTIONS = {"connected by a sharp lobe": 256, "connected through the surface": 512}
BOUNCES = {
    "copied": 8,
    "delta reflection": 16,
    "delta transmission": 32,
    "sharp reflection": 64,
    "sharp transmission": 128,
    **CONNECTIONS,
}
# By which technique a path ends; "reused" are those that temporal and spatial reuse leave. Candidates of light samples
# alone are those of a mutant of the path tracer.
SOURCES = {
    "light samples": {},
    "scattering": {"paths.nee": False},
    "reused": {"reuse.temporal": True, "reuse.rounds": 1},
}
NEVER = {"light samples": "delta", "scattering": "punctual"}  # the ending that a source does not have
# Surfaces reconnect by smooth lobes only, and what ends on a delta does not reconnect.
ABSENT = {("surface", "connected by a sharp lobe"), *(("delta", connection) for connection in CONNECTIONS)}


def is_of(kinds, end, bounce=None):
    """Which kinds are of a class."""
    return ((kinds & END) == ENDS[end]) & ((kinds & BOUNCES[bounce] != 0) if bounce else True)


@pytest.fixture(scope="module")
def every_bounce(own_plugins, tmp_path_factory):
    return restirpg.load_scene(write_every_bounce(tmp_path_factory.mktemp("every_bounce")))


def probe(scene, outputs=OUTPUTS):
    return restirpg.Renderer(scene, probe_graph(outputs), size=SIZE, seed=5, validation=True)


@pytest.fixture(scope="module")
def renderers(every_bounce):
    """One for each source: the probe's kernels take seconds to compile."""
    whole = probe(every_bounce)
    with mutant("tree_found_lights"):
        return {source: probe(every_bounce) if source == "light samples" else whole for source in SOURCES}


def measure(renderer, source, frames):
    """Outputs of the probe over so many frames of a moving camera: {name: float (paths, 4)}."""
    plain = {"paths.nee": True, "reuse.temporal": False, "reuse.rounds": 0}
    for name, value in {**plain, **SOURCES[source]}.items():
        renderer.set(name, value)
    renderer.cut()
    results = {name: [] for name in renderer.output_names}
    for k in range(frames):
        renderer.move_camera(position=(0.1 - 0.05 * np.sin(k), 1.0, 3.3 - 0.04 * np.cos(2 * k)))
        renderer.render(1)
        for name, values in results.items():
            values.append(renderer.output(name).reshape(-1, 4).astype(float))
    return {name: np.concatenate(values) for name, values in results.items()}


@pytest.fixture(scope="module", params=SOURCES)
def measured(request, renderers):
    frames = FEWER_FRAMES if request.param == "reused" else FRAMES
    return request.param, measure(renderers[request.param], request.param, frames)


def trips(results, way):
    """Kinds and results of the round trips of paths that have an image."""
    r = results[way][results[way][:, 3] > TRIP_NO_IMAGE]
    return r[:, 0].astype(int), r


def is_float_noise(errors):
    """Whether relative errors of f are rounding alone."""
    return np.quantile(errors, 0.999) < 5e-4 and np.mean(errors > 1e-2) < 1 / 2000


def jacobians(results):
    """Kinds of paths, and their measured over their claimed Jacobian."""
    r = np.concatenate([results["neighbour_jacobian"], results["previous_jacobian"]])
    r = r[r[:, 3] > 0]
    return r[:, 0].astype(int), r[:, 1]


def off(ratios):
    """The part of measured Jacobians that are not the claimed ones."""
    return np.mean(np.abs(ratios - 1) > 0.01)


@pytest.mark.parametrize("measured", ["light samples", "scattering"], indirect=True)  # reuse keeps what it likes
def test_every_class_of_paths_occurs(measured):
    source, results = measured
    kinds = results["stay"][results["stay"][:, 3] > TRIP_NO_PATH][:, 0].astype(int)
    returned = np.concatenate([trips(results, way)[0] for way in WAYS[1:]])
    absent = NEVER[source]
    for end in ENDS.keys() - {absent}:
        for bounce in [None, *BOUNCES]:
            if (end, bounce) in ABSENT:
                continue
            counts = is_of(kinds, end, bounce).sum(), is_of(returned, end, bounce).sum()
            print(f"{source}: {end}, {bounce or 'all'}: {counts[0]} paths, {counts[1]} shifted")
            assert counts[0] >= LEAST_PATHS and counts[1] >= LEAST_TRIPS, (end, bounce, counts)
    assert not is_of(kinds, absent).any()


@pytest.mark.parametrize("way", WAYS)
def test_a_path_shifted_there_and_back_is_the_path_it_was(measured, way):
    source, results = measured
    kinds, r = trips(results, way)
    if way == "stay":
        assert not (results[way][:, 3] == TRIP_NO_IMAGE).any()
    assert np.all(r[:, 3] == TRIP_RETURNED), np.bincount(r[:, 3].astype(int))
    print(
        f"{source}, {way}: {len(r)} trips, f {r[:, 1].max():.1e}, 99% {np.quantile(r[:, 1], 0.99):.1e}, "
        f"J {r[:, 2].max():.1e}"
    )
    assert is_float_noise(r[:, 1]) and r[:, 2].max() < 1e-4
    for end in set(kinds & END):
        assert np.quantile(r[kinds & END == end, 1], 0.99) < 1e-4


@pytest.mark.parametrize("source", ["light samples", "scattering"])
def test_paths_of_every_tree_return(renderers, source):
    """The reservoir's key names the tree: replayed with another tree's numbers, sharp bounces would lead elsewhere. (Of
    900,000 paths of other seeds one had no image in its own pixel: its connection runs along an edge.)"""
    renderer = renderers[source]
    renderer.set("paths.trees", 3)
    results = measure(renderer, source, FEWER_FRAMES)
    renderer.set("paths.trees", 1)
    for way in WAYS:
        kinds, r = trips(results, way)
        assert (kinds & BOUNCES["sharp reflection"]).any() and np.all(r[:, 3] == TRIP_RETURNED)
    assert not (results["stay"][:, 3] == TRIP_NO_IMAGE).any()


def test_jacobians_are_those_of_finite_differences(measured):
    source, results = measured
    kinds, ratios = jacobians(results)
    for end in ENDS.keys() - {NEVER.get(source)}:
        for bounce in [None, *BOUNCES]:
            of_class = ratios[is_of(kinds, end, bounce)]
            if (end, bounce) in ABSENT or (source == "reused" and len(of_class) < LEAST_TRIPS):
                continue  # reuse keeps what it likes
            assert len(of_class) >= LEAST_TRIPS, (end, bounce, len(of_class))
            print(f"{source}: {end}, {bounce or 'all'}: {len(of_class)}, {off(of_class):.1%} off")
            assert off(of_class) < 0.02 + 1 / len(of_class)
            assert np.median(np.abs(of_class - 1)) < 1e-3


def weight_sums(results, quantile=1.0):
    """How far from 1 the weights of paths add up to, in spatial and in temporal reuse."""
    sums = [results[name] for name in ("spatial_sums", "temporal_sums")]
    assert all(np.all(s[:, 2:].sum(0) > 500) for s in sums)  # of own paths and of others'
    return np.array([np.quantile(np.abs(s[:, :2]).max(1), quantile) for s in sums])


def test_the_weights_of_every_path_add_up_to_one(measured):
    source, results = measured
    worst = weight_sums(results)
    print(f"{source}: weights add up to 1 within {worst}")
    assert worst.max() < 1e-2 and weight_sums(results, 0.999).max() < 1e-5


def test_a_camera_in_a_tinted_solid_absorbs_alike_in_every_domain(own_plugins, tmp_path):
    """The edge to the camera is in f: the shift has to give it the transmittance of the domain's own camera."""
    inside = restirpg.load_scene(write_every_bounce(tmp_path, camera_in_a_solid=True))
    results = measure(probe(inside, (*WAYS, "spatial_sums", "temporal_sums")), "reused", FEWER_FRAMES)
    for way in WAYS:
        r = trips(results, way)[1]
        assert len(r) > 500 and np.all(r[:, 3] == TRIP_RETURNED)
        print(f"{way}: {len(r)} trips, f {r[:, 1].max():.1e}, 99% {np.quantile(r[:, 1], 0.99):.1e}")
        assert is_float_noise(r[:, 1]) and np.quantile(r[:, 1], 0.99) < 1e-4
    assert weight_sums(results).max() < 1e-2 and weight_sums(results, 0.999).max() < 1e-5


def measure_mutant(scene, mistake, outputs, source):
    """What the probe gives for these outputs, which are all that it compiles, with the mistake in itself and in what it
    measures."""
    with mutant(mistake, "ShiftProbe"):
        return measure(probe(scene, outputs), source, FEWER_FRAMES)


@pytest.mark.parametrize("mistake", ["reuse_mis", "reuse_previous_camera"])
def test_a_mistake_breaks_the_weights_sum(every_bounce, mistake):
    results = measure_mutant(every_bounce, mistake, ("spatial_sums", "temporal_sums"), "reused")
    assert weight_sums(results).max() > 0.1


# The mistake, and the classes of paths that it concerns.
@pytest.mark.parametrize(
    ("mistake", "classes"),
    [
        ("reuse_jacobian", [("surface", None)]),
        ("reuse_light_measure", [("emitter", None)]),
        (
            "reuse_sharp_density",
            [("surface", "sharp transmission"), ("environment", "sharp reflection"), ("delta", "sharp transmission")],
        ),
    ],
)
def test_a_factor_left_out_of_the_jacobian_shows_in_its_class(every_bounce, mistake, classes):
    """Round trips could not see it: it is left out both ways."""
    results = measure_mutant(every_bounce, mistake, ("neighbour_jacobian", "previous_jacobian"), "scattering")
    kinds, ratios = jacobians(results)
    for end, bounce in classes:
        assert off(ratios[is_of(kinds, end, bounce)]) > 0.2  # ten times what is allowed
