"""Runs of scripts/compare.py on the fake renderer, in processes of their own."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "scripts" / "compare.py"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(__file__).parent / "fake_renderer")}
sys.path.insert(0, str(ROOT / "scripts"))


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


def tables(folder, out="out"):
    """Everything the tables say but for wall time, which no two runs share."""
    return (folder / out / "summary.csv").read_text()
