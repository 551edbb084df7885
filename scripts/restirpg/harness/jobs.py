"""What is rendered: methods, jobs named by a hash of their content, and the folder that keeps finished
jobs."""

import functools
import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path

import numpy as np

from restirpg.harness import UserError
from restirpg.harness.motion import Motion

EVERY_FRAME_UP_TO = 256  # longer runs are measured at a geometric sequence of frames ...
LAST_FRAMES = 32  # ... and at this many last ones, one after the other, for the temporal statistics
LATER_FIELDS = (
    "motion",
    "still",
    "at",
    "references",
    "energy_compensation",
    "tiles",
    "tile",
    "windows",
)  # of a Job; see Job.key


def made_from(kind, source, **changes):
    """A dataclass of that kind: `changes`, and whatever else `source` calls as `kind` does."""
    names = {each.name for each in fields(kind) if hasattr(source, each.name)} - changes.keys()
    return kind(**{name: getattr(source, name) for name in names}, **changes)


@dataclass(frozen=True)
class Method:
    """A graph file with its settings: one column of the comparison."""

    label: str
    graph: str  # file
    knobs: tuple = ()  # ((name, value), ...); a name without a dot is set on every pass that has it
    output: str = "image"
    device: str | None = None
    backend: str | None = None


def parse_method(text, useless=()):
    """Read `GRAPH[@SETTING=VALUE,...]`; settings are knobs, or label, output, device and backend. useless: those that the
    program would ignore."""
    graph, _, settings = text.partition("@")
    if not Path(graph).is_file():
        raise UserError(f"{graph}: no such graph file")
    special, knobs = {}, []
    for setting in filter(None, settings.split(",")):
        name, equals, value = setting.partition("=")
        if not equals or not name:
            raise UserError(f"{text}: '{setting}' is not NAME=VALUE, as in {graph}@paths.bounces=4,label=short")
        if name in useless:
            raise UserError(f"{text}: '{name}' changes nothing here; leave it out")
        if name in ("label", "output", "device", "backend"):
            special[name] = value
        else:
            knobs.append((name, knob_value(value)))
    default = " ".join([Path(graph).stem, *(part for part in settings.split(",") if not part.startswith("label="))])
    method = Method(**{"label": default.strip(), **special}, graph=graph, knobs=tuple(knobs))
    if not (method.label.isprintable() and 0 < len(method.label) <= 100):
        raise UserError(f"{text}: a method is called by 1 to 100 printable characters; give it another @label=NAME")
    return method


def parse_methods(texts, useless=()):
    """The Methods of several texts; raises UserError where two have one label, by which rows are told apart."""
    methods = [parse_method(text, useless) for text in texts]
    labels = [method.label for method in methods]
    for label in labels:
        if labels.count(label) > 1:
            raise UserError(f"two methods are called '{label}'; tell them apart with @label=NAME")
    return methods


def file_name(label):
    """A label as part of a file's name."""
    return "".join(letter if letter.isalnum() or letter in "-_." else "_" for letter in label)


def knob_value(text):
    """The value of a knob written on a command line: a JSON number or boolean, else the text itself. The knob's type
    decides what that means, see render.apply_knobs()."""
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return text
    return value if isinstance(value, (bool, int, float)) else text


@dataclass(frozen=True)
class Job:
    """One run of one method on one scene with one seed: everything that its result depends on."""

    scene: str  # file
    scene_hash: str
    graph: str  # file that was evaluated; a run reads the description alone
    description: str  # the graph as canonical JSON
    size: tuple  # width, height
    frames: int
    seed: int
    code: str  # hash of the renderer's own files
    knobs: tuple = ()
    bounces: int | None = None
    output: str = "image"
    device: str | None = None
    backend: str | None = None
    environment: str | None = None
    allow_outside: bool = False  # the scene may read files that lie outside of its own folder
    camera: int = 0
    reference: str | None = None  # key of the reference the errors are measured against; None: measure none
    gain: float = 1.0  # the picture is scaled by it: the self-test's known error of energy
    motion: Motion | None = None
    still: int = 0  # the frame of `motion` whose view and time all frames have; 0: each has its own
    at: tuple = ()  # ascending frames whose own picture is measured, not the mean of all; (): the output is
    references: tuple = ()  # key of the reference of each frame of `at`
    energy_compensation: bool = False  # of the material model
    tiles: tuple = ()  # corners (x, y) of the tiles that are measured, see tiles.py; (): the whole picture is
    tile: int = 0  # their side, pixels
    windows: bool = False  # the tiles alone are rendered, each for all frames
    label: str = field(default="", compare=False)  # for messages

    @property
    def key(self):
        """32 hexadecimal digits of the job's content, and of which frames are measured; file names, places and labels
        are not part of it.

        Nor are LATER_FIELDS that are not used: results from before they could be asked for stay valid.
        """
        content = {
            name: value
            for name, value in asdict(self).items()
            if name not in ("scene", "graph", "label", "allow_outside") and (name not in LATER_FIELDS or value)
        }
        content["description"] = without_places(self.description)
        if self.reference is not None:  # else `frames` and `at` say them
            content["measured"] = self.frames_measured()
        return digest(json.dumps(content, sort_keys=True).encode())

    def frames_measured(self):
        """The frame counts (1-based, ascending) after which the picture is measured."""
        if self.at:
            return list(self.at)
        if self.reference is None:
            return [self.frames]
        if self.frames <= EVERY_FRAME_UP_TO:
            return list(range(1, self.frames + 1))
        spread = np.unique(np.geomspace(1, self.frames, 64).astype(int)).tolist()
        return sorted({*spread, *range(self.frames - LAST_FRAMES + 1, self.frames + 1)})

    def reference_of(self, frame):
        """The key of the reference that the measured frame has, or None."""
        return self.references[self.at.index(frame)] if self.at else self.reference


@dataclass(frozen=True)
class Call:
    """A measurement that is no run of a method: function(scene, **settings) in a worker, with the loaded scene.

    Its result, arrays and a JSON-able `meta`, is kept as a run's is. The function's file is one of render.MEASURING.
    """

    function: Callable  # of a module, so that any worker can import it
    scene: str  # file
    scene_hash: str
    settings: tuple  # ((name, value), ...): whatever else the result depends on
    code: str  # hash of the renderer's own files
    allow_outside: bool = False  # the scene may read files that lie outside of its own folder
    label: str = field(default="", compare=False)  # for messages
    camera: int = 0
    environment: str | None = None  # in place of the scene's; scene_hash has the content of a file alone

    @property
    def key(self):
        """32 hexadecimal digits of the call's content."""
        function = f"{self.function.__module__}.{self.function.__qualname__}"
        content = [function, self.scene_hash, self.settings, self.code, *filter(None, [self.camera, self.environment])]
        return digest(json.dumps(content).encode())


@functools.lru_cache(maxsize=256)
def without_places(description):
    """A graph's description, as JSON, without the files and lines that wrote it."""

    def strip(value):
        if isinstance(value, dict):
            return {key: strip(item) for key, item in value.items() if key not in ("file", "line")}
        return [strip(item) for item in value] if isinstance(value, list) else value

    return json.dumps(strip(json.loads(description)), sort_keys=True)


def seed_of(*parts):
    """A 31-bit seed hashed from `parts`: consecutive seeds of some generators give shifted streams."""
    return int(digest(json.dumps(parts).encode())[:8], 16) >> 1


def digest(data):
    """The first 32 hexadecimal digits of the SHA-256 of bytes."""
    return hashlib.sha256(data).hexdigest()[:32]
