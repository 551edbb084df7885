"""The Python package: where a clone finds its binding module, and what its commands say without it."""

import os
import subprocess
import sys

import pytest
from renderer_scenes import ROOT

from restirpg.harness.render import native_file

WHERE = "import restirpg; restirpg.Renderer; print(restirpg._native.__file__)"


def python(*arguments, **variables):
    """Run Python with no variable of the package's but these; a CompletedProcess with text output."""
    own = {name: value for name, value in os.environ.items() if not name.startswith(("RESTIRPG_", "PYTHON"))}
    return subprocess.run([sys.executable, *map(str, arguments)], env={**own, **variables}, capture_output=True, text=True)


@pytest.mark.parametrize("variables", [
    {"PYTHONPATH": "{scripts}", "RESTIRPG_BUILD": "{build}"}, {"PYTHONPATH": "{build}/python"},
    {"PYTHONPATH": "{scripts}:{build}/python", "RESTIRPG_BUILD": "/nowhere"}])
def test_the_binding_module_is_found(variables):
    places = {"scripts": str(ROOT / "scripts"), "build": str(native_file().parents[2])}
    done = python("-c", WHERE, **{name: text.format(**places) for name, text in variables.items()})
    assert done.stdout.strip() == str(native_file()), done.stderr


@pytest.mark.parametrize("program, arguments", [("compare", ["a.py"]), ("reproduce", ["--list"]),
                                                ("see_guide", ["--scene", "a", "--pixel", "0", "0"])])
def test_a_program_without_the_binding_module_says_how_to_get_it(program, arguments, tmp_path):
    done = python(ROOT / "scripts" / f"{program}.py", *arguments, RESTIRPG_BUILD=str(tmp_path))
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.count("\n") == 1 and done.stderr.startswith(f"{program}.py: ") and "build it with scripts/run" in done.stderr


def test_a_program_without_a_module_says_which():
    done = python("-S", ROOT / "scripts" / "make_scenes.py", "--list")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("make_scenes.py: ") and "lacks the module 'numpy'" in done.stderr
