"""The installed tree serves other repositories: find_package, restirpg_add_pass, RESTIRPG_PLUGIN_PATH.

Everything is checked in a tree that was moved after its installation, with the plugin built against it, so an
absolute path that slipped into a library or a CMake file fails here.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
BUILD = Path(os.environ.get("RESTIRPG_BUILD", ROOT / "build"))


def run(*command, expect=0, **variables):
    """Run a command with further environment variables; returns standard output and standard error together."""
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "RESTIRPG_PLUGIN_PATH")}
    result = subprocess.run(
        [str(word) for word in command],
        env=environment | {k: str(v) for k, v in variables.items()},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=600,
    )
    assert result.returncode == expect, result.stdout
    return result.stdout


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    """An installed tree, moved to another place."""
    folder = tmp_path_factory.mktemp("installed")
    run("cmake", "--install", BUILD, "--prefix", folder / "first")
    return (folder / "first").rename(folder / "moved")


def build_pass(source, build, prefix):
    run(
        "cmake", "-S", source, "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release"
    )
    run("cmake", "--build", build)
    return build


@pytest.fixture(scope="module")
def plugin(tmp_path_factory, prefix):
    """The folder of the out-of-tree pass's library."""
    return build_pass(HERE / "out_of_tree", tmp_path_factory.mktemp("exposure"), prefix)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scenes")
    run(sys.executable, ROOT / "scripts/make_scenes.py", "cornell_box", "--out", folder)
    return folder / "cornell_box.glb"


RENDER = """
import sys, numpy, restirpg
scene, graph, out = sys.argv[1:]
renderer = restirpg.Renderer(restirpg.load_scene(scene), restirpg.load_graph(graph), size=(32, 24), seed=1)
renderer.render(2)
numpy.savez(out, image=renderer.output("image"), before=renderer.output("before"))
"""


def render(prefix, scene, out, **variables):
    """Render the pass's graph with the installed Python package; returns the image with and without the pass."""
    run(
        sys.executable,
        "-c",
        RENDER,
        scene,
        HERE / "out_of_tree/exposure.py",
        out,
        PYTHONPATH=prefix / "share/restirpg/python",
        **variables,
    )
    images = np.load(out)
    return images["image"], images["before"]


def test_installed_files_hold_no_path_of_the_build(prefix):
    for file in (prefix / "lib/cmake/restirpg").iterdir():
        text = file.read_text()
        assert str(BUILD) not in text and str(ROOT) not in text, file.name


def test_every_pass_of_the_repository_is_installed(prefix):
    passes = {folder.parent.name for folder in (ROOT / "passes").glob("*/CMakeLists.txt")}
    listing = run(prefix / "bin/restirpg", "describe")
    assert passes and all(name in listing for name in passes)
    for name in passes:
        kernels = {file.name for file in (ROOT / "passes" / name).glob("*.comp")}
        assert kernels == {file.name for file in (prefix / f"lib/restirpg/passes/restirpg-pass-{name}").glob("*.comp")}


def test_pass_out_of_tree_is_found_along_the_plugin_path(prefix, plugin):
    text = run(prefix / "bin/restirpg", "describe", "Exposure", RESTIRPG_PLUGIN_PATH=plugin)
    assert all(word in text for word in ("Exposure", "radiance", "image", "stops", "Multiplies an image"))


def test_pass_out_of_tree_is_unknown_without_the_plugin_path(prefix, plugin):
    text = run(prefix / "bin/restirpg", "describe", "Exposure", expect=2)
    assert "Exposure" in text and len(text.strip().splitlines()) <= 3


def test_installed_program_renders_a_pass_out_of_tree(prefix, plugin, scene, tmp_path):
    out = tmp_path / "image.exr"
    run(
        prefix / "bin/restirpg",
        "render",
        HERE / "out_of_tree/exposure.py",
        "--scene",
        scene,
        "--size",
        "32x24",
        "--frames",
        "2",
        "-o",
        out,
        RESTIRPG_PLUGIN_PATH=plugin,
    )
    assert out.stat().st_size > 0


def test_pass_out_of_tree_computes_what_it_says(prefix, plugin, scene, tmp_path):
    """Multiplication by a power of two is exact: the two images differ by exactly that factor."""
    image, before = render(prefix, scene, tmp_path / "a.npz", RESTIRPG_PLUGIN_PATH=plugin)
    assert before.shape == (24, 32, 3) and before.max() > 0
    np.testing.assert_array_equal(image, 4 * before)


def test_installed_plugin_reads_its_kernel_beside_itself(prefix, scene, tmp_path):
    """The pass's source is gone after its installation into the framework's tree: no variable, no source folder."""
    source = tmp_path / "source"
    source.mkdir()
    for file in (HERE / "out_of_tree").iterdir():
        (source / file.name).write_text(file.read_text())
    build = build_pass(source, tmp_path / "build", prefix)
    run("cmake", "--install", build, "--prefix", prefix)
    source.rename(tmp_path / "gone")
    installed = prefix / "lib/restirpg/passes"
    try:
        image, before = render(prefix, scene, tmp_path / "b.npz")
        np.testing.assert_array_equal(image, 4 * before)
    finally:
        (installed / "restirpg-pass-Exposure.so").unlink()
