"""The programs of benchmarks/: a mistake is one line and exit code 2."""

import os
import re
import resource
import subprocess
import sys

import finished_rows
import pytest
import viewer_monkey
from renderer_scenes import ROOT

import restirpg
from restirpg.harness import UserError
from restirpg.harness.render import native_file

#: Programs, and arguments that name a scene which is not there.
PROGRAMS = {
    "viewer.py": ["--scene", "absent.glb"],
    "frame_costs.py": [ROOT / "graphs/path_tracer.py", "--scene", "absent.glb"],
    "guide_sweep.py": ["absent.glb", ROOT / "graphs/restir_pt.py"],
    "mitsuba/compare_with_mitsuba.py": ["absent.glb", "--mitsuba-python", "python3"],
    "mitsuba/error_over_time.py": ["absent.glb", "--mitsuba-python", "python3", "--csv", "times.csv"],
    "mitsuba/image_means.py": ["absent.glb", "--only", "ours", "--csv", "means.csv"],
}


#: Of a shell that has set nothing up, but for the build that is tested.
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
ENVIRONMENT["RESTIRPG_BUILD"] = str(native_file().parents[2])


def run(folder, name, *arguments, **environment):
    command = [sys.executable, ROOT / "benchmarks" / name, *map(str, arguments)]
    return subprocess.run(command, cwd=folder, env={**ENVIRONMENT, **environment}, capture_output=True, text=True)


def programs():
    """Names of all that are run by the distribution's Python."""
    folder = ROOT / "benchmarks"
    return sorted(str(file.relative_to(folder)) for file in folder.rglob("*.py") if os.access(file, os.X_OK))


@pytest.mark.parametrize("name", programs())
def test_every_program_tells_its_options_in_a_shell_that_set_nothing_up(tmp_path, name):
    done = run(tmp_path, name, "--help")
    assert done.returncode == 0 and done.stdout.startswith("usage: ") and not done.stderr, done.stderr


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_missing_scene_is_one_line(tmp_path, name):
    done = run(tmp_path, name, *PROGRAMS[name])
    assert done.returncode == 2 and "absent.glb" in done.stderr and done.stderr.count("\n") == 1, done.stderr


@pytest.mark.parametrize("name", PROGRAMS)
def test_an_unbuilt_package_is_one_line(tmp_path, name):
    done = run(tmp_path, name, *PROGRAMS[name], RESTIRPG_BUILD=str(tmp_path))
    assert done.returncode == 2 and "build it with scripts/run" in done.stderr, done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("name", ["mitsuba/compare_with_mitsuba.py", "mitsuba/error_over_time.py"])
def test_a_file_that_is_no_glb_is_one_line(tmp_path, name):
    (tmp_path / "absent.glb").write_text('{"asset": {"version": "2.0"}}')
    done = run(tmp_path, name, *PROGRAMS[name])
    assert done.returncode == 2 and "absent.glb: no .glb file" in done.stderr and done.stderr.count("\n") == 1


MITSUBA = [name for name in PROGRAMS if name.startswith("mitsuba/")]


@pytest.mark.parametrize("name", MITSUBA)
@pytest.mark.parametrize(
    "options, words",
    [
        (["--converter", "absent.py"], "absent.py: there is no converter"),
        (["--converter", __file__, "--mitsuba-python", "no-such-python"], "no-such-python: no such program"),
        (["--converter", __file__, "--mitsuba-python", "false"], "false: it cannot import mitsuba"),
    ],
)
def test_without_mitsuba_or_a_converter_nothing_is_rendered(tmp_path, scene_file, name, options, words):
    arguments = [
        scene_file if word == "absent.glb" else word for word in PROGRAMS[name] if word not in ("--only", "ours")
    ]
    given = ["--mitsuba-python", "python3", *options] if "--mitsuba-python" not in options else options
    done = run(tmp_path, name, *arguments, *given)
    assert (done.returncode, done.stdout) == (2, "") and words in done.stderr and done.stderr.count("\n") == 1, (
        done.stderr
    )


@pytest.mark.parametrize(
    "options, words",
    [
        (["--monkey", 5, "--seconds", 9], "--seconds changes nothing with --monkey"),
        (["--monkey", 5, "--size", "16x9", "--size", "32x18"], "give --size once"),
        (["--seed", 2], "--seed is that of --monkey"),
    ],
)
def test_options_that_the_viewer_s_measurement_would_ignore_are_refused(tmp_path, options, words):
    done = run(tmp_path, "viewer.py", "--scene", "absent.glb", *options)
    assert done.returncode == 2 and words in done.stderr.splitlines()[-1]


@pytest.mark.parametrize(
    "memory, queues, found",
    [
        ([100] * 8, [0, 3] * 4, []),
        ([100] * 4 + [200] * 4, [0] * 8, ["memory has grown from 100 to 200 MB"]),
        ([100] * 8, [0, 5, 10, 20, 40, 60, 80, 100], ["the queue has grown from 15 to 90 commands"]),
        ([100], [0], []),
    ],
)
def test_a_monkey_finds_memory_and_a_queue_that_grow(memory, queues, found):
    assert viewer_monkey.growths(memory, queues) == found


def test_a_second_client_that_fails_is_a_fault(scene_file, monkeypatch):
    """It asks for a page that is not there."""

    async def lost(session, url, dice):
        async with session.ws_connect(url + "no-such-page"):
            pass

    monkeypatch.setattr(viewer_monkey, "_watch_now_and_then", lost)
    scene = restirpg.load_scene(scene_file)
    with restirpg.view([ROOT / "graphs/path_tracer.py"], scene, (16, 16), captures=None) as viewer:
        faults, _ = viewer_monkey.run(viewer, 1, 1)
    assert len(faults) == 1 and faults[0].startswith("a client ended: WSServerHandshakeError: 4"), faults


@pytest.mark.parametrize("option", ["--runs", "--mitsuba-runs"])
def test_one_run_of_a_renderer_cannot_be_tested(tmp_path, option):
    done = run(tmp_path, "mitsuba/compare_with_mitsuba.py", *PROGRAMS["mitsuba/compare_with_mitsuba.py"], option, 1)
    assert done.returncode == 2 and "'1' is not a whole number of at least 2" in done.stderr


def test_files_are_written_whole_or_not_at_all():
    """By restirpg.harness.files; a kill would leave half of what these write."""
    programs = [file for folder in ("scripts", "benchmarks") for file in (ROOT / folder).rglob("*.py")]
    writes = re.compile(r"\.write_(text|bytes)\(|open\([^)]*\"[wx]b?\"")
    found = {file.name for file in programs if writes.search(file.read_text())}
    assert found == {"files.py", "cache.py"}  # the second one writes to memory


def test_a_row_that_cannot_be_added_leaves_those_before(tmp_path):
    file, (soft, hard) = tmp_path / "rows.csv", resource.getrlimit(resource.RLIMIT_FSIZE)
    for seed in (1, 2):
        finished_rows.append_row(file, ("seed", "mape"), (seed, 0.5))
    before = file.read_text()
    assert before == "seed,mape\n1,0.5\n2,0.5\n"
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 3, hard))
    try:
        with pytest.raises(UserError, match=r"rows\.csv: cannot be written"):
            finished_rows.append_row(file, ("seed", "mape"), (3, 0.5))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert file.read_text() == before


def test_programs_are_run_by_the_python_that_the_set_up_gives_numpy():
    for file in (ROOT / "benchmarks").rglob("*.py"):
        first = file.read_text().partition("\n")[0]
        runs = first.startswith("#!")
        assert first == "#!/usr/bin/python3" if runs else not os.access(file, os.X_OK), file
        assert not runs or os.access(file, os.X_OK), file
    assert "PYTHONPATH=scripts" not in "".join(file.read_text() for file in (ROOT / "benchmarks").rglob("*.py"))
