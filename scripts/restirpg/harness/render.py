"""The renderer as the harness has it: what results depend on, scenes, and renderers that are kept from run to run."""

import contextlib
import functools
import importlib
import json
import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import restirpg
from restirpg.harness import Halt, UserError
from restirpg.harness.jobs import digest
from restirpg.nearest import did_you_mean

PACKAGE = Path(__file__).resolve().parents[1]
ROOT = PACKAGE.parents[1]


def find_package():
    """Raise UserError unless the renderer, the package's binding module, is there."""
    try:
        restirpg.Renderer  # noqa: B018  (asks for the binding module)
    except AttributeError as error:
        raise UserError(str(error)) from None


def native_file():
    """The file of the binding module."""
    return Path(importlib.import_module("restirpg._native").__file__)


@contextlib.contextmanager
def refusals():
    """The renderer's own errors, raised within, as UserError."""
    try:
        yield
    except restirpg.Error as error:
        raise UserError(str(error)) from None


#: Of the package, what a run's or call's result depends on.
MEASURING = (
    "colour.py", "evaluate.py", "graph.py", "harness/cell_counts.py", "harness/denoised.py", "harness/equal_time.py",
    "harness/guide_maps.py", "harness/guiding.py", "harness/measure.py", "harness/motion.py", "harness/paper/figure_4.py",
    "harness/reference.py", "harness/render.py", "harness/statistics.py", "harness/tiles.py", "records.py",
)  # fmt: skip
#: Environment variables of lavapipe that the times of frames depend on, and what each is where it is not set.
#: preferNarrowVectors() in logical_device.cpp sets the first.
OF_TIMES = {"LP_NATIVE_VECTOR_WIDTH": "128", "LP_NUM_THREADS": "", "GALLIVM_PERF": ""}
#: Environment variables that results depend on: whence shaders and passes are taken, and what slows a frame.
#: RESTIRPG_PYTHON and RESTIRPG_BUILD decide what a graph's description and the package are, which count themselves;
#: RESTIRPG_CACHE_DIR holds compiled kernels, named by their content.
VARIABLES = ("RESTIRPG_SHADERS", "RESTIRPG_PLUGIN_PATH", "RESTIRPG_VALIDATION", *OF_TIMES)
CODE = {".so", ".py", ".glsl", ".comp", ".h"}


def _code_files():
    """(name that does not depend on where the clone lies, file) of all code that results depend on."""
    paths = [native_file(), *map(Path, restirpg.code_paths())]
    for number, path in enumerate(paths):
        if path.is_file():
            yield f"{number}", path
        else:
            found = (file for file in path.rglob("*") if file.suffix in CODE and file.is_file())
            yield from ((f"{number}/{file.relative_to(path)}", file) for file in sorted(found))
    yield from ((name, PACKAGE / name) for name in MEASURING)


def times_settings():
    """((variable, value), ...) of those of OF_TIMES that are not as usual."""
    found = {name: os.environ.get(name, usual) for name, usual in OF_TIMES.items()}
    return tuple((name, value) for name, value in found.items() if value != OF_TIMES[name])


@functools.lru_cache(maxsize=1)
def _code_version(found, validation, times):
    contents = [(name, digest(Path(file).read_bytes())) for name, file, *_ in found]
    return digest(json.dumps([contents, validation, *times]).encode())


def code_version():
    """Hash of what results depend on, plugins and shaders among it: those of other code are not reused, nor those of a
    driver that was set otherwise.

    Files are read again when they have changed.
    """
    stats = ((name, file, file.stat()) for name, file in _code_files())
    found = tuple((name, str(file), stat.st_mtime_ns, stat.st_size, stat.st_ino) for name, file, stat in stats)
    return _code_version(found, os.environ.get("RESTIRPG_VALIDATION", "0") not in ("", "0"), times_settings())


def check_code(code):
    """Raise Halt unless the renderer's files are still those of that code_version()."""
    if code != code_version():
        raise Halt("the renderer's own files have changed since the start; start the same command again")


def check_denoiser():
    """Raise UserError unless pictures can be denoised."""
    if not restirpg.have_denoiser():
        raise UserError("--denoise needs the Python package pyoidn, which is not installed: pip install pyoidn")


def describe_graph(file):
    """The graph file's description as a dictionary."""
    with refusals():
        return restirpg.load_graph(file).description


def frame_port(description, output):
    """What the last frame alone gives to the graph's output: the port `frame` of the Accumulate pass whose mean the output
    is; else the output itself."""
    types = {entry["name"]: entry["type"] for entry in description.get("passes", [])}
    for entry in description.get("outputs", []):
        if entry["name"] == output and entry["output"] == "mean" and types.get(entry["pass"]) == "Accumulate":
            return f"{entry['pass']}.frame"
    return output


_loaded: dict = {}  # the scene that was loaded last: {(file, camera, environment, allow_outside): (hash, restirpg.Scene)}


def load_scene(job):
    """(hash, scene) of a Job or Call. Raises Halt when its files are not those that its `scene_hash`, if any, names."""
    place = (job.scene, job.camera, job.environment, job.allow_outside)
    if place not in _loaded or _loaded[place][0] != job.scene_hash:
        _loaded.clear()
        _loaded[place] = _load_scene(*place)
    found = _loaded[place]
    if job.scene_hash and found[0] != job.scene_hash:
        raise Halt(f"{job.scene}: the scene has changed since the start; start the same command again")
    return found


def _load_scene(file, camera, environment, allow_outside):
    def content():
        path = Path(environment or "")
        return path.read_bytes() if path.is_file() else b""

    before = content()
    scene = restirpg.load_scene(file, camera=camera, environment=environment, allow_outside=allow_outside)
    if content() != before:
        raise Halt(f"{environment}: the environment has changed while it was read; start the same command again")
    return digest(scene.hash.encode() + before), scene


#: How a command line writes that a knob is on or off, as framework/graph/knob.cpp has it.
SWITCHES = {"true": True, "1": True, "on": True, "yes": True, "false": False, "0": False, "off": False, "no": False}


def apply_knobs(renderer, knobs, graph):
    """Set the `knobs` of a Method or Job, whose graph is `graph`; raises UserError where no pass has one.

    Values are read as by `restirpg render --set`, by the type that the knob has.
    """
    for name, value in knobs:
        own = {f"{entry}.{knob}": now for entry, knobs in renderer.knobs().items() for knob, now in knobs.items()}
        meant = [knob for knob in own if knob == name or knob.endswith(f".{name}")]
        value = _of_type(own[meant[0]], value) if meant else value
        if "." in name:
            renderer.set(name, value)
        elif renderer.set_everywhere(name, value) == 0:
            names = {knob.partition(".")[2] for knob in own}
            raise UserError(f"{graph}: no pass has a knob '{name}'{did_you_mean(name, sorted(names))}")


def _of_type(now, value):
    """A knob's value as the knob's type has it, told by its value `now`; else as it is, and the renderer refuses it."""
    if isinstance(now, bool):
        return SWITCHES.get(str(value).lower(), value)
    if isinstance(now, str) and not isinstance(value, str):
        return json.dumps(value)
    return value


def make_renderer(job):
    """new_renderer() of the job's scene, or of its window onto it."""
    window = (*job.tiles[0], job.tile, job.tile) if job.windows else None
    return new_renderer(load_scene(job)[1], job, window)


def new_renderer(scene, job, window=None):
    """A job's graph and knobs on a loaded scene as a restirpg.Renderer that has not rendered yet. It has the job's
    frame_port() among its outputs. job: a Job, or what has those of its fields that are read here."""
    description = json.loads(job.description)
    alone = frame_port(description, job.output)
    renderer = restirpg.Renderer(
        scene,
        description,
        size=tuple(job.size),
        seed=job.seed,
        device=job.device,
        backend=job.backend,
        energy_compensation=job.energy_compensation,
        window=window,
        bounces=job.bounces,
        outputs=[] if alone == job.output else [alone],
    )
    apply_knobs(renderer, job.knobs, job.graph)
    if job.output not in renderer.output_names:
        raise UserError(f"{job.graph}: no output '{job.output}'; there are: {', '.join(renderer.output_names)}")
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
    with refusals():
        return np.asarray(restirpg.read_exr(file), np.float32)


def read_exr_header(file):
    """{attribute: text} of an EXR; raises UserError."""
    with refusals():
        return dict(restirpg.read_exr_attributes(file))


def write_exr(file, layers, attributes):
    """Write float arrays (H, W, 3) by layer name ("" is the plain R, G, B) with text attributes."""
    with refusals():
        restirpg.write_exr(str(file), layers, half=False, attributes=attributes)
