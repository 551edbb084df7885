"""The only module that touches the renderer, package `restirpg`: everything else sees arrays."""

import functools
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from harness import UserError
from harness.jobs import digest

ROOT = Path(__file__).resolve().parents[2]


def find_package():
    """Make `restirpg` importable, its binding too: installed, on PYTHONPATH, or from the build tree."""
    try:
        import restirpg

        restirpg.Renderer
        return
    except (ImportError, AttributeError):
        pass
    build = Path(os.environ.get("RESTIRPG_BUILD", ROOT / "build")) / "python"
    if not list(build.glob("restirpg/_native*")):
        raise UserError(
            f"{build}: the Python module of the renderer is not there; "
            "build it with scripts/run, or name its build folder in RESTIRPG_BUILD"
        )
    sys.path.insert(0, str(build))
    for name in [name for name in sys.modules if name.split(".")[0] == "restirpg"]:
        del sys.modules[name]


def package_folder():
    """The folder of the package `restirpg` that find_package chose."""
    import restirpg

    return Path(restirpg.__file__).parent


def code_version():
    """Hash of the renderer's own files, plugins and shaders: results of other code are not reused."""
    package = package_folder()
    folders = [
        package,
        package.parents[1] / "lib",
        ROOT / "framework" / "shaders",
        ROOT / "passes",
        *filter(None, os.environ.get("RESTIRPG_PLUGIN_PATH", "").split(":")),
    ]
    kinds = {".so", ".py", ".glsl", ".comp", ".h"}
    files = sorted(
        {
            file.resolve()
            for folder in folders
            for file in Path(folder).rglob("*")
            if file.suffix in kinds and file.is_file()
        }
    )
    return digest(b"".join(digest(file.read_bytes()).encode() for file in files))


def describe_graph(file):
    """The graph file's description as a dictionary, without the places of its lines."""
    if file.endswith(".json"):
        try:
            description = json.loads(Path(file).read_text())
        except ValueError as error:
            raise UserError(f"{file}: not JSON: {error}") from None
    else:
        environment = {**os.environ, "PYTHONPATH": str(package_folder().parent)}
        run = subprocess.run(
            [sys.executable, "-m", "restirpg.evaluate", file], capture_output=True, text=True, env=environment
        )
        if run.returncode != 0:
            raise UserError(run.stderr.strip() or f"{file}: the graph file cannot be evaluated")
        description = json.loads(run.stdout)

    def without_places(value):
        if isinstance(value, dict):
            return {key: without_places(item) for key, item in value.items() if key not in ("file", "line")}
        return [without_places(item) for item in value] if isinstance(value, list) else value

    return without_places(description)


def is_running_mean(description, output):
    """Whether the graph's output is the mean over all frames so far, made by an Accumulate pass."""
    types = {entry["name"]: entry["type"] for entry in description.get("passes", [])}
    return any(
        types.get(entry["pass"]) == "Accumulate" and entry["output"] == "mean"
        for entry in description.get("outputs", [])
        if entry["name"] == output
    )


@functools.lru_cache(maxsize=1)
def _scene(file, camera, environment):
    import restirpg

    return restirpg.load_scene(file, camera=camera, environment=environment)


def make_renderer(job):
    """The job's scene, graph and knobs as a restirpg.Renderer that has not rendered yet."""
    import restirpg

    renderer = restirpg.Renderer(
        _scene(job.scene, job.camera, job.environment),
        restirpg.load_graph(job.graph),
        size=tuple(job.size),
        seed=job.seed,
        device=job.device,
        backend=job.backend,
    )
    if job.bounces is not None:
        renderer.set_everywhere("bounces", job.bounces)
    for name, value in job.knobs:
        if "." in name:
            renderer.set(name, value)
        elif renderer.set_everywhere(name, value) == 0:
            raise UserError(f"{job.graph}: no pass has a knob '{name}'")
    if job.output not in renderer.output_names:
        raise UserError(
            f"{job.graph}: no output '{job.output}'; there are: {', '.join(renderer.output_names)}"
        )
    return renderer


def probe(job):
    """What can be known before the first frame: every knob's value, and the device."""
    renderer = make_renderer(job)
    return {"knobs": renderer.knobs(), "device": dict(renderer.device_info)}


def run(job, reference=None, tick=lambda frames: None):
    """Render the job; `reference` is a result with `mean` and `variance`, when errors are to be measured.

    Returns arrays, one entry for each of job.frames_measured(): `frames`, `mape`, `relmse`, `rmse`, `bias`,
    `invalid`, `frame_mape` (of that frame alone, NaN where it is not known), `gpu_ms` and `wall_ms` (both
    summed since the start); `image` and `frame` (float32, H x W x 3:
    the output after the last frame, and what the last frame alone added to it); `temporal`, see TemporalSums;
    and `meta`.
    """
    import restirpg

    renderer = make_renderer(job)
    renderer.render(1)  # kernels are compiled at their first dispatch: keep that out of the times
    renderer.cut()
    running_mean = is_running_mean(json.loads(job.description), job.output)
    temporal = TemporalSums(reference["mean"] if reference else None)
    rows, wall, done, previous = [], 0.0, 0, None
    for frames in job.frames_measured():
        for _ in range(frames - done):
            start = time.perf_counter()
            renderer.render(1)
            wall += 1e3 * (time.perf_counter() - start)
            tick(1)
        image = np.asarray(renderer.output(job.output), np.float32)[..., :3] * np.float32(job.gain)
        if running_mean:  # the mean of n frames times n, less the same of n - 1 frames
            known = frames == 1 or (previous is not None and frames == done + 1)
            frame = (image if frames == 1 else image * frames - previous * (frames - 1)) if known else None
        else:
            frame = image
        if reference:
            errors = restirpg.measure_errors(image, reference["mean"])
            alone = float("nan")
            if frame is not None:
                alone = restirpg.measure_errors(frame, reference["mean"])["mape"]
            rows.append(
                [errors[name] for name in ("mape", "relmse", "rmse", "bias", "invalid")]
                + [alone, sum(renderer.total_gpu_times().values()), wall]
            )
            temporal.add(frame, consecutive=frames == done + 1)
        previous, done = image, frames
    passes, memory = renderer.total_gpu_times(), renderer.memory()
    columns = np.array(rows, float).reshape(-1, 8).T
    names = ("mape", "relmse", "rmse", "bias", "invalid", "frame_mape", "gpu_ms", "wall_ms")
    return {
        "frames": np.array(job.frames_measured()),
        **dict(zip(names, columns)),
        "image": image,
        "frame": image if frame is None else frame,
        "temporal": temporal.sums,
        "meta": {
            "passes": {name: ms / done for name, ms in passes.items()},
            "memory": dict(memory),
            "device": dict(renderer.device_info),
            "knobs": renderer.knobs(),
            "running_mean": running_mean,
            "wall_ms": wall,
            "invalid": int(np.sum(~np.isfinite(image).all(axis=-1))),
            "dropped": dropped_samples(renderer),
        },
    }


def dropped_samples(renderer):
    """How many NaN or infinite samples the graph's output "invalid" says were dropped; 0 without it."""
    return int(np.sum(renderer.output("invalid"))) if "invalid" in renderer.output_names else 0


class TemporalSums:
    """Sums for the autocorrelation at lag 1 of a pixel's single frames, as deviations from the reference.

    `sums` = [sum of e_t e_(t+1), its number of terms, sum of e_t^2, its number of terms], over pixels,
    luminance.
    """

    WEIGHTS = np.array([0.2126, 0.7152, 0.0722], np.float32)

    def __init__(self, reference):
        self._reference = reference
        self._previous = None
        self.sums = np.zeros(4)

    def add(self, frame, consecutive):
        """Add a frame, or None where it is not known; `consecutive`: it follows the one added last."""
        if frame is None or self._reference is None:
            self._previous = None
            return
        deviation = ((frame - self._reference) @ self.WEIGHTS).astype(float)
        deviation[~np.isfinite(deviation)] = 0
        if consecutive and self._previous is not None:
            self.sums[:2] += np.sum(deviation * self._previous), deviation.size
        self.sums[2:] += np.sum(deviation**2), deviation.size
        self._previous = deviation


def read_exr(file):
    """An EXR's R, G, B as float32 (H, W, 3); raises UserError."""
    import restirpg

    try:
        return np.asarray(restirpg.read_exr(file), np.float32)
    except restirpg.Error as error:
        raise UserError(str(error)) from None


def write_exr(file, layers, attributes):
    """Write float arrays (H, W, 3) by layer name ("" is the plain R, G, B) with text attributes."""
    import restirpg

    restirpg.write_exr(str(file), layers, half=False, attributes=attributes)
