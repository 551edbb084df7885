"""Worker processes: a job that crashes, or is killed, takes its own worker with it and nothing else."""

import contextlib
import faulthandler
import multiprocessing
import os
import signal
import sys
import traceback
from multiprocessing.connection import wait
from pathlib import Path

from harness import measure, render
from harness.jobs import Cache

_context = multiprocessing.get_context("spawn")  # a fork would inherit the parent's threads and GPU state


class Worker:
    """What a worker process knows from task to task."""

    def __init__(self, folder, at_a_time=1):
        """folder: the cache's; at_a_time: how many runs this machine does at once, for their times suffer."""
        self._cache, self._renderers, self._at_a_time = Cache(folder), render.Renderers(), at_a_time

    def do(self, kind, job, tick=lambda frames: None):
        """Do a task, see Pool.run: its answer is returned, its result kept in the cache."""
        if kind == "probe":
            return self._renderers.probe(job)
        self._cache.store(job.key, job.run() if kind == "call" else self._run(job, tick))

    def _run(self, job, tick):
        try:
            result = measure.run(job, self._cache.load, tick, self._renderers)
        except Exception:
            self._renderers.forget()
            raise
        result["meta"]["at_a_time"] = self._at_a_time
        result["meta"]["job"] = {
            "label": job.label,
            "scene": job.scene,
            "graph": job.graph,
            "seed": job.seed,
            "size": list(job.size),
            "frames": job.frames,
        }
        return result


def one_line(error):
    """An exception as a line for the user."""
    return " ".join(str(error).split()) or type(error).__name__


def _serve(connection, folder, at_a_time, log):
    """A worker's whole life: take a task, answer with ticks and one result, until the pipe closes."""
    with open(
        log, "ab", buffering=0
    ) as file:  # the renderer's own messages must not spoil the progress display
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    faulthandler.enable()
    render.find_package()
    worker = Worker(folder, at_a_time)
    try:
        while True:
            kind, job = connection.recv()
            try:
                answer = worker.do(kind, job, lambda frames: connection.send(("tick", frames)))
                connection.send(("done", answer))
            except (BrokenPipeError, EOFError):
                raise
            except Exception as error:
                traceback.print_exc()
                connection.send(("failed", one_line(error)))
    except (BrokenPipeError, EOFError, OSError):
        sys.exit(0)  # the harness has gone


class _Process:
    def __init__(self, folder, at_a_time, number):
        self.log = Path(folder) / f"worker-{number}.log"
        self.log.unlink(missing_ok=True)
        self.job = None
        self.connection, theirs = _context.Pipe()
        self.process = _context.Process(target=_serve, args=(theirs, str(folder), at_a_time, str(self.log)), daemon=True)
        # Ctrl-C reaches the whole process group: the parent alone decides what ends, so the worker never sees
        # it.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        self.process.start()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        theirs.close()

    def cause_of_death(self):
        """One line for the user, after the pipe closed."""
        self.process.join(5)
        code = self.process.exitcode
        if code is not None and code < 0:
            ended = f"ended by {signal.Signals(-code).name}"
        else:
            ended = f"ended with exit code {code}"
        lines = [line for line in self.log.read_text(errors="replace").splitlines() if line.strip()]
        return f"the worker {ended}; the last line of {self.log.name}: {lines[-1] if lines else 'none'}"

    def stop(self):
        """End the process at once."""
        self.connection.close()
        self.process.terminate()
        self.process.join(5)
        if self.process.is_alive():
            self.process.kill()


def open_pool(folder, count, scheduler=None):
    """A Pool of `count` workers, or a Cluster at a Dask scheduler's address; to be used in `with`."""
    if scheduler:
        from harness.cluster import Cluster  # with Dask, which only it needs

        return Cluster(folder, scheduler)
    return Pool(folder, count)


class Pool:
    """Up to `count` workers, started when first needed and kept between calls of `run`."""

    def __init__(self, folder, count):
        self._folder = folder
        self._idle = []
        self._count = count
        self._started = 0

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        for worker in self._idle:
            worker.stop()
        self._idle = []

    def run(self, jobs, kind="run", on_tick=lambda job, frames: None):
        """Run the jobs in order; yields (job, failure, answer) as they end: failure is a line of text or
        None. `kind`: "run" or "probe" of Jobs, "call" of Calls; results of runs and calls are in the cache.
        """
        waiting, busy = list(jobs), {}
        try:
            while waiting or busy:
                while waiting and len(busy) < self._count:
                    worker = self._idle.pop() if self._idle else self._start()
                    worker.job = waiting.pop(0)
                    busy[worker.connection] = worker
                    with contextlib.suppress(BrokenPipeError):  # it died idle: its pipe tells below
                        worker.connection.send((kind, worker.job))
                for connection in wait(list(busy)):
                    worker = busy[connection]
                    try:
                        event, answer = connection.recv()
                    except (EOFError, ConnectionResetError):
                        del busy[connection]
                        yield worker.job, worker.cause_of_death(), None
                        continue
                    if event == "tick":
                        on_tick(worker.job, answer)
                        continue
                    self._idle.append(busy.pop(connection))
                    yield worker.job, answer if event == "failed" else None, answer
        finally:
            for worker in busy.values():
                worker.stop()

    def _start(self):
        self._started += 1
        return _Process(self._folder, self._count, self._started)
