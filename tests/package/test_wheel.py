"""What `pip install .` installs, in a clean virtual environment: imports, commands, graphs, a picture, a comparison.

scikit-build-core makes the wheel from the build tree at hand: built once, not twice. What it would compile is taken by
`cmake --install`, by the components that pyproject.toml names.
"""

import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BUILD = Path(os.environ.get("RESTIRPG_BUILD", ROOT / "build"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())

pytest.importorskip("scikit_build_core", reason="python3-scikit-build-core is not installed: no wheel was made")


def run(*command, cwd=None):
    """Run a command without the variables of the tests; returns what it printed."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("RESTIRPG_", "PYTHON"))}
    done = subprocess.run(
        [str(word) for word in command], cwd=cwd, env=environment, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """A virtual environment with the wheel: its bin folder. The modules it needs are the system's."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    package = source / "scripts" / "restirpg"
    shutil.copytree(ROOT / "scripts" / "restirpg", package, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "CMakeLists.txt", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for component in PROJECT["tool"]["scikit-build"]["install"]["components"]:
        run("cmake", "--install", BUILD, "--component", component, "--prefix", package)
    run(
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--no-build-isolation",
        "--no-index",
        "--no-deps",
        "-w",
        folder,
        "--config-settings",
        "wheel.cmake=false",
        source,
    )
    run(sys.executable, "-m", "venv", "--without-pip", "--system-site-packages", folder / "venv")
    run(
        sys.executable,
        "-m",
        "pip",
        "--python",
        folder / "venv/bin/python",
        "install",
        "--no-index",
        "--no-deps",
        *folder.glob("restirpg-*.whl"),
    )
    # What CMake puts into a wheel keeps its mode; what is copied from the sources does not.
    next(folder.glob("venv/lib/*/site-packages/restirpg/bin/restirpg")).chmod(0o755)
    return folder / "venv/bin"


def test_what_is_imported_is_what_was_installed(environment, tmp_path):
    code = (
        "import json, restirpg, restirpg.harness, restirpg.scenes as s\n"
        "print(json.dumps([restirpg.__version__, restirpg._native.__file__, s.__file__, *restirpg.code_paths()], default=str))"
    )
    version, *files = json.loads(run(environment / "python", "-c", code, cwd=tmp_path))
    assert f"VERSION {version} " in (ROOT / "CMakeLists.txt").read_text()
    assert len(files) > 3 and all(Path(file).is_relative_to(environment.parent) for file in files)
    assert run(environment / "restirpg", "--version", cwd=tmp_path).startswith(f"restirpg {version}, commit ")


def test_every_command_is_there(environment, tmp_path):
    for command in PROJECT["project"]["scripts"]:
        assert f"sage: {command} " in run(environment / command, "--help", cwd=tmp_path)


def test_two_methods_are_rendered_and_compared_from_another_folder(environment, tmp_path):
    graphs = run(environment / "python", "-c", "import restirpg; print(restirpg.GRAPHS)").strip()
    run(environment / "restirpg-scenes", "cornell_box", cwd=tmp_path)
    scene = "out/scenes/cornell_box.glb"
    run(
        environment / "restirpg",
        "render",
        f"{graphs}/path_tracer.py",
        "--scene",
        scene,
        "--size",
        "16x16",
        "-o",
        "a.exr",
        cwd=tmp_path,
    )
    assert (tmp_path / "a.exr").stat().st_size > 0
    small = "--size 16x16 --frames 2 --seeds 2 --reference-frames 4 --reference-batches 2".split()
    methods = [f"{graphs}/path_tracer.py", f"{graphs}/path_tracer.py@paths.nee=false,label=other"]
    run(environment / "restirpg-compare", *methods, "--scenes", scene, *small, cwd=tmp_path)
    assert (tmp_path / "out/compare/report.html").stat().st_size > 0
