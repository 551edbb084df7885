"""Fixtures of the renderer's tests."""

import subprocess
import sys

import pytest
from renderer_scenes import ROOT, make_renderer, restirpg

from restirpg.harness.render import native_file


@pytest.fixture(scope="module")
def own_plugins():
    """The folder of the tests' own plugins, of the build tree that the binding module is from, on the plugin path."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RESTIRPG_PLUGIN_PATH", str(native_file().parents[2] / "tests" / "passes"))
        yield


@pytest.fixture(scope="session")
def embedded(tmp_path_factory):
    """embedded(name): the file (.glb) of a scene of make_scenes.py, written once."""
    folder = tmp_path_factory.mktemp("embedded")

    def write(name):
        file = folder / f"{name}.glb"
        if not file.exists():
            program = ROOT / "scripts" / "make_scenes.py"
            subprocess.run([sys.executable, program, name, "--out", folder], check=True)
        return file

    return write


@pytest.fixture(scope="session")
def scene_file(embedded):
    """The Cornell box (.glb)."""
    return embedded("cornell_box")


@pytest.fixture(scope="session")
def scene(scene_file):
    """The Cornell box, loaded."""
    return restirpg.load_scene(scene_file)


@pytest.fixture
def renderer(scene):
    """A fresh renderer of the path tracer at 32 x 32."""
    return make_renderer(scene)
