"""What is looked at and how: the state behind the page, without a network. One thread uses it.

apply() takes the page's messages, {"do": name, arguments}; render() makes the next frame of every graph; frame() gives
what is to be shown of it.
"""

import shlex
import time
from dataclasses import dataclass, field

import numpy as np

import restirpg
from restirpg.colour import relative_error
from restirpg.harness import UserError

from . import camera, commands, graphs, pictures
from .inspector import Inspector
from .pane import Pane
from .reference import Reference

MOST_FRAMES = 1 << 16  # of a picture that rests: rendering stops there


@dataclass
class Frame:
    """What the page shows: numbers, and the bytes of one JPEG a picture."""

    header: dict
    images: list = field(default_factory=list)


class Session:
    """One scene, one camera, and up to a few graphs that render it in step."""

    def __init__(
        self,
        scene,
        sources,
        size,
        reference=None,
        captures=None,
        allow_outside=False,
        reference_mean_of=None,
        **options,
    ):
        """sources: graph files, restirpg.Graph or descriptions. reference: an image (H, W, 3) of the scene's own
        camera; reference_mean_of: see Reference. captures: the folder where films are put. allow_outside: with which the
        scene was loaded."""
        self.scene, self.size, self.captures, self.options = scene, tuple(size), captures, options
        self._own_arguments = _as_arguments(scene, options, allow_outside)
        self.reference = Reference(scene, self.size, options, reference, reference_mean_of)
        self.film, self.filmed = None, None  # the film at hand; the folder of the last one that has ended
        self.panes = [Pane(scene, source, self.size, options) for source in sources]
        self.playing, self.keep, self.exposure, self.view = True, False, 0.0, "image"
        self.sides = (0, 1)  # the graphs of the difference, by their places
        self.seed = self.panes[0].renderer.seed
        self.time, self.speed = options.get("time", 0.0), 0.0
        self.camera = self.panes[0].renderer.camera
        self.view_number = 0  # how often camera or scene time have changed: what is told of a pixel is of one view
        self.follows = True  # the camera is the scene's own, and goes where that one goes
        self._own = self.scene_cameras().index(self.camera)
        self.revision = 0  # of the state
        self.stale = True  # what was shown last is not what would be shown now
        self.seen = {}  # client: the last of its messages that the next frame() shows
        self.steps = 0  # frames that are rendered while paused, besides those that a change asks for
        self.moved = False
        self._failed = False  # the frame that was rendered last; it is tried again after a change
        self.inspector = Inspector(self)

    def apply(self, message, client=None):
        """Do what the page asks for. Raises UserError or restirpg.Error; all is as before then."""
        commands.run(self, message)
        self.revision += 1
        self._failed = False
        if client is not None:
            self.seen[client] = message.get("id")

    def move(self, pose):
        """Look from another place, from the next frame on. Raises restirpg.Error where a renderer refuses the pose."""
        pane = self.panes[0]
        shown = pane.renderer.camera if pane.placed else None
        pane.place(pose)
        pane.place(shown)
        self._look_from(pose, follows=False)

    def follow(self):
        """Look from the scene's own camera, from the next frame on."""
        self._look_from(self.home, follows=True)

    def go_to(self, seconds):
        """Another time of the scene's animation, from the next frame on."""
        self.time = seconds
        self._look_from(self.home if self.follows else self.camera, self.follows)

    def _look_from(self, pose, follows):
        if pose != self.camera:
            self.revision += 1
        self.camera, self.follows = pose, follows
        self.moved = self.stale = True
        self.view_number += 1

    @property
    def home(self):
        """Where the scene's own camera is now."""
        return self.scene_cameras()[self._own]

    def scene_cameras(self):
        """Poses of the scene's cameras now."""
        renderer = self.panes[0].renderer
        if self.scene.duration > 0:
            renderer.set_time(self.time)
        return [camera.of_scene(entry) for entry in renderer.scene_cameras()]

    def pane(self, pane):
        """A graph, by its place."""
        if isinstance(pane, bool) or not isinstance(pane, int) or not 0 <= pane < len(self.panes):
            raise UserError(f"there is no graph {pane!r}")
        return self.panes[pane]

    def begin(self, pane):
        """A graph's picture is averaged from its next frame on."""
        if not self.keep:
            pane.renderer.cut()
        pane.forget()

    def reload(self):
        """Read graph files and shaders anew. What is refused stays as it was: a graph, the traced reference, the probe."""
        refusals = []
        for read_anew in (*(pane.rebuild for pane in self.panes), self.reference.reload, self.inspector.reload):
            try:
                read_anew()
            except restirpg.Error as error:
                refusals.append(str(error))
        for pane in self.panes:
            self.place(pane)
        if refusals:
            raise UserError("\n".join(dict.fromkeys(refusals)))

    def wants_frame(self):
        """Whether there is something to render."""
        if self._failed:
            return False
        if self._waits() or self.steps > 0:
            return True
        plays = self.film is not None or self._next_time() != self.time
        return self.playing and (plays or min(pane.frames for pane in self.panes) < MOST_FRAMES)

    def _waits(self):
        """Whether there is no picture of what is looked at: after a cut, or a move in space or time."""
        return self.moved or any(pane.waits for pane in self.panes)

    def _next_time(self):
        """Scene time of the next frame, s: the animation stops at its end, and backwards at its beginning."""
        if not (self.speed and self.playing):
            return self.time
        return min(max(0.0, self.time + self.speed / 30), self.scene.duration)

    def place(self, pane):
        """Give a graph the camera and the scene's time."""
        pane.place(None if self.follows else self.camera)
        if self.scene.duration > 0:
            pane.renderer.set_time(self.time)

    def render(self):
        """The next frame of every graph."""
        if self._next_time() != self.time:
            self.go_to(self._next_time())
        if self.moved:
            for pane in self.panes:
                self.place(pane)
                pane.forget()
                if not self.keep:
                    pane.renderer.cut()
            self.moved = False
        films = self.film and (self.playing or self.steps > 0)
        self.steps = max(0, self.steps - 1)
        try:
            for pane in self.panes:
                pane.render(self.keep)
            if films:
                self._write_film()
        except Exception:
            self.playing, self.steps, self._failed, self.film = False, 0, True, None  # not again and again
            self.revision += 1
            raise
        self.stale = True

    def _write_film(self):
        self.film.add()
        if self.film.ended:
            self.end_film()
        self.revision += 1

    def end_film(self):
        """Let the film at hand, if there is one, be as long as it is. One without a frame is none."""
        if self.film and self.film.done:
            self.filmed = str(self.film.folder)
        self.film = None

    def _view(self):
        """What the reference is of."""
        return self.camera, self.time, self._mean_of

    @property
    def _mean_of(self):
        """What the reference follows: bounce cap and pixel filter of the first graph that traces paths."""
        found = [pane.mean_of for pane in self.panes]
        return next((knobs for knobs in found if "bounces" in knobs), found[0])

    def trace_reference(self):
        """One more frame of the traced reference while the view rests. Returns whether there was one to render."""
        traced = not self.moved and self.reference.trace(*self._view())
        self.stale = self.stale or traced
        return traced

    def settle(self):
        """Render a frame where there is no picture of what is looked at."""
        if self._waits():
            self.render()

    def errors(self):
        """MAPE of each picture against the reference; None where it is refused, see Reference.refusal()."""
        truth = self.truth()
        return [
            None if self.reference.refusal(pane, truth) else restirpg.measure_errors(pane.picture(), truth)["mape"]
            for pane in self.panes
        ]

    def truth(self):
        """The reference of this view, or None."""
        return self.reference.of(*self._view(), not self.time and camera.same(self.camera, self.home))

    def _shown(self):
        """(label, 8-bit picture) of each, left to right."""
        if self.view == "difference":
            return [self._difference_shown()]
        if self.view == "error":
            truth = self.truth()
            return [self._error_shown(pane, truth) for pane in self.panes]
        return [(pane.label, self.pixels(pane)) for pane in self.panes]

    def _difference_shown(self):
        left, right = (self.panes[side] for side in self.sides)
        names = [f"{side + 1} {self.panes[side].name}" for side in self.sides]
        return f"difference of {names[1]} from {names[0]}", self._heat(right.picture(), left.picture())

    def _error_shown(self, pane, truth):
        """A graph's errors; what it shows besides where they are refused."""
        if why := self.reference.refusal(pane, truth):
            return f"{pane.label}, no error: {why}", self.pixels(pane)
        return f"{pane.name}: error", self._heat(pane.picture(), truth)

    def _heat(self, image, truth):
        return pictures.heat(relative_error(image, truth, np.float32), 2.0**-self.exposure)

    def pixels(self, pane):
        """A graph's picture, or the port that it shows, as 8-bit."""
        if pane.port:
            return pictures.port(pane.read(pane.port), pane.port, self.exposure)
        return pictures.radiance(pane.picture(), self.exposure)

    def frame(self):
        """The Frame to show."""
        self.settle()
        start = time.perf_counter()
        shown, truth = self._shown(), self.truth()
        images = [pictures.jpeg(pixels) for _, pixels in shown]
        panes = [
            {
                "frames": pane.frames,
                "milliseconds": pane.milliseconds,
                "passes": pane.passes,
                "memory": pane.memory,
                "mape": error,
                "no_error": self.reference.refusal(pane, truth),
                "command": self._command(pane),
            }
            for pane, error in zip(self.panes, self.errors())
        ]
        header = {
            "panes": panes,
            "seen": dict(self.seen),
            "time": self.time,
            "view_number": self.view_number,
            "labels": [label for label, _ in shown],
            "sizes": [len(image) for image in images],
            "reference": self.reference.source,
            "reference_frames": self.reference.frames,
            "view_milliseconds": 1000 * (time.perf_counter() - start),
        }
        self.stale = False
        return Frame(header, images)

    def state(self):
        """All that the page's controls show."""
        panes = [
            {
                "name": pane.name,
                "file": str(pane.file) if pane.file else "",
                "passes": pane.panel(),
                "ports": sorted(pane.ports),
                "port": pane.port,
                "guided": graphs.is_guided(pane.description),
                "arguments": shlex.join(graphs.as_arguments(pane.settings)),
            }
            for pane in self.panes
        ]
        return {
            "panes": panes,
            "size": self.size,
            "scene": str(self.scene.file),
            "duration": self.scene.duration,
            "camera": self.camera,
            "view_number": self.view_number,
            "call": camera.as_python(self.camera),
            "json": camera.as_json(self.camera),
            "cameras": [entry["name"] for entry in self.panes[0].renderer.scene_cameras()],
            "playing": self.playing,
            "keep": self.keep,
            "exposure": self.exposure,
            "view": self.view,
            "seed": self.seed,
            "time": self.time,
            "speed": self.speed,
            "reference": self.reference.source,
            "has_file": self.reference.image is not None,
            "seen": dict(self.seen),
            "films": self.captures is not None,
            "film": self.film and self.film.told(),
            "filmed": self.filmed,
        }

    def _command(self, pane):
        """The command line that renders what a graph shows here; None where its history is kept over moves."""
        if self.keep:
            return None
        words = [
            "restirpg",
            "render",
            str(pane.file or "GRAPH"),
            "--scene",
            str(self.scene.file),
            "--size",
            "x".join(map(str, self.size)),
            "--frames",
            str(max(1, pane.frames)),
            "--seed",
            str(self.seed),
            *graphs.as_arguments(pane.settings),
            *([camera.as_option(self.camera)] if pane.placed else []),
            *(["--time", f"{self.time:.9g}"] if self.time else []),  # all digits of a float
            *(["--output", pane.port] if pane.port else []),
            *self._own_arguments,
            "-o",
            "out.exr",
        ]
        return shlex.join(words)


def _as_arguments(scene, options, allow_outside):
    """How the scene was loaded and the options of a renderer, on which pictures depend, as options of
    `restirpg render`. Its bounce cap is in Pane.settings."""
    named = {name: options[name] for name in ("device", "backend") if options.get(name) is not None}
    return [
        *(word for name, value in named.items() for word in (f"--{name}", str(value))),
        *(["--energy-compensation"] if options.get("energy_compensation") else []),
        *(["--allow-outside"] if allow_outside else []),
        *(["--environment", scene.environment] if scene.environment else []),
    ]
