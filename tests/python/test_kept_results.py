"""What the harness keeps: found whole or made again, whatever was damaged, edited, interrupted or killed meanwhile.

Programs run on the fake renderer, whose times are made up: whole tables can be compared.
"""

import os
import random
import resource
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import kills
import numpy as np
import pytest
from harness_runs import (
    ENVIRONMENT,
    ROOT,
    SCRIPT,
    SLOW,
    SLOW_OPTIONS,
    arguments,
    compare,
    tables,
    under_way,
    write_graph,
)

from restirpg.harness import workers
from restirpg.harness.cache import Cache
from restirpg.harness.jobs import seed_of

KEY = "0123456789abcdef" * 2
RESULT = {"image": np.arange(600, dtype=np.float32), "frames": np.arange(8), "meta": {"label": "a", "wall_ms": 1.5}}


def kept(folder, out="out"):
    """The cache's files with the times they were written."""
    return {path.name: path.stat().st_mtime_ns for path in (folder / out / "cache").glob("*.npz")}


def one_line(run):
    """The only line of a program that refused."""
    assert run.returncode == 2, run.stderr
    (line,) = run.stderr.splitlines()
    return line


def damaged(whole, draws):
    """The bytes with one bit flipped, cut short, or with something appended."""
    kind = draws.randrange(4)
    if kind == 0:
        return whole[: draws.randrange(len(whole))]
    if kind == 1:
        return whole + draws.randbytes(draws.randrange(1, 64))
    at = draws.randrange(len(whole))
    return whole[:at] + bytes([whole[at] ^ 1 << draws.randrange(8)]) + whole[at + 1 :]


def test_every_damage_is_found_and_told(tmp_path):
    said, draws = [], random.Random(3)
    cache = Cache(tmp_path, said.append)
    cache.store(KEY, RESULT)
    whole = cache.path(KEY).read_bytes()
    for number in range(2000):
        cache.path(KEY).write_bytes(damaged(whole, draws))
        assert cache.load(KEY) is None, number
    assert len(said) == 2000 and all("damaged, it is made again" in line for line in said)
    cache.path(KEY).write_bytes(whole)
    again = cache.load(KEY)
    np.testing.assert_array_equal(again["image"], RESULT["image"])
    assert again["meta"] == RESULT["meta"]
    np.testing.assert_array_equal(np.load(cache.path(KEY))["frames"], RESULT["frames"])  # readers of .npz take it


def test_a_result_under_another_s_name_is_not_believed(tmp_path):
    cache, other = Cache(tmp_path, lambda line: None), KEY[::-1]
    cache.store(KEY, RESULT)
    cache.path(KEY).rename(cache.path(other))
    assert cache.load(other) is None and not cache.path(other).exists()


def test_a_damaged_result_of_shared_is_not_believed(tmp_path):
    folder = Path(os.environ.get("RESTIRPG_SHARED", ROOT.parent / "shared")) / "inputs/hostile"
    if not folder.is_dir():
        pytest.skip(f"{folder} is not there: its damaged result has not been read")
    cache = Cache(tmp_path, lambda line: None)
    cache.path(KEY).write_bytes((folder / "cache_exc0.npz").read_bytes())
    assert cache.load(KEY) is None


@pytest.fixture(scope="module")
def whole_comparison(tmp_path_factory):
    """The folder of a comparison that was left alone."""
    folder = tmp_path_factory.mktemp("whole")
    assert compare(folder).returncode == 0
    return folder


@pytest.fixture
def whole(whole_comparison, tmp_path):
    """A copy of it in `tmp_path`, to which anything may be done."""
    return shutil.copytree(whole_comparison, tmp_path, dirs_exist_ok=True)


def test_damaged_results_are_rendered_again(whole):
    before = tables(whole)
    for path in (whole / "out/cache").glob("*.npz"):
        path.write_bytes(path.read_bytes()[:-100])
    run = compare(whole)
    assert run.returncode == 0, run.stderr
    assert run.stderr.count("damaged, it is made again") == len(kept(whole)) == len(run.stderr.splitlines())
    assert tables(whole) == before


def test_a_graph_edited_meanwhile_is_rendered_as_it_was_at_the_start(tmp_path):
    """A run that kills its worker makes the next one begin with nothing but the job."""
    methods = ["plain.json@sleep=0.02", f"plain.json@sleep=0.02,crash_seed={seed_of(0, 'run', 0)},label=crash"]
    assert compare(tmp_path, *methods, out="whole", **SLOW_OPTIONS).returncode == 1
    with under_way(tmp_path, *methods) as (process, go_on):
        write_graph(tmp_path, noise=0, gain=3)
        go_on()
        process.communicate()
    assert process.returncode == 1 and tables(tmp_path) == tables(tmp_path, "whole")


def test_code_edited_meanwhile_ends_the_program(tmp_path):
    shader = tmp_path / "shaders/a.glsl"
    shader.parent.mkdir()
    shader.write_text("a")
    with under_way(tmp_path, *SLOW, environment={"RESTIRPG_SHADERS": str(shader.parent)}) as (process, go_on):
        shader.write_text("b")
        go_on()
        (line,) = process.communicate()[1].splitlines()
    assert process.returncode == 2 and "own files have changed since the start" in line


def test_results_of_other_shaders_are_not_taken(tmp_path):
    keys = []
    for name in ("a", "b", "a"):
        (tmp_path / f"{name}.glsl").write_text(name)
        environment = {**ENVIRONMENT, "RESTIRPG_SHADERS": str(tmp_path / f"{name}.glsl")}
        subprocess.run(arguments(tmp_path, seeds=1), cwd=tmp_path, env=environment, check=True, capture_output=True)
        keys.append(set(kept(tmp_path)))
    assert len(keys[1]) == 2 * len(keys[0]) and keys[2] == keys[1]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The tables of SLOW."""
    folder = tmp_path_factory.mktemp("undisturbed")
    assert compare(folder, *SLOW, **SLOW_OPTIONS).returncode == 0
    return tables(folder)


@pytest.mark.parametrize(
    "sent, code, word",
    [(signal.SIGKILL, -signal.SIGKILL, None), (signal.SIGINT, 130, "SIGINT"), (signal.SIGTERM, 143, "SIGTERM")],
)
def test_an_interrupted_comparison_goes_on_to_the_same_tables(tmp_path, undisturbed, sent, code, word):
    with under_way(tmp_path, *SLOW) as (process, go_on):
        # Ctrl-C and SIGTERM reach the whole group; SIGKILL is meant for the program alone, whose workers end by themselves.
        os.kill(process.pid, sent) if sent == signal.SIGKILL else os.killpg(process.pid, sent)
        go_on()
        said = process.communicate()[1].strip()
    assert process.returncode == code
    if word:
        assert f"compare.py: interrupted by {word}; its " in said and "finished runs are kept in out/cache" in said
        assert len(said.splitlines()) == 1
    before = kept(tmp_path)
    assert compare(tmp_path, *SLOW, **SLOW_OPTIONS).returncode == 0
    assert before.items() < kept(tmp_path).items()
    assert tables(tmp_path) == undisturbed


def test_kills_at_any_moment_change_no_number(tmp_path, monkeypatch):
    """A small benchmarks/kills.py."""

    def command(folder):
        return arguments(tmp_path, *SLOW, program=SCRIPT, out=folder, **SLOW_OPTIONS)

    environment = {**ENVIRONMENT, "PWD": str(tmp_path)}
    monkeypatch.chdir(tmp_path)
    outcome = kills.torture(
        command, tmp_path / "kills", 3, random.Random(1), lambda folder: tables(folder, "."), lambda folder: environment
    )
    assert (outcome.kills, outcome.wrong) == (3, [])


def test_different_numbers_after_a_kill_are_told(tmp_path):
    """The injected error: a program whose every start counts. It is killed half way."""
    script = "import sys, time; open(sys.argv[1] + '/starts', 'a').write('x'); time.sleep(0.6)"
    outcome = kills.torture(
        lambda folder: [sys.executable, "-c", script, str(folder)],
        tmp_path,
        1,
        SimpleNamespace(uniform=lambda low, high: (low + high) / 2),
        lambda folder: {"starts": (folder / "starts").read_text()},
        lambda folder: None,
    )
    assert outcome.wrong == ["round 1: starts differ"]


def test_a_start_after_a_kill_that_fails_is_wrong_whatever_the_next_one_says(tmp_path):
    """The second start in a folder, which is the first after a kill, fails; the third would not."""
    script = (
        "import sys, time; file = open(sys.argv[1] + '/starts', 'a+'); file.write('x'); file.seek(0)\n"
        "starts = len(file.read()); file.close(); time.sleep(0.6 if starts == 1 else 0); sys.exit(3 * (starts == 2))"
    )
    outcome = kills.torture(
        lambda folder: [sys.executable, "-c", script, str(folder)],
        tmp_path,
        2,
        SimpleNamespace(uniform=lambda low, high: (low + high) / 2),
        lambda folder: {},
        lambda folder: None,
    )
    assert (outcome.kills, outcome.wrong) == (2, ["round 1 ended with 3: ", "round 2 ended with 3: "][: outcome.rounds])
    assert outcome.wrong


def test_a_program_that_fails_without_a_kill_ends_its_case(tmp_path):
    script = "import sys; sys.exit(sys.argv[1].endswith('round_1'))"
    outcome = kills.torture(
        lambda folder: [sys.executable, "-c", script, str(folder)],
        tmp_path,
        5,
        SimpleNamespace(uniform=lambda low, high: 60.0),
        lambda folder: {},
        lambda folder: None,
    )
    assert (outcome.kills, outcome.wrong) == (0, ["round 1 ended with 1: "])


def test_a_round_begins_without_compiled_kernels_of_either_kind(tmp_path):
    found = kills.with_caches(tmp_path / "round_1")
    for name in ("RESTIRPG_CACHE_DIR", "MESA_SHADER_CACHE_DIR"):
        folder = Path(found[name])
        assert folder.is_relative_to(tmp_path / "round_1") and folder.is_dir() and not list(folder.iterdir())


def test_what_a_kill_left_unfinished_is_told(tmp_path):
    for name in ("a.exr", ".restirpg-host-7-0.tmp", "images/.b.png.host.7.part"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert kills.unfinished_in(tmp_path) == [".b.png.host.7.part", ".restirpg-host-7-0.tmp"]


def test_a_table_that_cannot_be_written_is_told_before_the_first_kill(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(kills, "torture", lambda *_: pytest.fail("it has begun"))
    (tmp_path / "file").touch()
    assert kills.main(["--markdown", str(tmp_path / "file/table.md")]) == 2
    assert "choose another folder with --markdown" in capsys.readouterr().err


def test_without_a_cache_it_goes_on(tmp_path):
    run = compare(tmp_path, cache="/proc/cache")
    assert run.returncode == 0, run.stderr
    assert "/proc/cache: cannot be written to" in run.stderr and "will not be kept" in run.stderr
    assert compare(tmp_path, cache="/proc/cache", scheduler="tcp://127.0.0.1:1").returncode == 2
    (tmp_path / "file").touch()
    assert compare(tmp_path, cache="file").returncode == 2


def limited(folder, size, **options):
    """A comparison that cannot write files larger than `size`, as on a full disk."""
    return subprocess.run(
        arguments(folder, **options),
        cwd=folder,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
    )


def test_on_a_full_disk_nothing_is_half_written(whole):
    assert "npz: cannot be written" in one_line(limited(whole, 1000, out="new"))
    assert not kept(whole, "new")
    report = (whole / "out/report.html").read_bytes()
    assert "report.html: cannot be written" in one_line(limited(whole, len(report) // 2))
    assert (whole / "out/report.html").read_bytes() == report
    assert not list(whole.rglob("*.part"))


def test_what_a_killed_program_was_writing_is_removed(whole):
    host, ended = os.uname().nodename, subprocess.Popen(["true"])
    ended.wait()
    stale = [
        whole / f"out/.report.html.{host}.{ended.pid}.part",
        whole / f"out/cache/.{KEY}.npz.{host}.{ended.pid}.part",
    ]
    alive = whole / f"out/.report.html.{host}.{os.getpid()}.part"
    for path in (*stale, alive):
        path.touch()
    assert compare(whole).returncode == 0
    assert [path.exists() for path in (*stale, alive)] == [False, False, True]


def test_a_worker_that_ends_before_it_has_a_log_is_told(tmp_path):
    worker = workers._Process(tmp_path, 1, 1)
    os.kill(worker.process.pid, signal.SIGKILL)
    assert worker.cause_of_death() == f"the worker ended by SIGKILL; the last line of {worker.log.name}: none"


def test_programs_that_share_a_cache_have_logs_of_their_own(tmp_path):
    ended = subprocess.Popen(["true"])
    ended.wait()
    other = tmp_path / f"worker-{os.getppid()}-1.log"
    for log in (other, tmp_path / f"worker-{ended.pid}-1.log", tmp_path / "worker-1.log"):
        log.touch()
    with workers.Pool(tmp_path, 1) as pool:
        own = pool._start().log
    assert own not in (other, tmp_path / "worker-1.log") and set(tmp_path.iterdir()) - {own} == {other}


@pytest.mark.parametrize(
    "options",
    [{"reference": "out/images/scene.reference.exr"}, {"scenes": "out/report.html"}, {"environment": "link/runs.csv"}],
)
def test_an_input_is_not_written_over(tmp_path, options):
    (tmp_path / "out/images").mkdir(parents=True)
    (tmp_path / "link").symlink_to("out")
    name = next(iter(options.values()))
    (tmp_path / name).write_text("[]")
    assert f"compare.py: {name}: it would be written over; choose another" in one_line(compare(tmp_path, **options))
    assert (tmp_path / name).read_text() == "[]"
