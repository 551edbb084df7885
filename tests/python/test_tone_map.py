"""ToneMap: the display values of a rendered picture are those of the formulas in double precision."""

import numpy as np
import pytest
from renderer_scenes import make_renderer, restirpg, write_flying_panel

from restirpg.colour import luminance


def encode_srgb(x):
    """IEC 61966-2-1."""
    return np.where(x > 0.0031308, 1.055 * x ** (1 / 2.4) - 0.055, 12.92 * x)


@pytest.mark.parametrize("curve", ["linear", "reinhard"])
@pytest.mark.parametrize("exposure", [-2.0, 3.0])
def test_display_values_follow_the_formulas(scene, curve, exposure):
    g = restirpg.Graph("Tone mapped")
    gbuffer = g.add("gbuffer", "GBuffer")
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface, direct=True)
    display = g.add("display", "ToneMap", image=paths.radiance, curve=curve, exposure=exposure, white=2.0)
    g.output("linear", paths.radiance)
    g.output("display", display.display)
    renderer = make_renderer(scene, g)
    renderer.render(1)
    x = renderer.output("linear").astype(float) * 2.0**exposure
    if curve == "reinhard":
        y = luminance(x)[..., None]
        x = x * (1 + y / 4) / (1 + y)
    expected = encode_srgb(np.minimum(x, 1))
    assert expected.std() > 0.05
    assert np.abs(renderer.output("display") - expected).max() < 1e-5


@pytest.mark.parametrize("curve", ["linear", "reinhard"])
def test_what_overflows_by_the_exposure_is_white(tmp_path, curve):
    """Emission of 10^35 and of 0 under 20 stops; what had no light of a colour has none."""
    g = restirpg.Graph("Overflow")
    gbuffer = g.add("gbuffer", "GBuffer")
    display = g.add("display", "ToneMap", image=gbuffer.emission, curve=curve, exposure=20.0, white=0.5)
    g.output("display", display.display)
    renderer = make_renderer(restirpg.load_scene(write_flying_panel(tmp_path / "panel.gltf")), g)
    renderer.edit({"materials.0.emission": (1e35, 1e35, 0)})
    renderer.render(1)
    np.testing.assert_allclose(renderer.output("display"), np.broadcast_to((1, 1, 0), (32, 32, 3)), atol=1e-6)
