"""Every graph of graphs/ renders: its wiring and knobs are taken, its kernels compile, its light is finite."""

import numpy as np
import pytest
from renderer_scenes import ROOT, make_renderer, restirpg

GRAPHS = sorted(file.stem for file in (ROOT / "graphs").glob("*.py") if file.stem != "pipeline")


@pytest.mark.parametrize("graph", GRAPHS)
def test_a_graph_renders_two_frames_of_finite_light(scene, graph):
    renderer = make_renderer(scene, restirpg.load_graph(ROOT / f"graphs/{graph}.py"), size=(8, 8))
    renderer.render(2)
    image = renderer.output("image")
    assert np.isfinite(image).all() and image.min() >= 0 and image.mean() > 0
    if "invalid" in renderer.output_names:
        assert renderer.output("invalid").max() == 0
