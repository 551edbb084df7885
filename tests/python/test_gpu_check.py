"""benchmarks/gpu_check with stand-ins for the programs that it starts: what it runs, and what it says of a failure."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROGRAMS = (
    "scripts/run",
    "scripts/make_scenes.py",
    "scripts/compare.py",
    "scripts/reproduce.py",
    "bin/ninja",
    "bin/ctest",
)
STAND_IN = """#!/bin/bash
echo "$(basename "$0") $* [${RESTIRPG_TEST_DEVICE:-}]" >> calls.txt
[[ $(basename "$0") == run ]] && echo "0 Some GPU"
[[ $(basename "$0") == compare.py ]] && mkdir -p out/same && echo "none found" > out/same/tables.txt
[[ $(basename "$0") != "$FAILING" ]]
"""


@pytest.fixture
def clone(tmp_path):
    """A folder like a clone, whose programs note how they were called and fail where FAILING names them."""
    for name in (*PROGRAMS, "benchmarks/gpu_check"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(STAND_IN)
        (tmp_path / name).chmod(0o755)
    shutil.copy(ROOT / "benchmarks/gpu_check", tmp_path / "benchmarks/gpu_check")
    return tmp_path


def check(clone, *arguments, failing=""):
    """Its finished process."""
    environment = {**os.environ, "FAILING": failing, "PATH": f"{clone / 'bin'}:{os.environ['PATH']}"}
    return subprocess.run([clone / "benchmarks/gpu_check", *arguments], capture_output=True, text=True, env=environment)


def test_every_step_is_done_on_the_device(clone):
    done = check(clone, "Some", "out", "--tiles", "8")
    assert done.returncode == 0, done.stdout + done.stderr
    calls = (clone / "calls.txt").read_text()
    assert "[Some]" in next(line for line in calls.splitlines() if line.startswith("ctest "))
    assert "path_tracer.py@device=llvmpipe,label=lavapipe graphs/path_tracer.py@device=Some,label=gpu" in calls
    assert "door_ajar.glb@1920x1080 --out out/paper_size --device Some --reference-frames 4096 --tiles 8" in calls
    assert "--collect out/paper_size --results out" in calls
    assert done.stdout.count(": right, ") == 7


@pytest.mark.parametrize(
    "failing, step", [("ctest", "tests"), ("compare.py", "same picture"), ("reproduce.py", "cost and error")]
)
def test_a_step_that_fails_is_named_and_the_rest_goes_on(clone, failing, step):
    done = check(clone, "Some", "out", failing=failing)
    assert done.returncode == 1 and f"{step}: FAILED" in done.stdout
    assert "--collect" in (clone / "calls.txt").read_text()


def test_a_device_that_is_not_there_is_a_mistake(clone):
    done = check(clone, "Other", "out")
    assert done.returncode == 2 and "no device is called 'Other'" in done.stderr
    assert check(clone).returncode == 2
