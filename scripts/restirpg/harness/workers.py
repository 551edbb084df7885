"""Worker processes: a job that crashes, or is killed, takes its own worker with it and nothing else."""

import contextlib
import faulthandler
import multiprocessing
import os
import platform
import signal
import sys
import traceback
from multiprocessing.connection import wait
from pathlib import Path

from restirpg.harness import Halt, measure, render, scenes
from restirpg.harness.cache import Cache

_context = multiprocessing.get_context("spawn")  # a fork would inherit the parent's threads and GPU state


class Worker:
    """What a worker process knows from task to task."""

    def __init__(self, folder, at_a_time=1):
        """folder: the cache's; at_a_time: how many runs this machine does at once, for their times suffer."""
        self._cache, self._renderers, self._at_a_time = Cache(folder), render.Renderers(), at_a_time

    def do(self, kind, job, tick=lambda frames: None):
        """Do a task, see Pool.run: its answer is returned, its result kept in the cache."""
        if kind == "scene":
            return scenes.facts_of(*render.load_scene(job))
        if kind == "probe":
            answer = self._renderers.probe(job)
            render.check_code(job.code)
            return answer
        result = self._call(job) if kind == "call" else self._run(job, tick)
        render.check_code(job.code)  # a kernel compiled, or a plugin loaded, under way may have been of other code
        self._cache.store(job.key, result)

    @staticmethod
    def _call(call):
        return call.function(render.load_scene(call)[1], **dict(call.settings))

    def _run(self, job, tick):
        try:
            result = measure.run(job, self._cache.need, tick, self._renderers)
        except Exception:
            self._renderers.forget()
            raise
        result["meta"]["at_a_time"] = self._at_a_time
        result["meta"]["machine"] = platform.node()
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
    text = " ".join(str(error).split()) or type(error).__name__
    return "".join(letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text)


def _serve(connection, folder, at_a_time, log):
    """A worker's whole life: take a task, answer with ticks and one result, until the pipe closes."""
    with open(log, "ab", buffering=0) as file:  # the renderer's own messages must not spoil the progress display
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
            except Halt as error:
                connection.send(("halt", one_line(error)))
            except Exception as error:
                traceback.print_exc()
                connection.send(("failed", one_line(error)))
    except (BrokenPipeError, EOFError, OSError):
        sys.exit(0)  # the harness has gone


@contextlib.contextmanager
def _safe_path():
    """A Python that is started here does not look for modules in the current folder, which may be anybody's: it would do
    so before it looks into the standard library."""
    before = os.environ.get("PYTHONSAFEPATH")
    os.environ["PYTHONSAFEPATH"] = "1"
    try:
        yield
    finally:
        os.environ.pop("PYTHONSAFEPATH")
        if before is not None:
            os.environ["PYTHONSAFEPATH"] = before


class _Process:
    def __init__(self, folder, at_a_time, number):
        self.log = Path(folder) / f"worker-{os.getpid()}-{number}.log"
        self.log.unlink(missing_ok=True)
        self.job = None
        self.connection, theirs = _context.Pipe()
        self.process = _context.Process(
            target=_serve, args=(theirs, str(folder), at_a_time, str(self.log)), daemon=True
        )
        # Ctrl-C reaches the whole process group: the parent alone decides what ends, so the worker never sees
        # it.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        with _safe_path():
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
        try:
            text = self.log.read_text(errors="replace")
        except FileNotFoundError:  # it ended before it had a log
            text = ""
        lines = [line for line in text.splitlines() if line.strip()]
        return f"the worker {ended}; the last line of {self.log.name}: {lines[-1] if lines else 'none'}"

    def stop(self):
        """End the process at once."""
        self.connection.close()
        self.process.terminate()
        self.process.join(5)
        if self.process.is_alive():
            self.process.kill()


def _remove_logs(folder):
    """Remove the logs that programs of this machine have left which have ended; others may share the folder."""
    for log in Path(folder).glob("worker-*.log"):
        _, *program, _ = log.stem.split("-")
        if not (program and Path("/proc", *program).exists()):
            log.unlink(missing_ok=True)


class Pool:
    """Up to `count` workers, started when first needed and kept between calls of `run`."""

    def __init__(self, folder, count):
        self.finished = 0  # runs and calls that are in the cache now
        self._folder = folder
        _remove_logs(folder)
        self._workers, self._idle, self._started = [], [], 0
        self._count = count

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        for worker in self._workers:
            worker.stop()
        self._workers, self._idle = [], []

    def run(self, jobs, kind="run", on_tick=lambda job, frames: None):
        """Run the jobs in order; yields (job, failure, answer) as they end: failure is a line of text or
        None. `kind`: "run", "probe" or "scene" of Jobs, "call" of Calls; results of runs and calls are in the
        cache. Raises Halt when no further run could do better.
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
                        self._workers.remove(busy.pop(connection))
                        yield worker.job, worker.cause_of_death(), None
                        continue
                    if event == "tick":
                        on_tick(worker.job, answer)
                        continue
                    if event == "halt":
                        raise Halt(answer)
                    self._idle.append(busy.pop(connection))
                    self.finished += event == "done" and kind in ("run", "call")
                    yield worker.job, answer if event == "failed" else None, answer
        finally:
            for worker in busy.values():
                self._workers.remove(worker)
                worker.stop()

    def _start(self):
        self._started += 1
        self._workers.append(_Process(self._folder, self._count, self._started))
        return self._workers[-1]
