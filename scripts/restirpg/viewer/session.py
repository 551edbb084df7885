"""What is looked at and how: the state behind the page, without a network. One thread uses it.

apply() takes the page's messages, {"do": name, arguments}; render() makes the next frame of every graph; frame() gives
what is to be shown of it.
"""

import inspect
import math
import shlex
import time
from dataclasses import dataclass, field

import numpy as np

import restirpg
from restirpg.harness import UserError

from . import camera, graphs, guide, pictures, reservoirs
from .film import Film
from .pane import Pane
from .probe import Probe
from .reference import SOURCES, Reference

VIEWS = ("image", "difference", "error")
MOST_FRAMES = 1 << 16  # of a picture that rests: rendering stops there


@dataclass
class Frame:
    """What the page shows: numbers, and the bytes of one JPEG a picture."""

    header: dict
    images: list = field(default_factory=list)


def _number(value, low=-1e6, high=1e6):
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise UserError(f"{value!r} is no number")
    return min(high, max(low, value))


class Session:
    """One scene, one camera, and up to a few graphs that render it in step."""

    def __init__(self, scene, sources, size, reference=None, captures=None, **options):
        """sources: graph files, restirpg.Graph or descriptions. reference: an image (H, W, 3) of the scene's own
        camera. captures: the folder where films are put."""
        self.scene, self.size, self.captures = scene, tuple(size), captures
        self.reference = Reference(scene, self.size, options, reference)
        self.film = None
        self._options = options
        self.panes = [Pane(scene, source, self.size, options) for source in sources]
        self.home = self.camera = self.panes[0].renderer.camera
        self.playing, self.keep, self.exposure, self.view = True, False, 0.0, "image"
        self.seed = self.panes[0].renderer.seed
        self.time, self.speed = options.get("time", 0.0), 0.0
        self.revision = 0  # of the state
        self.stale = True  # what was shown last is not what would be shown now
        self.seen = {}  # client: the last of its messages that the next frame() shows
        self._steps, self._moved, self._rendered = 0, False, False
        self._probe = None
        self._commands = {
            name: getattr(self, f"do_{name}")
            for name in (
                "orbit",
                "look",
                "pan",
                "dolly",
                "fly",
                "zoom",
                "focus",
                "pose",
                "home",
                "camera",
                "play",
                "step",
                "restart",
                "keep",
                "exposure",
                "view",
                "set",
                "reset",
                "show",
                "seed",
                "time",
                "speed",
                "reload",
                "reference",
                "film",
            )
        }

    def apply(self, message, client=None):
        """Do what the page asks for. Raises UserError or restirpg.Error; all is as before then."""
        command = self._commands.get(message.get("do"))
        if command is None:
            raise UserError(f"there is no command {message.get('do')!r}")
        arguments = {name: value for name, value in message.items() if name not in ("do", "id")}
        try:
            inspect.signature(command).bind(**arguments)
        except TypeError as error:
            raise UserError(f"{message['do']}: {error}") from None
        command(**arguments)
        self.revision += 1
        if client is not None:
            self.seen[client] = message.get("id")

    def _move(self, pose):
        if not np.isfinite(np.concatenate([pose["position"], pose["target"]])).all():
            raise UserError("the camera would be nowhere")
        self.camera = pose
        self._moved = self.stale = True

    def do_orbit(self, x, y):
        """Turn about the target, radians."""
        self._move(camera.orbit(self.camera, _number(x), _number(y)))

    def do_look(self, x, y):
        """Turn the head, radians."""
        self._move(camera.look(self.camera, _number(x), _number(y)))

    def do_pan(self, x, y):
        """Shift by fractions of the picture's height."""
        self._move(camera.pan(self.camera, _number(x), _number(y)))

    def do_dolly(self, amount):
        """Go towards the target."""
        self._move(camera.dolly(self.camera, _number(amount, -5, 5)))

    def do_fly(self, x, y, z):
        """Move by fractions of the target's distance along right, up and forward."""
        step = camera.distance(self.camera)
        self._move(camera.fly(self.camera, *(step * _number(value, -10, 10) for value in (x, y, z))))

    def do_zoom(self, factor):
        """Another field of view."""
        self._move(camera.zoom(self.camera, _number(factor, 0.1, 10)))

    def do_focus(self, x, y):
        """Orbit about what the pixel shows: the target goes to its depth."""
        depth = self.geometry(x, y)["depth"]
        if depth > 0:
            self._move(camera.focus(self.camera, depth))

    def do_pose(self, position, target, up, yfov):
        """A camera as the page copied it."""
        pose = {"position": position, "target": target, "up": up, "yfov": _number(yfov, 0.03, 2.6)}
        for name in ("position", "target", "up"):
            if not isinstance(pose[name], list) or len(pose[name]) != 3:
                raise UserError(f"{name} is not three numbers")
            pose[name] = [float(_number(value)) for value in pose[name]]
        if not np.linalg.norm(np.cross(np.subtract(pose["target"], pose["position"]), pose["up"])) > 1e-9:
            raise UserError("the camera's direction and up span no view")
        self._move(pose)

    def do_home(self):
        """The scene's own camera."""
        self._move(self.home)

    def do_camera(self, number):
        """One of the scene's cameras, where it stands now."""
        cameras = self.panes[0].renderer.scene_cameras()
        if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < len(cameras):
            raise UserError(f"there is no camera {number!r}; the scene has {len(cameras)}, counted from 0")
        self._move({name: cameras[number][name] for name in ("position", "target", "up", "yfov")})

    def do_play(self, on):
        """Render on, or pause."""
        self.playing, self._steps = bool(on), 0

    def do_step(self):
        """Pause, and render one frame."""
        self.playing = False
        self._steps = min(self._steps + 1, 100)

    def do_restart(self):
        """Forget all history."""
        for pane in self.panes:
            pane.renderer.cut()
            pane.forget()
        self._steps = max(self._steps, 1)

    def do_keep(self, on):
        """Whether history is kept over moves of the camera, as in a real-time renderer, or cut."""
        self.keep = bool(on)
        self.do_restart()

    def do_exposure(self, stops):
        """Of the picture as shown."""
        self.exposure, self.stale = float(_number(stops, -20, 20)), True

    def do_view(self, name):
        """The pictures, their difference, or their errors against the reference."""
        if name not in VIEWS:
            raise UserError(f"there is no view {name!r}")
        if name == "difference" and len(self.panes) < 2:
            raise UserError("a difference takes two graphs; give two on the command line")
        if name == "error" and self.reference.source == "none":
            raise UserError("errors take a reference; have one traced, or give one with --reference")
        self.view, self.stale = name, True

    def _pane(self, pane):
        if isinstance(pane, bool) or not isinstance(pane, int) or not 0 <= pane < len(self.panes):
            raise UserError(f"there is no graph {pane!r}")
        return self.panes[pane]

    def do_set(self, pane, knob, value):
        """Turn a knob. What was averaged with its old value is forgotten."""
        self._pane(pane).set(str(knob), value)
        self._begin(self._pane(pane))

    def do_reset(self, pane):
        """All knobs as the graph gives them."""
        chosen = self._pane(pane)
        for knob in list(chosen.changed):
            chosen.set(knob, None)
        self._begin(chosen)

    def _begin(self, pane):
        if not self.keep:
            pane.renderer.cut()
        pane.forget()
        self._steps = max(self._steps, 1)

    def do_show(self, pane, port):
        """Show a port in place of the picture, or (null) the picture."""
        chosen = self._pane(pane)
        chosen.show(port)
        self.stale = True
        if chosen.renderer.frame == 0:
            self._begin(chosen)

    def do_seed(self, value):
        """Other random numbers, from a first frame on."""
        self.seed = int(_number(value, 0, 2**32 - 1))
        for pane in self.panes:
            pane.renderer.seed = self.seed
        self.do_restart()

    def do_time(self, seconds):
        """Of the scene's animation."""
        self.time = float(_number(seconds, 0))
        self._moved = self.stale = True

    def do_speed(self, factor):
        """Seconds of the scene's animation a thirtieth of a frame: 0 stands still."""
        self.speed = float(_number(factor, -100, 100))

    def do_reference(self, source):
        """What errors are measured against: "none", the "file" that was given, or "traced" beside the graphs."""
        if source not in SOURCES or (source == "file" and self.reference.image is None):
            raise UserError(f"there is no reference {source!r}; a file is given with --reference")
        self.reference.use(source)
        self.view = "image" if source == "none" and self.view == "error" else self.view
        self.stale = True

    def do_film(self, frames, kind):
        """Write pictures of the next frames into a folder; 0 frames: end the film at hand."""
        self.film = Film(self.captures, self, frames, kind) if frames != 0 else None
        self.playing = self.playing or self.film is not None

    def do_reload(self):
        """Read graph files and shaders anew. Each graph that is refused stays as it was."""
        refusals = []
        for pane in self.panes:
            try:
                pane.build(pane.port)
            except restirpg.Error as error:
                refusals.append(str(error))
        self._place()
        self._steps = max(self._steps, 1)
        if refusals:
            raise UserError("\n".join(dict.fromkeys(refusals)))

    def wants_frame(self):
        """Whether there is something to render."""
        if self._moved or self._steps > 0 or not self._rendered or self.film:
            return True
        return self.playing and (self.speed != 0 or min(pane.frames for pane in self.panes) < MOST_FRAMES)

    def _place(self):
        for pane in self.panes:
            pane.renderer.move_camera(**self.camera)
            if self.scene.duration > 0:
                pane.renderer.set_time(self.time)

    def render(self):
        """The next frame of every graph."""
        if self.speed and self.playing:
            self.time = max(0.0, self.time + self.speed / 30)
            self._moved = True
        if self._moved:
            self._place()
            for pane in self.panes:
                pane.forget()
                if not self.keep:
                    pane.renderer.cut()
            self._moved = False
        self._steps = max(0, self._steps - 1)
        try:
            for pane in self.panes:
                pane.render(self.keep)
            if self.film:
                self._write_film()
        except Exception:
            self.playing, self._steps, self._rendered, self.film = False, 0, True, None  # not again and again
            self.revision += 1
            raise
        self._rendered = self.stale = True

    def _write_film(self):
        self.film.add()
        self.film = None if self.film.ended else self.film
        self.revision += 1

    def _view(self):
        """What the reference is of: it follows the bounce cap of the first graph."""
        knobs = (entry["bounces"] for entry in self.panes[0].renderer.knobs().values() if "bounces" in entry)
        return self.camera, self.time, next(knobs, None)

    def trace_reference(self):
        """One more frame of the traced reference while the view rests. Returns whether there was one to render."""
        traced = not self._moved and self.reference.trace(*self._view())
        self.stale = self.stale or traced
        return traced

    def settle(self):
        """Render a frame where a cut has left no picture."""
        if not self._rendered or any(pane.renderer.frame == 0 for pane in self.panes):
            self.render()

    def errors(self):
        """MAPE of each picture against the reference; None where there is none, or it shows another view."""
        truth = self.truth()
        if truth is None:
            return [None] * len(self.panes)
        return [restirpg.measure_errors(pane.picture(), truth)["mape"] for pane in self.panes]

    def truth(self):
        """The reference of this view, or None."""
        return self.reference.of(*self._view(), not self.time and camera.same(self.camera, self.home))

    def _shown(self):
        """8-bit pictures, left to right."""
        if self.view == "difference":
            first, second = (pane.picture() for pane in self.panes[:2])
            return [pictures.heat(pictures.relative_difference(second, first), 2.0**-self.exposure)]
        if self.view == "error" and (truth := self.truth()) is not None:
            return [
                pictures.heat(pictures.relative_difference(pane.picture(), truth), 2.0**-self.exposure)
                for pane in self.panes
            ]
        return [self.pixels(pane) for pane in self.panes]

    def pixels(self, pane):
        """A graph's picture, or the port that it shows, as 8-bit."""
        if pane.port:
            return pictures.port(pane.read(pane.port), pane.port, self.exposure)
        return pictures.radiance(pane.picture(), self.exposure)

    def frame(self):
        """The Frame to show."""
        self.settle()
        start = time.perf_counter()
        self.stale = False
        images = [pictures.jpeg(pixels) for pixels in self._shown()]
        panes = [
            {
                "frames": pane.frames,
                "milliseconds": pane.milliseconds,
                "passes": pane.renderer.gpu_times(),
                "memory": sum(pane.renderer.memory().values()),
                "mape": error,
            }
            for pane, error in zip(self.panes, self.errors())
        ]
        header = {
            "panes": panes,
            "seen": dict(self.seen),
            "time": self.time,
            "sizes": [len(image) for image in images],
            "reference_frames": self.reference.frames,
            "film": self.film and self.film.told(),
            "view_milliseconds": 1000 * (time.perf_counter() - start),
        }
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
                "arguments": graphs.as_arguments(pane.changed),
                "command": self._command(pane),
            }
            for pane in self.panes
        ]
        return {
            "panes": panes,
            "size": self.size,
            "scene": str(self.scene.file),
            "duration": self.scene.duration,
            "camera": self.camera,
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
            "films": self.captures is not None,
        }

    def _command(self, pane):
        """The command line that renders what a graph shows here."""
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
            *graphs.as_arguments(pane.changed).split(),
            camera.as_option(self.camera),
            *(["--time", f"{self.time:.6g}"] if self.time else []),
            "-o",
            "out.exr",
        ]
        return shlex.join(words)

    def geometry(self, x, y):
        """Depth, normal, material and albedo of what a pixel shows."""
        x, y = self._pixel(x, y)
        self._probe = self._probe or Probe(self.scene, self.size, self._options)
        return self._probe.at(self.camera, self.time, x, y)

    def _pixel(self, x, y):
        width, height = self.size
        x, y = int(_number(x)), int(_number(y))
        if not (0 <= x < width and 0 <= y < height):
            raise UserError(f"pixel {x} {y} is not one of the {width}x{height}")
        return x, y

    def inspect(self, x, y):
        """What is known of a pixel: its geometry, and values of each graph."""
        x, y = self._pixel(x, y)
        self.settle()
        return {
            "x": x,
            "y": y,
            "geometry": self.geometry(x, y),
            "panes": [pane.pixel(x, y) for pane in self.panes],
            "reservoirs": [reservoirs.at_pixel(pane, x, y) for pane in self.panes],
            "paths": [reservoirs.path_at_pixel(pane, x, y, self.camera) for pane in self.panes],
        }

    def guide(self, pane, x, y, product=False):
        """What guides the paths at a pixel of a graph, see guide.py."""
        chosen, (x, y) = self._pane(pane), self._pixel(x, y)
        self.settle()
        self.geometry(x, y)
        return guide.at_pixel(chosen, self._probe, self.scene, (x, y), product is True)
