"""The Pool's work on other machines, by way of a Dask scheduler (package `distributed`).

Scheduler and workers are Dask's own programs, started by the user. The workers share a file system with who
asks: repository, build tree, scenes, graphs and cache lie under the same paths there. A task of a worker that
dies is given to another one by the scheduler; its result has the same name in the cache, so that it counts once.
"""

import collections
import functools
import os
import pickle
import sys
import threading
import traceback
import uuid
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from pathlib import Path

import restirpg
from restirpg.harness import Halt, UserError, render, workers
from restirpg.harness.cache import Cache
from restirpg.harness.jobs import digest

FOLDER = Path(__file__).resolve().parent
HARNESS = digest(b"".join(file.read_bytes() for file in sorted(FOLDER.rglob("*.py"))))  # as it was imported
SECONDS = 10  # to wait for the scheduler, and for a first worker

_one_at_a_time = threading.Lock()  # a worker may have several threads, the renderer has one


@dataclass(frozen=True)
class Place:
    """Where who asks stands: a worker takes the same place."""

    folder: str  # working folder, for scenes and graphs named relative to it
    native: str  # file of the renderer's binding module
    variables: tuple  # values of render.VARIABLES, None: not set
    cache: str
    harness: str  # hash of the harness
    code: str  # hash of the renderer's own files
    at_a_time: int = 1  # workers that a machine has, at most


def _import_distributed():
    try:
        import distributed
    except ImportError:
        raise UserError(
            f"--scheduler needs the module 'distributed' of {sys.executable}: install python3-distributed"
        ) from None
    return distributed


class Cluster:
    """As workers.Pool, on the workers of a Dask scheduler."""

    def __init__(self, folder, address):
        """folder: of the cache; address: of the scheduler, as in tcp://head:8786. Raises UserError."""
        self.finished = 0  # as Pool's
        self._distributed = _import_distributed()
        self._address = address
        self._place = Place(
            os.getcwd(),
            str(render.native_file()),
            tuple(map(os.environ.get, render.VARIABLES)),
            str(Path(folder).resolve()),
            HARNESS,
            render.code_version(),
        )
        try:
            self._client = self._distributed.Client(address, timeout=SECONDS)
        except (OSError, ValueError) as error:
            raise UserError(f"{address}: no Dask scheduler answers ({error}); start one with dask-scheduler") from None
        try:
            self._client.wait_for_workers(1, SECONDS)
        except self._distributed.TimeoutError:
            self._client.close()
            raise UserError(
                f"{address}: the scheduler has no workers; start some with dask-worker {address} --nthreads 1"
            ) from None
        hosts = collections.Counter(
            worker["host"] for worker in self._client.scheduler_info(n_workers=-1)["workers"].values()
        )
        self._place = replace(self._place, at_a_time=max(hosts.values()))

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self._client.close()

    def run(self, jobs, kind="run", on_tick=lambda job, frames: None):
        """As Pool.run; ticks come a whole job at a time."""
        batch, task = uuid.uuid4().hex, _task(str(FOLDER.parents[1]))
        waiting = {}
        for number, job in enumerate(jobs):
            key = f"restirpg-{batch}-{number}"
            waiting[self._client.submit(task, kind, pickle.dumps((self._place, job)), key=key)] = job
        try:
            for future in self._distributed.as_completed(list(waiting)):
                job = waiting[future]
                failure, answer = self._result(future)
                del waiting[future]
                if kind == "run":
                    on_tick(job, job.frames)
                self.finished += not failure and kind in ("run", "call")
                yield job, failure, answer
        finally:
            self._client.cancel(list(waiting))

    def _result(self, future):
        """(failure, answer) of a task that has ended."""
        try:
            return future.result()
        except self._distributed.KilledWorker as error:
            return f"every Dask worker that took it died, the last of them {error.last_worker.address}", None
        except CancelledError:
            raise UserError(
                f"{self._address}: the Dask scheduler has gone; finished runs are kept: with a new one, the same "
                "command goes on from here"
            ) from None


def _task(modules):
    """The function that workers run. It is sent as code, being nested: they cannot import the harness yet."""

    def task(kind, payload):
        import sys

        if modules not in sys.path:
            sys.path.insert(0, modules)
        from restirpg.harness import cluster

        return cluster.serve(kind, payload)

    return task


def serve(kind, payload):
    """Do a task in a worker; returns (failure, answer): a line of text or None, and what Worker.do returns. The worker's
    own log has the traceback of a failure.

    Raises Halt.
    """
    with _one_at_a_time:
        try:
            place, job = pickle.loads(payload)
            worker = _settle(place)
            if kind in ("run", "call") and Cache(place.cache).load(job.key):
                return None, None  # who did it before died before it could say so
            return None, worker.do(kind, job)
        except Halt:
            raise
        except Exception as error:
            traceback.print_exc()
            return workers.one_line(error), None


@functools.lru_cache(maxsize=1)
def _settle(place):
    """Take the asker's place, as far as a process can; returns what does its tasks."""
    if place.harness != HARNESS:
        raise UserError("a Dask worker runs another version of the harness: start the workers anew")
    os.chdir(place.folder)
    for name, value in zip(render.VARIABLES, place.variables):
        os.environ.pop(name, None)
        if value is not None:
            os.environ[name] = value
    restirpg.__path__.insert(0, str(Path(place.native).parent))
    render.find_package()
    if str(render.native_file()) != place.native or _code(place.variables) != place.code:
        raise UserError("a Dask worker runs another build of the renderer: start the workers anew")
    if _first_times_settings() != render.times_settings():
        raise UserError(
            f"a Dask worker's driver was started with another {' or '.join(render.OF_TIMES)}: start the workers anew"
        )
    return workers.Worker(place.cache, place.at_a_time)


@functools.lru_cache
def _first_times_settings():
    """Those of this process when it first took somebody's place: a driver reads the variables once."""
    return render.times_settings()


@functools.lru_cache
def _code(variables):
    """Hash of the renderer's files when this process first used them."""
    return render.code_version()
