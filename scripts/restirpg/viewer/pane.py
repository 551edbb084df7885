"""One graph that is looked at: its renderer, the knobs that were turned, and the port that is shown."""

import time
from pathlib import Path

import numpy as np

import restirpg
from restirpg.harness.guiding import LEARNT
from restirpg.harness.mean_knobs import mean_of

from . import graphs


class Pane:
    """A graph file, a restirpg.Graph or a description, and a Renderer of it.

    options: further arguments of restirpg.Renderer. A new renderer takes the place of the old one only after it was
    made: a graph or a kernel that is refused leaves all as it was. Where a guide learns from paths, the renderer has one
    pass more than the graph, LEARNT, which tells what they are. Times and memory are told without it.
    """

    def __init__(self, scene, source, size, options):
        self._scene, self._source, self._size, self._options = scene, source, size, options
        self.changed = {}  # "pass.knob": value, of the knobs that were turned
        self.port = None  # shown in place of the picture
        self.build()

    @property
    def file(self):
        """The graph file, or None."""
        return Path(self._source) if isinstance(self._source, (str, Path)) else None

    def _describe(self):
        if self.file:
            return restirpg.load_graph(self.file).description
        return self._source if isinstance(self._source, dict) else self._source.description()

    def build(self, port=None):
        """Read the graph and its shaders anew, and show `port` where it is still there; knobs that were turned stay so
        where they are. Raises restirpg.Error and changes nothing when something is refused."""
        description = self._describe()
        port = port if port and graphs.has_image_port(description, port) else None
        shown = graphs.with_output(description, port) if port else description
        alone = graphs.frame_output(description)
        with_paths = graphs.with_learnt_paths(shown)
        vertices = f"{LEARNT}.vertices" if with_paths else None
        outputs = [*self._options.get("outputs", ()), *(extra for extra in (alone, vertices) if extra)]
        renderer = restirpg.Renderer(
            self._scene, with_paths or shown, size=self._size, **{**self._options, "outputs": outputs}
        )
        initial = renderer.knobs()
        changed = {name: value for name, value in self.changed.items() if _value(initial, name) is not None}
        for name, value in changed.items():
            renderer.set(name, value)
        if hasattr(self, "renderer"):
            renderer.seed = self.renderer.seed
        self.placed = False  # the renderer has a pose in place of the scene's camera
        self.renderer, self.description, self.changed, self._initial = renderer, description, changed, initial
        self.ports = graphs.image_ports(description)
        self.frame_output, self.learnt_vertices = alone, vertices
        self.port = port
        self.forget()

    def rebuild(self):
        """build(), with the port that is shown."""
        self.build(self.port)

    def place(self, pose):
        """Look from there, or (None) from the scene's own camera."""
        if pose is None:
            self.renderer.follow_scene_camera()
        else:
            self.renderer.move_camera(**pose)
        self.placed = pose is not None

    def forget(self):
        """Begin the viewer's own mean anew; the renderer's history stays. Until its next frame the graph `waits`."""
        self._mean, self.milliseconds, self.waits = Mean(), 0.0, True

    @property
    def settings(self):
        """{"pass.knob": value} of all knobs that may differ from the graph's: the bounce cap that was asked for, and those
        that were turned."""
        cap = self._options.get("bounces")
        passes = [name for name, own in self._initial.items() if "bounces" in own and cap is not None]
        return {**{f"{name}.bounces": cap for name in passes}, **self.changed}

    @property
    def bounces(self):
        """The bounce cap, or None where no pass has one."""
        return self.mean_of.get("bounces")

    @property
    def mean_of(self):
        """See mean_knobs.py."""
        return mean_of(self.renderer.knobs())

    @property
    def name(self):
        """The graph's name."""
        return self.description["name"]

    @property
    def label(self):
        """What is written on what it shows: its name, and the port where it shows one."""
        return f"{self.name}: {self.port}" if self.port else self.name

    @property
    def channels(self):
        """Of the picture."""
        picture = self.description["outputs"][0]
        return self.ports[f"{picture['pass']}.{picture['output']}"]

    def panel(self):
        """Knobs by pass, with declarations, values and the values that the graph gives."""
        passes = graphs.panel(self.description, self.renderer.knobs())
        for entry in passes:
            for knob in entry["knobs"]:
                knob["initial"] = self._initial[entry["name"]][knob["name"]]
        return passes

    def set(self, knob, value):
        """Turn "pass.knob"; None: back to the graph's own value."""
        initial = _value(self._initial, knob)
        if value is None and initial is not None:
            value = initial
        self.renderer.set(knob, value)
        self.changed[knob] = self.renderer.get(knob)
        if self.changed[knob] == initial:
            del self.changed[knob]

    def show(self, port):
        """Show a port "pass.output" in place of the picture, or (None) the picture. One that nobody reads is made by a
        new renderer, where it is an output."""
        if port is not None and not (isinstance(port, str) and port in self.ports):
            raise restirpg.Error(f"{self.name} has no image port '{port}'")
        if port is not None and port not in self._readable():
            self.build(port)
        else:
            self.port = port

    def _readable(self):
        return self.renderer.memory().keys() & self.ports.keys()

    def render(self, kept):
        """One more frame. kept: history goes on over moves of the camera, and the mean is the viewer's own."""
        start = time.perf_counter()
        self.renderer.render(1)
        self.milliseconds = 1000 * (time.perf_counter() - start) - self.renderer.gpu_times().get(LEARNT, 0.0)
        self.waits = False
        if kept and self.frame_output:
            self._mean.add(self.renderer.output(self.frame_output))

    @property
    def passes(self):
        """{pass: the device's milliseconds in the last frame}, without the pass LEARNT, which is not the graph's own."""
        return {name: time for name, time in self.renderer.gpu_times().items() if name != LEARNT}

    @property
    def memory(self):
        """Bytes of the scene and of the graph's buffers, without those of LEARNT."""
        return sum(size for port, size in self.renderer.memory().items() if port != self.learnt_vertices)

    @property
    def frames(self):
        """Frames in the picture."""
        return self._mean.frames or self.renderer.frame

    def read(self, port):
        """A port's values, float32 (H, W, C)."""
        width, height = self.renderer.size
        return self.renderer.read_port(port).view(np.float32).reshape(height, width, self.ports[port])

    def picture(self):
        """The graph's picture, float32 (H, W, C)."""
        if self._mean.frames:
            return self._mean.image()
        return self.renderer.output(self.renderer.output_names[0])

    def pixel(self, x, y):
        """{name: values} of the picture and of every image port that somebody reads, at a pixel."""
        values = {"picture": self.picture()[y, x]}
        values.update((port, self.read(port)[y, x]) for port in sorted(self._readable()))
        return {name: [float(v) for v in value] for name, value in values.items()}


class Mean:
    """Of frames. Where a frame is NaN or infinite it is left out, as by the pass Accumulate."""

    def __init__(self):
        self.frames, self._sum, self._counts = 0, np.float32(0), np.float32(0)

    def add(self, frame):
        """Add float32 (H, W, C)."""
        valid = np.isfinite(frame).all(axis=-1, keepdims=True)
        self._sum = self._sum + np.where(valid, frame, np.float32(0))
        self._counts = self._counts + valid.astype(np.float32)
        self.frames += 1

    def image(self):
        """float32 (H, W, C); 0 where no frame is valid."""
        return self._sum / np.maximum(self._counts, np.float32(1))


def _value(knobs, name):
    entry, _, knob = name.partition(".")
    return knobs.get(entry, {}).get(knob)
