"""benchmarks/gpu_check with stand-ins for the programs that it starts: what it runs, and what it says of a failure."""

import os
import re
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
echo "$(basename "$0") $* [${RESTIRPG_TEST_DEVICE:-}] [${RESTIRPG_VALIDATION:-}]" >> calls.txt
[[ $(basename "$0") == run && $FAILING != run ]] && echo "0 Some GPU yes" && echo "1 Old GPU no: lacks ray queries"
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
    for name in ("benchmarks/gpu_check", "scripts/setup.sh"):
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def check(clone, *arguments, failing="", **variables):
    """Its finished process."""
    environment = {**os.environ, "FAILING": failing, "PATH": f"{clone / 'bin'}:{os.environ['PATH']}", **variables}
    return subprocess.run([clone / "benchmarks/gpu_check", *arguments], capture_output=True, text=True, env=environment)


def test_every_step_is_done_on_the_device(clone):
    done = check(clone, "Some", "out", "--tiles", "8")
    assert done.returncode == 0, done.stdout + done.stderr
    calls = (clone / "calls.txt").read_text()
    [tests] = (line for line in calls.splitlines() if line.startswith("ctest "))
    installed = Path("/usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json").exists()
    assert tests.endswith(f"[Some] [{int(installed)}]") and f"--test-dir {clone / 'build'} " in tests
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


@pytest.mark.parametrize("name", ["Other", "S.me", "Old", "run devices"])
def test_a_device_that_is_not_there_or_not_usable_is_a_mistake(clone, name):
    done = check(clone, name, "out")
    assert done.returncode == 2 and f"no usable device is called '{name}'" in done.stderr
    assert check(clone).returncode == 2


def test_a_build_that_fails_before_devices_are_listed_is_no_missing_device(clone):
    done = check(clone, "Some", "out", failing="run")
    assert done.returncode == 1 and "devices: FAILED" in done.stdout and "no usable device" not in done.stderr
    assert (clone / "calls.txt").read_text().count("\n") == 1


def test_a_table_of_an_earlier_call_is_not_shown(clone):
    (clone / "out").mkdir()
    (clone / "out/tables.md").write_text("earlier\n")
    assert "earlier" not in check(clone, "Some", "out", failing="reproduce.py").stdout


def test_another_build_folder_is_built_and_tested(clone):
    check(clone, "Some", "out", RESTIRPG_BUILD="other")
    calls = (clone / "calls.txt").read_text()
    assert f"ninja -C {Path.cwd() / 'other'} " in calls and f"--test-dir {Path.cwd() / 'other'} " in calls


def test_every_test_of_a_device_is_run(clone):
    check(clone, "Some", "out")
    pattern = re.search(r"-R (\S+)", (clone / "calls.txt").read_text())[1]
    lists = [(ROOT / "tests" / folder / "tests.cmake").read_text() for folder in ("gpu", "guide", "passes", "trace")]
    names = {name for text in lists for name in re.findall(r"restirpg_test\((\w+)", text)} - {"shared_layout_test"}
    assert len(names) > 10 and names == {name for name in names if re.search(pattern, name)}
