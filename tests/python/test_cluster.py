"""scripts/compare.py on the workers of a Dask scheduler: the numbers of local workers, whoever dies meanwhile."""

import collections
import json
import os
import signal
import subprocess
import sys
import time

import pytest
from harness_runs import ENVIRONMENT, arguments, changed, compare, tables

from restirpg.harness import cluster
from restirpg.harness.jobs import seed_of

distributed = pytest.importorskip(
    "distributed", reason="python3-distributed is not installed: no Dask worker has run a job"
)

SLOW = ["plain.json@sleep=0.1", "plain.json@noise=0.5,sleep=0.1,label=quiet"]  # 0.8 s a run
SLOW_OPTIONS = {"reference_frames": 64, "reference_batches": 4}
JOBS = 2 * 4 + 4  # two methods, four seeds, four batches of the reference

# Each job that the program is told has ended is written down.
COUNTED = """
from restirpg.harness.cluster import Cluster
run = Cluster.run
def counted(self, jobs, kind="run", **options):
    for job, failure, answer in run(self, jobs, kind, **options):
        if kind == "run":
            print("ended", job.key, failure, flush=True)
        yield job, failure, answer
Cluster.run = counted
"""


def start(folder, program, *arguments):
    """A program of Dask, started without our PYTHONPATH."""
    log = open(folder / f"{program}.log", "ab")
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.{program}", *arguments],
        cwd=folder,
        stdout=log,
        stderr=log,
        env={**ENVIRONMENT, "PYTHONPATH": ""},
    )


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory):
    """The address of a scheduler."""
    folder = tmp_path_factory.mktemp("dask")
    file = folder / "scheduler.json"
    process = start(
        folder, "dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)
    )
    while not (file.exists() and file.read_text().endswith("}")):
        assert process.poll() is None, (folder / "dask_scheduler.log").read_text()
        time.sleep(0.05)
    yield json.loads(file.read_text())["address"]
    process.terminate()
    process.wait(10)


@pytest.fixture
def two_workers(scheduler, tmp_path):
    """Two workers of it, each one process; a client that sees what they do."""
    processes = [
        start(tmp_path, "dask_worker", scheduler, "--nthreads", "1", "--no-nanny", "--no-dashboard") for _ in range(2)
    ]
    with distributed.Client(scheduler, set_as_default=False) as client:
        client.wait_for_workers(2, 60)
        yield client
    for process in processes:
        process.kill()
        process.wait(10)


def test_a_worker_that_is_killed_loses_nothing_and_nothing_counts_twice(tmp_path, scheduler, two_workers):
    assert compare(tmp_path, *SLOW, out="local", jobs=4, **SLOW_OPTIONS).returncode == 0
    process = subprocess.Popen(
        arguments(tmp_path, *SLOW, program=changed(COUNTED), out="cluster", scheduler=scheduler, **SLOW_OPTIONS),
        cwd=tmp_path,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    kept = tmp_path / "cluster/cache"
    processes, busy = two_workers.run(os.getpid), []
    while len(list(kept.glob("*.npz"))) < 10 or not busy:  # 8 come before the first run: probes and the reference
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
        busy = [address for address, tasks in two_workers.processing().items() if tasks]
    os.kill(processes[busy[0]], signal.SIGKILL)
    output, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    ended = collections.Counter(line for line in output.splitlines() if line.startswith("ended "))
    assert len(ended) == JOBS and set(ended.values()) == {1} and all(line.endswith(" None") for line in ended)
    assert tables(tmp_path, "cluster") == tables(tmp_path, "local")
    assert {path.name for path in kept.glob("*.npz")} == {
        path.name for path in (tmp_path / "local/cache").glob("*.npz")
    }


def test_a_run_that_fails_is_reported_as_with_local_workers(tmp_path, scheduler, two_workers):
    bad = f"plain.json@fail_seed={seed_of(0, 'run', 2)},label=bad"
    run = compare(tmp_path, "plain.json", bad, scheduler=scheduler)
    assert run.returncode == 1 and "the device was lost" in run.stderr


def test_a_fault_of_a_worker_leaves_its_traceback_in_the_worker_s_log(capfd):
    failure, answer = cluster.serve("run", b"no pickle")
    assert failure and "\n" not in failure and answer is None
    assert "Traceback" in capfd.readouterr().err


def test_a_worker_s_driver_is_told_what_the_asker_s_is_but_once(tmp_path, scheduler, two_workers, monkeypatch):
    monkeypatch.setitem(ENVIRONMENT, "GALLIVM_PERF", "nopt")
    run = compare(tmp_path, scheduler=scheduler)
    assert run.returncode == 0, run.stderr
    monkeypatch.delitem(ENVIRONMENT, "GALLIVM_PERF")
    run = compare(tmp_path, scheduler=scheduler)
    assert run.returncode != 0 and "a Dask worker's driver was started with another " in run.stderr


def test_a_scheduler_that_is_not_there_is_one_line(tmp_path):
    impatient = changed("from restirpg.harness import cluster\ncluster.SECONDS = 1")
    run = compare(tmp_path, program=impatient, scheduler="tcp://127.0.0.1:1")
    assert run.returncode == 2
    assert "compare.py: tcp://127.0.0.1:1: no Dask scheduler answers" in run.stderr
