"""The files of ../shared/inputs, each with the value that a correct renderer gives (shared_inputs.csv), and how one is
measured.

Columns: `input`, a file; `options`, what differs from 64 frames of path_tracer.py at 16 x 16 (NAME=VALUE each: graph,
frames, time, made_at: the time the renderer is made at, scene: what the input, an environment, is put into,
allow_outside, to: what a ratio refers to); `quantity`; the `expected` value, within `tolerance`; `source`, where the
value comes from; `was`, what commit aa3076d gave; `open`, what is still missing where a row is known to be wrong.

Quantities: `mean` of the red channel; `centre`, that of the 4 x 4 pixels in the middle; `finite`, samples that are
numbers all, which the other quantities ask for, too; `ratio`, of the mean to that of the file `to` with the same random
numbers; `variance`, of single frames' pixels, over that of the file `to`, at most `tolerance`; `refused`, one line that
holds the expected words. `mean|refused` and `finite|refused` leave the choice.
"""

import csv
import functools
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from renderer_scenes import ROOT, restirpg

from restirpg.harness.cache import Cache
from restirpg.harness.render import native_file

PROGRAM = native_file().parents[2] / "bin" / "restirpg"
VARIANCE_RUNS = 24
LARGEST_MEMORY = 2 << 30  # bytes, of a hostile file
LONGEST = 600  # s: what takes longer has hung; kernels are compiled within it where no cache has them


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    input: str
    options: dict
    quantity: str
    expected: str
    tolerance: str
    source: str
    was: str
    open: str = ""

    @property
    def name(self):
        """The input and what differs."""
        return " ".join([self.input, *(f"{name}={value}" for name, value in self.options.items())])


class Refused(str):
    """What a refusal said."""


class Fault(str):
    """What went wrong where neither a picture nor a refusal came."""


def shared_folder():
    """../shared, or what RESTIRPG_SHARED names; None where it is not."""
    folder = Path(os.environ.get("RESTIRPG_SHARED", ROOT.parent / "shared"))
    return folder if (folder / "inputs").is_dir() else None


def rows():
    """The table."""
    with Path(__file__).with_name("shared_inputs.csv").open(newline="", encoding="utf-8") as file:
        return [
            Row(**{**line, "options": dict(part.split("=", 1) for part in line["options"].split())})
            for line in csv.DictReader(file)
        ]


def open_renderer(row, file):
    """A renderer of the file as the row asks for it, at the row's time."""
    inputs = shared_folder() / "inputs"
    scene = row.options.get("scene")
    outside = {"allow_outside": True} if "allow_outside" in row.options else {}
    loaded = restirpg.load_scene(inputs / (scene or file), environment=str(inputs / file) if scene else None, **outside)
    graph = restirpg.load_graph(ROOT / "graphs" / row.options.get("graph", "path_tracer.py"))
    time = float(row.options.get("time", 0))
    made_at = float(row.options.get("made_at", time))
    renderer = restirpg.Renderer(loaded, graph, size=(16, 16), seed=1, time=made_at, validation=True)
    if made_at != time:
        renderer.render(1)
        renderer.set_time(time)
        renderer.render(1)  # what has moved stands still from here on
        renderer.cut()
    return renderer


@functools.lru_cache
def compared_with(function, file, graph):
    """What an input that others are compared with gives, without settings but the graph."""
    return function(Row(file, {"graph": graph}, "", "", "", "", ""), file)


def mean(row, file):
    """Mean of the red channel, or of the middle alone."""
    renderer = open_renderer(row, file)
    renderer.render(int(row.options.get("frames", 64)))
    if renderer.output("invalid").any():
        return float("nan")  # as the mean would be, had Accumulate not left them out
    image = renderer.output("image")[..., 0].astype(float)
    return float((image[6:10, 6:10] if row.quantity == "centre" else image).mean())


def variance(row, file):
    """Mean over the pixels of the variance of single frames."""
    renderer, frames = open_renderer(row, file), []
    for seed in range(VARIANCE_RUNS):
        renderer.seed = seed
        renderer.cut()
        renderer.render(1)
        if renderer.output("invalid").any():
            return float("nan")
        frames.append(renderer.output("image")[..., 0])
    return float(np.var(frames, axis=0, ddof=1, dtype=float).mean())


def measure_picture(row):
    """The row's quantity, or Refused."""
    function = variance if row.quantity == "variance" else mean
    try:
        value = function(row, row.input)
        if "to" in row.options:
            value /= compared_with(function, row.options["to"], row.options.get("graph", "path_tracer.py"))
        return value
    except restirpg.Error as error:
        return Refused(error)


WATCH = """
import resource, subprocess, sys
code = subprocess.run(sys.argv[2:], stdout=subprocess.DEVNULL, timeout=float(sys.argv[1])).returncode
print(code, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def watched(command):
    """Run a command: its exit code, what it wrote on standard error and its largest memory, bytes. Ended after LONGEST.

    A small process of its own starts it: the kernel counts the memory of the process that starts a program as the
    program's, and the process of the tests may be large.
    """
    process = subprocess.run(
        [sys.executable, "-I", "-S", "-c", WATCH, str(LONGEST), *map(str, command)], capture_output=True
    )
    errors = process.stderr.decode("utf-8", "backslashreplace")
    if process.returncode != 0:
        return -1, f"still running after {LONGEST} s", 0
    code, kilobytes = map(int, process.stdout.split())
    return code, errors, kilobytes * 1024


def measure_program(row):
    """The same of a file that may crash, hang or swell its reader: by the program, which is watched."""
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "picture.exr"
        code, errors, memory = watched(
            [
                PROGRAM,
                "render",
                ROOT / "graphs" / "path_tracer.py",
                "--scene",
                shared_folder() / "inputs" / row.input,
                "--size",
                "16x16",
                "--frames",
                "8",
                "-o",
                picture,
            ]
        )
        said = [line for line in errors.removesuffix("\n").split("\n") if not line.startswith("warning: ")]
        if memory > LARGEST_MEMORY:
            return Fault(f"{memory >> 20} MB of memory")
        if code == 2 and len(said) == 1 and not picture.exists():
            return Refused(said[0])
        if code != 0:
            return Fault(f"exit code {code}: {' / '.join(said)[:200]}")
        if restirpg.read_exr(picture, "invalid").any():
            return float("nan")
        return float(restirpg.read_exr(picture)[..., 0].astype(float).mean())


def time_that_is_no_number():
    """hostile/anim_nan.py: a time or a rate that is no number must be refused."""
    scene = restirpg.load_scene(shared_folder() / "gltf-samples" / "BoxAnimated.glb")
    graph = restirpg.load_graph(ROOT / "graphs" / "path_tracer.py")
    renderer = restirpg.Renderer(scene, graph, size=(8, 8))
    answers = []
    for refuse in (
        lambda: renderer.set_time(float("nan")),
        lambda: restirpg.Renderer(scene, graph, size=(8, 8), fps=float("nan")),
    ):
        try:
            refuse()
            return Fault("accepted")
        except restirpg.Error as error:
            answers.append(str(error))
    return Refused(answers[0])


def damaged_run():
    """hostile/cache_exc0.npz: a damaged file among the finished runs counts as none."""
    with tempfile.TemporaryDirectory() as folder:
        cache = Cache(folder)
        shutil.copy(shared_folder() / "inputs" / "hostile" / "cache_exc0.npz", cache.folder / "damaged.npz")
        try:
            return Refused("read as no run") if cache.load("damaged") is None else Fault("accepted")
        except Exception as error:
            return Fault(f"{type(error).__name__}: {error}")


SPECIAL = {"hostile/anim_nan.py": time_that_is_no_number, "hostile/cache_exc0.npz": damaged_run}


def measure(row):
    """What the renderer gives for a row: a number, Refused or Fault."""
    if row.input in SPECIAL:
        return SPECIAL[row.input]()
    return measure_program(row) if row.input.startswith("hostile/") else measure_picture(row)


def is_right(row, value):
    """Does the value meet the row's expectation?"""
    if isinstance(value, Fault):
        return False
    if isinstance(value, Refused):
        words = row.expected if row.quantity == "refused" else Path(row.input).name
        return "refused" in row.quantity and words in value and value.isprintable()
    if row.quantity == "refused":
        return False
    if row.quantity == "variance":
        return value <= float(row.tolerance)
    if row.quantity.startswith("finite"):
        return bool(np.isfinite(value))
    return bool(abs(value - float(row.expected)) <= float(row.tolerance))
