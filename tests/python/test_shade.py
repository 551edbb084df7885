"""The light of all that a merge has chosen from (the knob `shade` of ReSTIRDI and ReSTIRReuse) in place of the chosen
path's.

No test is statistical but the last: of the same reservoirs, the luminance is that of the chosen path in every pixel, and
on a diffuse surface under white light the colour is the surface's own.
"""

import numpy as np
import pytest
from direct_light import direct_graph
from mutants import mutant
from path_scenes import add_reuse, write_every_bounce
from renderer_scenes import make_renderer, restirpg

from restirpg.colour import luminance
from restirpg.scenes import shapes
from restirpg.scenes.gltf import SceneFile, emitter, lambert

FRAMES = 4
ROUNDING = 1e-5  # of a sum of some ten floats
RED, GREEN = (0.8, 0.1, 0.2), (0.1, 0.6, 0.3)
# Neighbours from the whole picture.
FAR = {"radius": 1000.0, "neighbours": 4}
SETTINGS = [
    {},
    {"rounds": 0},
    {"temporal": False},
    {"temporal": False, "rounds": 0},
    {"rounds": 2},
    FAR,
]


def indirect_graph(**knobs):
    """ReSTIR PT alone, every frame's radiance as output."""
    graph = restirpg.Graph("Indirect light")
    gbuffer = graph.add("gbuffer", "GBuffer")
    paths = graph.add("paths", "PathTracerGuided", surface=gbuffer.surface)
    reuse = add_reuse(graph, gbuffer, paths, **knobs)
    graph.output("radiance", reuse.radiance)
    return graph


GRAPHS = {"direct": direct_graph, "reuse": indirect_graph}
CASES = [(kind, settings) for kind in GRAPHS for settings in SETTINGS] + [
    ("direct", {"mis": "balance"}),
    ("direct", {"feedback": False}),
    ("reuse", {"reciprocal": True, "pool": 4, **FAR}),
]


@pytest.fixture(scope="module")
def every_bounce(tmp_path_factory):
    return restirpg.load_scene(write_every_bounce(tmp_path_factory.mktemp("every_bounce")))


@pytest.fixture(scope="module")
def two_colours(tmp_path_factory):
    """A floor of two colours fills the view; a white lamp and a white wall light it."""
    scene = SceneFile("two_colours", 1)
    for name, x, colour in (("Left", -2, RED), ("Right", 0, GREEN)):
        scene.add(name, (shapes.quad((x, 0, 2), (2, 0, 0), (0, 0, -4)), lambert(name, colour)))
    scene.add("Wall", (shapes.quad((-2, 0, -1.5), (4, 0, 0), (0, 2, 0)), lambert("White", (0.8, 0.8, 0.8))))
    scene.add("Lamp", (shapes.quad((-0.5, 2.5, 0.6), (1, 0, 0), (0, 0, 1)), emitter("Lamp", (20.0, 20.0, 20.0))))
    scene.add_camera((0, 4.0, 0.01), (0, 0, 0), 20.0)
    return restirpg.load_scene(scene.write(tmp_path_factory.mktemp("two_colours")))


def render(scene, kind, shade, settings, frames=FRAMES):
    """The last frame's radiance, float (height, width, 3), and its reservoirs."""
    renderer = make_renderer(scene, GRAPHS[kind](shade=shade, **settings))
    renderer.render(frames)
    return renderer.output("radiance").astype(float), bytes(renderer.read_port(f"{kind}.reservoirs"))


@pytest.mark.parametrize(("kind", "settings"), CASES, ids=str)
def test_all_merged_paths_have_the_luminance_of_the_chosen_one(every_bounce, kind, settings):
    chosen, kept = render(every_bounce, kind, "chosen", settings)
    merged, kept_too = render(every_bounce, kind, "merged", settings)
    assert kept == kept_too
    expected = luminance(chosen)
    assert np.mean(expected > 0) > 0.3
    assert np.abs(luminance(merged) - expected).max() <= ROUNDING * expected.max()
    lit = expected > 0
    assert (np.abs(luminance(merged) - expected)[lit] / expected[lit]).max() < ROUNDING
    merges = settings.get("temporal", True) or settings.get("rounds", 1) > 0
    assert np.array_equal(chosen, merged) != merges


def colour_error(scene, kind, settings):
    """Largest relative difference of two channels, each divided by the floor's own."""
    image, _ = render(scene, kind, "merged", settings)
    half = image.shape[1] // 2
    halves = [image[:, : half - 1] / RED, image[:, half + 1 :] / GREEN]
    assert min(each.mean() for each in halves) > 0.01
    return max((np.ptp(each, axis=2) / np.maximum(each.max(2), 1e-20)).max() for each in halves)


@pytest.mark.parametrize("kind", GRAPHS)
@pytest.mark.parametrize("settings", [FAR, {**FAR, "rounds": 2}, {"rounds": 0}], ids=str)
def test_a_pixel_has_the_colour_of_its_own_surface(two_colours, kind, settings):
    assert colour_error(two_colours, kind, settings) < ROUNDING


@pytest.mark.parametrize(("mistake", "kind"), [("di_shade", "direct"), ("reuse_shade", "reuse")])
def test_the_light_of_another_surface_is_found(two_colours, mistake, kind):
    with mutant(mistake):
        assert colour_error(two_colours, kind, FAR) > 0.1


@pytest.mark.parametrize("kind", GRAPHS)
def test_colours_are_less_noisy(every_bounce, kind):
    """By the standard deviation over eight runs of each pixel's colour, at luminance 1."""

    def noise(shade):
        renderer = make_renderer(every_bounce, GRAPHS[kind](shade=shade))
        pictures = []
        for seed in range(8):
            renderer.seed = seed
            renderer.cut()
            renderer.render(FRAMES)
            image = renderer.output("radiance").astype(float)
            pictures.append(image / np.maximum(luminance(image), 1e-20)[..., None])
        return np.std(pictures, axis=0, ddof=1).mean()

    chosen, merged = noise("chosen"), noise("merged")
    print(f"{kind}: noise of colour {chosen:.4f}, of all merged paths {merged:.4f}")
    assert merged < 0.9 * chosen
