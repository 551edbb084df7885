"""Furnaces: scenes of one radiance everywhere, which the path tracer must reproduce.

Null hypothesis of each case: the expected image mean is the analytic one; 16 runs of 4 frames at 16 x 16. Three
standard errors with 15 degrees of freedom are a false alarm of 0.9% a case, but the seeds are fixed: a case that passes
keeps passing.
"""

import pytest
from furnace_scenes import (
    WHITE,
    body_in_environment,
    closed_box,
    metal,
    run_means,
    standard_errors_off,
    upright_strips,
)

from restirpg.scenes.gltf import Material

RUNS, FRAMES = 16, 4
LIMIT = 3.0  # standard errors
ALBEDO = 0.8


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("furnaces")


def series(albedo, bounces):
    """Radiance in the closed box. The cap n allows n + 2 edges, so emission (1 edge) and up to n + 1 scatterings."""
    return (1 - albedo ** (bounces + 2)) / (1 - albedo)


@pytest.mark.parametrize("backend", ["software", "rayquery"])
@pytest.mark.parametrize("nee", [True, False])
@pytest.mark.parametrize("bounces", [0, 1, 2, 5])
def test_a_closed_furnace_gives_the_geometric_series_of_its_cap(folder, bounces, nee, backend):
    means = run_means(closed_box(folder, ALBEDO), RUNS, FRAMES, backend=backend, bounces=bounces, nee=nee)
    assert standard_errors_off(means, series(ALBEDO, bounces)) < LIMIT
    # The test could have failed: one bounce more or less, or an albedo 1% off, is far outside.
    assert standard_errors_off(means, series(ALBEDO, bounces + 1)) > 2 * LIMIT
    assert standard_errors_off(means, series(ALBEDO, bounces - 1)) > 2 * LIMIT


@pytest.mark.parametrize("nee", [True, False])
def test_an_albedo_one_per_cent_off_is_caught(folder, nee):
    means = run_means(closed_box(folder, ALBEDO * 1.01), RUNS, FRAMES, bounces=5, nee=nee)
    assert standard_errors_off(means, series(ALBEDO, 5)) > LIMIT
    assert standard_errors_off(means, series(ALBEDO * 1.01, 5)) < LIMIT


@pytest.mark.parametrize("backend", ["software", "rayquery"])
@pytest.mark.parametrize("nee", [True, False])
@pytest.mark.parametrize("albedo", [1.0, 0.5])
def test_a_convex_body_in_a_constant_environment_shows_its_albedo(folder, albedo, nee, backend):
    means = run_means(body_in_environment(folder, albedo), RUNS, FRAMES, backend=backend, nee=nee)
    assert standard_errors_off(means, albedo) < LIMIT
    assert standard_errors_off(means, albedo * 0.99) > LIMIT


def test_energy_compensation_gives_rough_white_surfaces_their_light_back(folder):
    """Metal and a frosted pane before a sky of radiance 1, which are flat: no light comes from one to the other."""
    file = upright_strips(
        folder,
        metal("Roughest", WHITE, 1.0),
        metal("Rough", WHITE, 0.5),
        Material("Frosted", WHITE, roughness=0.7, transmission=1.0),
    )
    assert abs(run_means(file, RUNS, FRAMES, energy_compensation=True).mean() - 1) < 0.01
    assert run_means(file, RUNS, FRAMES).mean() < 0.8
