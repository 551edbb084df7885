"""The only module that touches the renderer, package `restirpg`: everything else sees arrays."""

import contextlib
import functools
import json
import os
import subprocess
import sys
from dataclasses import dataclass, replace
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


@contextlib.contextmanager
def refusals():
    """The renderer's own errors, raised within, as UserError."""
    import restirpg

    try:
        yield
    except restirpg.Error as error:
        raise UserError(str(error)) from None


def package_folder():
    """The folder of the package `restirpg` that find_package chose."""
    import restirpg

    return Path(restirpg.__file__).parent


#: Of the harness, what a run's or call's result depends on.
MEASURING = ("cell_counts.py", "guide_maps.py", "guiding.py", "measure.py", "motion.py", "render.py")


def code_version():
    """Hash of what results depend on, plugins and shaders among it: those of other code are not reused."""
    package = package_folder()
    folders = [
        package,
        package.parents[1] / "lib",
        ROOT / "framework" / "shaders",
        ROOT / "passes",
        *filter(None, os.environ.get("RESTIRPG_PLUGIN_PATH", "").split(":")),
    ]
    kinds = {".so", ".py", ".glsl", ".comp", ".h"}
    files = {
        file.resolve()
        for folder in folders
        for file in Path(folder).rglob("*")
        if file.suffix in kinds and file.is_file()
    } | {Path(__file__).with_name(name) for name in MEASURING}
    return digest("".join(sorted(digest(file.read_bytes()) for file in files)).encode())


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
def _scene(file, scene_hash, camera, environment):
    """The loaded scene; `scene_hash` tells a file that has changed since."""
    import restirpg

    return restirpg.load_scene(file, camera=camera, environment=environment)


def make_renderer(job):
    """The job's scene, graph and knobs as a restirpg.Renderer that has not rendered yet."""
    import restirpg

    renderer = restirpg.Renderer(
        _scene(job.scene, job.scene_hash, job.camera, job.environment),
        restirpg.load_graph(job.graph),
        size=tuple(job.size),
        seed=job.seed,
        device=job.device,
        backend=job.backend,
        energy_compensation=job.energy_compensation,
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


@dataclass
class _Kept:
    renderer: object
    home: dict  # the scene's own camera
    warm: bool = False


#: Bytes of host memory that a renderer's compiled kernels take, about: on lavapipe (Mesa 25) eight renderers
#: of graphs/restir_pg.py at 96x54 took 212 MB each, of which memory() knew 59.
KERNELS = 150 << 20
#: Bytes of the renderers that a worker keeps, at most.
LIMIT = 4 << 30


def size_of(renderer):
    """Bytes that a renderer takes, about: its resources, its scene and its kernels."""
    return sum(renderer.memory().values()) + KERNELS


class Renderers:
    """Renderers kept from run to run: to make one takes as long as a dozen small frames.

    A run on a kept renderer has the bytes of one on a new renderer, for begin() starts both by seed and cut.
    Before either there is one frame that counts in no time: it refills the caches that another method's run
    has emptied. A new renderer has two more, since kernels are compiled at their first dispatch, and the
    memory of the history is first touched in the second frame.
    """

    def __init__(self, limit=None):
        """limit: bytes of all but the renderer in use, scenes and kernels included.

        By default LIMIT, or a quarter of the machine's memory where that is less; of several workers each has
        its own.
        """
        if limit is None:
            limit = min(LIMIT, os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 4)
        self._limit = limit
        self._kept = {}  # key of all that runs of a renderer share -> _Kept, the last used last

    def begin(self, job):
        """The job's renderer at the start of a run, and the scene's own camera."""
        kept = self._of(job)
        renderer = kept.renderer
        if not kept.warm:
            renderer.render(2)
            kept.warm = True
        renderer.seed = job.seed
        if job.motion:
            job.motion.apply(renderer, kept.home, job.still or 1)
        renderer.cut()
        renderer.render(1)
        renderer.cut()
        return renderer, kept.home

    def probe(self, job):
        """What can be known before the first frame: every knob's value, and the device."""
        renderer = self._of(job).renderer
        return {"knobs": renderer.knobs(), "device": dict(renderer.device_info)}

    def _of(self, job):
        key = replace(job, seed=0, frames=0, reference=None, references=(), at=(), still=0, gain=1.0).key
        kept = self._kept.pop(key, None)
        if kept is None:
            renderer = make_renderer(job)
            self._make_room(size_of(renderer))
            kept = _Kept(renderer, renderer.camera)
        self._kept[key] = kept
        return kept

    def forget(self):
        """Drop them all, as after a failure that may have left one of them or its device unusable."""
        self._kept.clear()

    def _make_room(self, needed):
        """Drop those that were not used for longest until there is room for so many bytes."""
        sizes = {key: size_of(kept.renderer) for key, kept in self._kept.items()}
        for key in list(self._kept):
            if sum(sizes.values()) + needed > self._limit:
                del self._kept[key], sizes[key]


def dropped_samples(renderer):
    """How many NaN or infinite samples the graph's output "invalid" says were dropped; 0 without it."""
    return int(np.sum(renderer.output("invalid"))) if "invalid" in renderer.output_names else 0


def read_exr(file):
    """An EXR's R, G, B as float32 (H, W, 3); raises UserError."""
    import restirpg

    with refusals():
        return np.asarray(restirpg.read_exr(file), np.float32)


def write_exr(file, layers, attributes):
    """Write float arrays (H, W, 3) by layer name ("" is the plain R, G, B) with text attributes."""
    import restirpg

    restirpg.write_exr(str(file), layers, half=False, attributes=attributes)
