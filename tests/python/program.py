"""The command line program, run by tests."""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
BUILD = Path(os.environ.get("RESTIRPG_BUILD", ROOT / "build"))
PROGRAM = BUILD / "bin" / "restirpg"
GRAPH = ROOT / "graphs" / "path_tracer.py"


def restirpg(*arguments, folder=ROOT):
    """Run the program. Returns (exit code, standard output, standard error)."""
    done = subprocess.run(
        [PROGRAM, *map(str, arguments)], cwd=folder, text=True, capture_output=True, timeout=600, check=False
    )
    return done.returncode, done.stdout, done.stderr


def refusal(*arguments, folder=ROOT):
    """The one line on standard error of a run that must be refused without a word on standard output."""
    code, output, errors = restirpg(*arguments, folder=folder)
    assert (code, output) == (2, ""), errors
    assert errors.count("\n") == 1
    return errors.rstrip("\n")
