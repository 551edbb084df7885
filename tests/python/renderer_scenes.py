"""Scenes and graphs of the renderer's tests, and the binding module from wherever the build tree is."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
if importlib.util.find_spec("restirpg") is None:
    sys.path.insert(0, str(Path(os.environ.get("RESTIRPG_BUILD", ROOT / "build")) / "python"))

import restirpg  # noqa: E402

SIZE = (32, 32)
GRAPH = ROOT / "graphs" / "path_tracer.py"


@pytest.fixture(scope="session")
def scene_file(tmp_path_factory):
    """A generated Cornell box (.glb)."""
    folder = tmp_path_factory.mktemp("scenes")
    subprocess.run([sys.executable, ROOT / "scripts" / "make_scenes.py", "cornell_box", "--out", folder], check=True)
    return folder / "cornell_box.glb"


@pytest.fixture(scope="session")
def scene(scene_file):
    """The Cornell box, loaded."""
    return restirpg.load_scene(scene_file)


@pytest.fixture
def renderer(scene):
    """A fresh renderer of the path tracer at 32 x 32."""
    return make_renderer(scene)


def make_renderer(scene, graph=None, seed=0, **options):
    """A renderer under the validation layer, any message of which is an error."""
    return restirpg.Renderer(scene, graph or restirpg.load_graph(GRAPH), size=SIZE, seed=seed, validation=True, **options)


def frame_graph(**accumulate):
    """The path tracer with each frame's own radiance and emission as outputs, besides their mean and variance."""
    graph = restirpg.Graph("Frames")
    gbuffer = graph.add("gbuffer", "GBuffer", jitter=True)
    paths = graph.add("paths", "PathTracerGuided", surface=gbuffer.surface, direct=True, bounces=2)
    image = graph.add("accumulate", "Accumulate", indirect=paths.radiance, emission=gbuffer.emission,
                      history=restirpg.prev("accumulate.sums"), **accumulate)
    graph.output("mean", image.mean)
    graph.output("variance", image.variance)
    graph.output("radiance", paths.radiance)
    graph.output("emission", gbuffer.emission)
    return graph
