"""Stands in for the renderer in tests of the harness: noise of known mean, variance and correlation.

A scene is a file; a graph is JSON whose pass "paths" has the knobs of DEFAULTS. Times are made up and
depend on nothing but knobs, so that whole tables can be compared. Runs with the knob `sleep` wait before each frame as
long as there is the file that FAKE_RENDERER_HOLD names.
"""

import hashlib
import json
import os
import signal
import time
from pathlib import Path

import numpy as np

COMMIT = "unknown"

DEFAULTS = {
    "bounces": 4,
    "noise": 1.0,  # standard deviation of a pixel's single frame over its mean
    "gain": 1.0,  # of the mean: an error of energy
    "blotch": 0,  # > 0: noise is shared by blocks of this many pixels
    "memory": 0.0,  # autocorrelation of a pixel's frames at lag 1
    "ms": 2.0,  # per frame
    "neighbours": 0,  # each takes 0.5 ms more and takes a tenth off the noise
    "sleep": 0.0,  # seconds a frame really takes
    "broken": 0,  # pixels of the picture that are NaN
    "crash_seed": -1,  # the run with this seed ends the process
    "fail_seed": -1,  # the run with this seed raises
}

MOST_NEIGHBOURS = 8


class Error(Exception):
    """As restirpg.Error."""


class _Graph:
    def __init__(self, description):
        self.description = description


class _Scene:
    bounce_cap = None

    def __init__(self, text, environment):
        self.hash = hashlib.sha256(text.encode()).hexdigest()
        self.environment_hash = hashlib.sha256(environment).hexdigest() if environment else ""
        self.animation_keys = json.loads(text) if text else []


def load_scene(file, camera=0, environment=None, allow_outside=False):
    """A scene is an empty file, or JSON of its animation keys."""
    if "broken" in Path(file).name:
        raise Error(f"{file}: not a scene")
    if "outside" in Path(file).name and not allow_outside:
        raise Error(f"{file}: buffers[0] lies outside of the scene's folder")
    sky = Path(environment or "")
    return _Scene(Path(file).read_text(), sky.read_bytes() if sky.is_file() else b"")


def load_graph(file):
    """A JSON graph."""
    try:
        return _Graph(json.loads(Path(file).read_text()))
    except (ValueError, RecursionError) as error:
        raise Error(f"{file}: not JSON: {error}") from None


def describe_pass(type):
    """The knob whose range is asked for."""
    return {"knobs": [{"name": "neighbours", "type": "uint", "minimum": 0, "maximum": MOST_NEIGHBOURS}]}


def code_paths():
    """None but the package itself, and what RESTIRPG_SHADERS names."""
    return list(filter(None, [os.environ.get("RESTIRPG_SHADERS")]))


def truth(width, height, seconds=0.0, aside=0.0):
    """The picture that every unbiased run converges to; `aside`: of the camera, to its right."""
    y, x = np.mgrid[0:height, 0:width]
    pattern = np.sin(x / 5 + aside)[..., None] * np.cos(y / 7)[..., None]
    return (0.2 + 0.1 * pattern) * np.array([1.0, 0.8, 0.6]) * (1 + seconds)


class Renderer:
    """As restirpg.Renderer, as far as the harness uses it."""

    output_names = ["image"]
    camera = {"position": (0.0, 0.0, 0.0), "target": (0.0, 0.0, -1.0), "up": (0.0, 1.0, 0.0)}
    device_info = {"name": "fake device", "driver": "1", "backend": "none"}

    def __init__(
        self,
        scene,
        graph,
        size,
        seed=0,
        device=None,
        backend=None,
        energy_compensation=False,
        window=None,
        bounces=None,
        outputs=(),
    ):
        self._size, self.seed, self._seconds = size, seed, 0.0
        self._window = window or (0, 0, *size)
        self._knobs = {"paths": dict(DEFAULTS)}
        for entry in graph["passes"]:
            self._knobs.setdefault(entry["name"], {}).update(entry.get("knobs", {}))
        if bounces is not None:
            self.set_everywhere("bounces", bounces)
        self.cut()

    def move_window(self, x, y):
        """To that corner."""
        self._window = (x, y, *self._window[2:])
        self.cut()

    def cut(self):
        """Forget all frames."""
        self._frames, self._sum, self._noise = 0, 0.0, 0.0
        self._random = np.random.default_rng(self.seed)

    def set_time(self, seconds):
        """Of the next frame: all lights grow with it."""
        self._seconds = seconds

    def move_camera(self, position, target):
        """From the next frame on."""
        self.camera = {**self.camera, "position": position, "target": target}

    def knobs(self):
        """Every knob's value."""
        return self._knobs

    def set(self, path, value):
        """Set "pass.knob"."""
        name, knob = path.split(".")
        if knob not in self._knobs.get(name, {}):
            raise Error(f"no knob '{path}'")
        if isinstance(self._knobs[name][knob], int) and not isinstance(value, int):
            raise Error(f"knob '{path}' must be a whole number, not {value}")
        self._knobs[name][knob] = value

    def set_everywhere(self, knob, value):
        """How many passes have the knob."""
        having = [knobs for knobs in self._knobs.values() if knob in knobs]
        for knobs in having:
            knobs[knob] = value
        return len(having)

    def render(self, count):
        """Add `count` frames."""
        knobs = self._knobs["paths"]
        width, height = self._size
        if self.seed == knobs["fail_seed"]:
            raise Error("the device was lost")
        if self.seed == knobs["crash_seed"] and self._frames > 1:
            os.kill(os.getpid(), signal.SIGSEGV)
        hold = os.environ.get("FAKE_RENDERER_HOLD", "") if knobs["sleep"] else ""
        for _ in range(count):
            while os.path.exists(hold):
                time.sleep(0.01)
            time.sleep(knobs["sleep"])
            size = knobs["blotch"] or 1
            fresh = self._random.gamma(1, 1, (-(-height // size), -(-width // size), 1)) - 1
            fresh = fresh.repeat(size, axis=0).repeat(size, axis=1)[:height, :width] * knobs["noise"]
            fresh = fresh * 0.9 ** knobs["neighbours"]
            old = knobs["memory"] if self._frames else 0.0
            self._noise = old * self._noise + np.sqrt(1 - old**2) * fresh
            light = truth(width, height, self._seconds, self.camera["position"][0])
            self._last = light * knobs["gain"] * (1 + self._noise)
            self._sum = self._sum + self._last
            self._frames += 1

    def output(self, name):
        """The mean of all frames, or the last frame."""
        image = (self._last if name == "accumulate.frame" else self._sum / self._frames).astype(np.float32)
        image[0, : self._knobs["paths"]["broken"]] = np.nan
        x, y, width, height = self._window
        return image[y : y + height, x : x + width]

    def total_gpu_times(self):
        """Summed since the last cut."""
        knobs = self._knobs["paths"]
        return {"gbuffer": 0.25 * self._frames, "paths": (knobs["ms"] + 0.5 * knobs["neighbours"]) * self._frames}

    def memory(self):
        """Bytes by resource."""
        return {"scene": 1 << 20, "accumulate.sums": 16 * self._size[0] * self._size[1]}


def measure_errors(image, reference):
    """As restirpg.measure_errors."""
    valid = np.isfinite(image).all(axis=-1)
    image, reference = image[valid].astype(float), reference[valid].astype(float)
    y = reference @ np.array([0.2126, 0.7152, 0.0722])
    difference = image - reference
    return {
        "mape": np.mean(np.abs(difference) / (0.01 * y.mean() + y)[..., None]),
        "relmse": np.mean(difference**2 / (reference**2 + 0.01)),
        "rmse": np.sqrt(np.mean(difference**2)),
        "bias": (image.mean() - reference.mean()) / reference.mean(),
        "invalid": int(np.sum(~valid)),
    }


def read_exr(file):
    """What write_exr wrote."""
    try:
        with open(file, "rb") as stream:
            return np.load(stream)[..., :3]
    except (OSError, ValueError) as error:
        raise Error(f"{file}: cannot be read: {error}") from None


def read_exr_attributes(file):
    """What write_exr was given; none of a plain .npy file."""
    read_exr(file)
    with open(file, "rb") as stream:
        np.load(stream)
        return json.loads(stream.read() or "{}")


def write_exr(file, layers, half=False, attributes=None):
    """The first layer as .npy, whatever the name says, and the attributes after it."""
    with open(file, "wb") as stream:
        np.save(stream, next(iter(layers.values())))
        stream.write(json.dumps(attributes or {}).encode())
