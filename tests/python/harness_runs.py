"""Runs of scripts/compare.py on the fake renderer, in processes of their own."""

import contextlib
import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: The package, with the fake renderer for a binding module.
ENVIRONMENT = {**os.environ, "PYTHONPATH": f"{Path(__file__).parent / 'fake_renderer'}:{ROOT / 'scripts'}"}

#: The program as it is.
SCRIPT = [sys.executable, str(ROOT / "scripts" / "compare.py")]


def changed(lines=""):
    """The program after these lines of Python, and without charts, which take a second to draw and are seldom read."""
    return [
        sys.executable,
        "-c",
        f"""
import sys, types
from restirpg import commands
nothing = lambda *_: []
sys.modules["restirpg.harness.plots"] = types.SimpleNamespace(charts=nothing, bars=nothing, colour_map=nothing)
{lines}
sys.exit(commands.compare())
""",
    ]


def write_graph(folder, name="plain", **knobs):
    """A graph file of the fake renderer; returns its name, relative to `folder`."""
    history = {"pass": "accumulate", "output": "sums", "delayed": True}
    passes = [
        {"name": "paths", "type": "Fake", "inputs": {}, "knobs": knobs},
        {
            "name": "accumulate",
            "type": "Accumulate",
            "knobs": {},
            "inputs": {"direct": {"pass": "paths", "output": "radiance"}, "history": history},
        },
    ]
    outputs = [{"name": "image", "pass": "accumulate", "output": "mean"}]
    (folder / f"{name}.json").write_text(json.dumps({"name": name, "passes": passes, "outputs": outputs}))
    return f"{name}.json"


def arguments(folder, *methods, program=None, **options):
    """A small comparison in `folder`, by SCRIPT or what `changed` returns; options by name, as frames=8, override."""
    write_graph(folder)
    (folder / "scene.gltf").touch()
    options = {
        "scenes": "scene.gltf",
        "size": "32x24",
        **({} if "at" in options else {"frames": 8}),
        "seeds": 4,
        **({} if "reference" in options else {"reference_graph": "plain.json"}),
        "out": "out",
        **options,
    }
    flags = []
    for name, value in options.items():
        values = value if isinstance(value, list) else [value]
        flags += [f"--{name.replace('_', '-')}", *map(str, values)]
    return [
        *(program or changed()),
        *(methods or ["plain.json", "plain.json@noise=0.5,label=quiet"]),
        *flags,
    ]


def compare(folder, *methods, **options):
    """Run it to its end; a CompletedProcess with text output."""
    return subprocess.run(
        arguments(folder, *methods, **options), cwd=folder, env=ENVIRONMENT, capture_output=True, text=True
    )


#: A comparison whose runs last over a second in all, and its options.
SLOW = ["plain.json@sleep=0.02", "plain.json@noise=0.5,sleep=0.02,label=quiet"]
SLOW_OPTIONS = {"reference_frames": 64, "reference_batches": 4}
LONGEST_START = 120  # s, until the first results are kept


@contextlib.contextmanager
def under_way(folder, *methods, kept=8, environment=(), **options):
    """A comparison of methods with the knob `sleep`: its process, when so many results are kept (the probes and the
    reference, 8 of SLOW) and its runs are being rendered, and what lets them go on: until it is called, they wait. The
    process has a group of its own."""
    hold = folder / "hold"
    hold.touch()
    process = subprocess.Popen(
        arguments(folder, *methods, **{**SLOW_OPTIONS, **options}),
        cwd=folder,
        env={**ENVIRONMENT, "FAKE_RENDERER_HOLD": str(hold), **dict(environment)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        deadline = time.monotonic() + LONGEST_START
        while (count := len(list((folder / "out/cache").glob("*.npz")))) < kept:
            assert process.poll() is None, f"it ended too soon: {process.communicate()}"
            assert time.monotonic() < deadline, f"{count} results are kept after {LONGEST_START} s"
            time.sleep(0.02)
        yield process, hold.unlink
    finally:
        hold.unlink(missing_ok=True)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def csv_rows(file):
    """A CSV file's rows: {column: text}."""
    with open(file, newline="") as stream:
        return list(csv.DictReader(stream))


def by_method(file):
    """A CSV file's rows by method."""
    return {row["method"]: row for row in csv_rows(file)}


def tables(folder, out="out"):
    """Everything the tables say but for wall time, which no two runs share."""
    return (folder / out / "summary.csv").read_text()
