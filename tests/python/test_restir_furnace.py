"""Furnaces under ReSTIR PT: values known beforehand that no kind of reuse may change.

Those of mirrors, panes and screens are deterministic: a candidate carries its light without noise, and so
does what is merged of it. The closed box is a z-test. Null hypothesis of each case: the expected image mean is
the analytic one; RUNS runs at 16 x 16, of which the last frame is a sample; 3.7 standard errors with 31 degrees
of freedom are a false alarm of 0.1% a case. Without light samples a candidate's weight has no variance there.
"""

import numpy as np
import pytest
from furnace_scenes import BRUSHED, MIRROR, PANE, closed_box, dark_half, standard_errors_off, upright_strips
from means import independent_runs
from mutants import mutant
from path_scenes import add_reuse
from renderer_scenes import restirpg

ALBEDO, BOUNCES = 0.8, 2
RUNS, FRAMES, LIMIT = 32, 4, 3.7
REUSE = {
    "none": {"temporal": False, "rounds": 0},
    "temporal": {"rounds": 0},
    "spatial": {"temporal": False},
    "both": {},
    "much": {"rounds": 3, "neighbours": 6, "cap": 100.0},
}
DEFAULTS = {"temporal": True, "rounds": 1, "neighbours": 3, "cap": 20.0}


def make_renderer(file, size, bounces, **knobs):
    """ReSTIR PT alone: indirect light, and what delta lobes find."""
    graph = restirpg.Graph("Resampled")
    gbuffer = graph.add("gbuffer", "GBuffer")
    paths = graph.add("paths", "PathTracerGuided", surface=gbuffer.surface)
    reuse = add_reuse(graph, gbuffer, paths, **knobs)
    graph.output("radiance", reuse.radiance)
    renderer = restirpg.Renderer(restirpg.load_scene(file), graph, size=size, validation=True)
    renderer.set("paths.bounces", bounces)  # not what the scene says
    return renderer


def set_reuse(renderer, knobs):
    for name, value in {**DEFAULTS, **knobs}.items():
        renderer.set(f"reuse.{name}", value)
    renderer.cut()


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    return make_renderer(closed_box(tmp_path_factory.mktemp("furnaces"), ALBEDO), (16, 16), BOUNCES)


def box_means(box, nee, knobs):
    """Image means of independent runs, without emission and direct light."""
    box.set("paths.nee", nee)
    set_reuse(box, knobs)
    return independent_runs(box, RUNS, (FRAMES,))[FRAMES].mean((1, 2))


# Light of 2 to BOUNCES + 1 scatterings.
EXPECTED = sum(ALBEDO**k for k in range(2, BOUNCES + 2))


@pytest.mark.parametrize("nee", [False, True])
@pytest.mark.parametrize("reuse", REUSE)
def test_a_closed_furnace_gives_its_series_whatever_is_reused(box, reuse, nee):
    means = box_means(box, nee, REUSE[reuse])
    error = max(means.std(ddof=1) / np.sqrt(RUNS), 1e-5 * EXPECTED)
    print(
        f"{reuse}, light samples {nee}: ratio {means.mean() / EXPECTED:.5f}, detectable {LIMIT * error / EXPECTED:.3%}"
    )
    assert standard_errors_off(means, EXPECTED) < LIMIT
    assert standard_errors_off(means, EXPECTED + ALBEDO ** (BOUNCES + 2)) > 2 * LIMIT  # a bounce too many


@pytest.mark.parametrize("mistake", ["tree_light_measure", "tree_found_lights"])
def test_a_mistake_in_the_candidates_shows_in_the_furnace(tmp_path, mistake):
    with mutant(mistake):
        box = make_renderer(closed_box(tmp_path, ALBEDO), (16, 16), BOUNCES)
    means = box_means(box, True, REUSE["none"])
    print(f"{mistake}: ratio {means.mean() / EXPECTED:.4f}")
    assert standard_errors_off(means, EXPECTED) > 2 * LIMIT


def test_a_clear_pane_loses_no_light_but_without_the_probability_of_labels(tmp_path):
    """It reflects or transmits; a label's value over its probability is 1."""

    def errors():
        pane = make_renderer(upright_strips(tmp_path, PANE), (16, 16), 0, **REUSE["none"])
        pane.render(1)
        return np.abs(pane.output("radiance").astype(float) - 1)

    assert errors().max() < 1e-5
    with mutant("tree_label_probability"):
        assert errors().mean() > 0.05


@pytest.fixture(scope="module")
def halves(tmp_path_factory):
    """Mirror and brushed metal, and nothing that would keep their pixels from sharing paths."""
    file = upright_strips(tmp_path_factory.mktemp("halves"), MIRROR, BRUSHED)
    return make_renderer(file, (16, 16), 0, radius=1000.0)


@pytest.mark.parametrize("reuse", REUSE)
def test_a_mirror_shares_no_light_with_brushed_metal(halves, reuse):
    """One bounce off the mirror is a path's light; off brushed metal it is ReSTIR DI's. The bounces have
    one label: a path that moved from the mirror to the other metal would be there twice.
    """
    set_reuse(halves, REUSE[reuse])
    halves.render(FRAMES)
    image = halves.output("radiance").astype(float)
    assert np.abs(image[:, :8] - 1).max() < 1e-5
    assert np.all(image[:, 8:] == 0)


def screened_renderer(folder):
    """Of a lit and a dark half of one floor, whose pixels share paths."""
    return make_renderer(dark_half(folder), (16, 16), BOUNCES, radius=1000.0)


@pytest.fixture(scope="module")
def screened(tmp_path_factory):
    return screened_renderer(tmp_path_factory.mktemp("dark_half"))


def light_behind_the_screen(screened, knobs):
    """Largest radiance of the dark half's pixels, after making sure that the other half is lit."""
    set_reuse(screened, knobs)
    screened.render(FRAMES)
    image = screened.output("radiance").astype(float)
    assert image[:, :7].mean() > 0.01
    return image[:, 9:].max()


@pytest.mark.parametrize("reuse", REUSE)
def test_no_path_goes_through_a_screen(screened, reuse):
    assert light_behind_the_screen(screened, REUSE[reuse]) == 0


def test_a_connection_that_is_not_traced_goes_through_the_screen(tmp_path):
    with mutant("reuse_visibility"):
        assert light_behind_the_screen(screened_renderer(tmp_path), {}) > 0.01
