"""Runs of scripts/compare.py on the fake renderer, in processes of their own."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "scripts" / "compare.py"
#: The package, with the fake renderer for a binding module.
ENVIRONMENT = {**os.environ, "PYTHONPATH": f"{Path(__file__).parent / 'fake_renderer'}:{ROOT / 'scripts'}"}


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


def arguments(folder, *methods, **options):
    """A small comparison in `folder`; options by name, as frames=8, override."""
    write_graph(folder)
    (folder / "scene.gltf").touch()
    options = {
        "scenes": "scene.gltf",
        "size": "32x24",
        "frames": 8,
        "seeds": 4,
        "reference_graph": "plain.json",
        "out": "out",
        **options,
    }
    flags = []
    for name, value in options.items():
        values = value if isinstance(value, list) else [value]
        flags += [f"--{name.replace('_', '-')}", *map(str, values)]
    return [
        sys.executable,
        str(SCRIPT),
        *(methods or ["plain.json", "plain.json@noise=0.5,label=quiet"]),
        *flags,
    ]


def compare(folder, *methods, **options):
    """Run it to its end; a CompletedProcess with text output."""
    return subprocess.run(
        arguments(folder, *methods, **options), cwd=folder, env=ENVIRONMENT, capture_output=True, text=True
    )


#: A comparison of about a second, and its options.
SLOW = ["plain.json@sleep=0.02", "plain.json@noise=0.5,sleep=0.02,label=quiet"]
SLOW_OPTIONS = {"reference_frames": 64, "reference_batches": 4}


@contextlib.contextmanager
def under_way(folder, *methods, kept=8, environment=(), **options):
    """A comparison's process, when so many results are kept and its runs are being rendered. It has a group of its
    own."""
    command = arguments(folder, *methods, **{**SLOW_OPTIONS, **options})
    process = subprocess.Popen(
        command,
        cwd=folder,
        env={**ENVIRONMENT, **dict(environment)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        while len(list((folder / "out/cache").glob("*.npz"))) < kept:
            assert process.poll() is None, f"it ended too soon: {process.communicate()}"
            time.sleep(0.02)
        yield process
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def tables(folder, out="out"):
    """Everything the tables say but for wall time, which no two runs share."""
    return (folder / out / "summary.csv").read_text()
