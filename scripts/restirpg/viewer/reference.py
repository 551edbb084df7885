"""What the errors of the graphs in view are measured against: an image of the scene's own camera, or the mean of a path
tracer that is rendered beside the graphs while the camera rests."""

import restirpg
from restirpg.harness import mean_knobs

SOURCES = ("none", "file", "traced")
MOST_FRAMES = 1 << 16  # of the path tracer
_SEED = 0x5EED5EED  # not one that graphs in view are likely to have: their noise is independent of the reference's
_KEPT = (
    "device",
    "backend",
    "validation",
    "energy_compensation",
    "bounces",
)  # of a graph's options, what the picture's mean depends on


#: Why there is no image.
_ABSENCE = {
    "none": "there is no reference",
    "file": "the reference shows the scene's own camera at 0 s",
    "traced": "no frame of the reference is traced yet",
}


class Reference:
    """image: float32 (H, W, 3) of the scene's own camera, or None. mean_of: as mean_knobs.mean_of has it, as far as it is
    known of that image."""

    def __init__(self, scene, size, options, image=None, mean_of=None):
        self._mean_of = mean_of or {}
        self.image, self.source = image, "none" if image is None else "file"
        self._scene, self._size = scene, size
        self._options = {name: options[name] for name in _KEPT if name in options}
        self._renderer, self._view, self._traced = None, None, None

    @property
    def frames(self):
        """Frames of the path tracer in the mean."""
        return self._renderer.frame if self._renderer and self._view else 0

    def use(self, source):
        """One of SOURCES; the path tracer is made when it is first asked for."""
        if source == "traced" and self._renderer is None:
            graph = restirpg.load_graph(restirpg.GRAPHS / "path_tracer.py")
            self._renderer = restirpg.Renderer(self._scene, graph, size=self._size, seed=_SEED, **self._options)
        self.source, self._view = source, None

    @property
    def mean_of(self):
        """See mean_knobs.py; as far as it is known."""
        return mean_knobs.mean_of(self._renderer.knobs()) if self.source == "traced" else self._mean_of

    def refusal(self, pane, truth):
        """Why the errors of a graph's picture are not measured against `truth`, of of(); None: they are."""
        if truth is None:
            return _ABSENCE[self.source]
        if pane.channels != truth.shape[2]:
            return f"its picture has not the reference's {truth.shape[2]} channels"
        return next(iter(mean_knobs.differences(pane.mean_of, self.mean_of, "the reference").values()), None)

    def reload(self):
        """Read the path tracer and its shaders anew, if it was made: its mean begins anew."""
        if self._renderer:
            self._renderer.reload()
            self._view = None

    def trace(self, pose, seconds, knobs):
        """One more frame of this view, with these knobs everywhere; another view begins anew. Returns whether there was
        one to render."""
        if self.source != "traced":
            return False
        view = (pose, seconds, knobs)
        if view == self._view and self.frames >= MOST_FRAMES:
            return False
        if view != self._view:
            self._renderer.cut()
            self._renderer.move_camera(**pose)
            if self._scene.duration > 0:
                self._renderer.set_time(seconds)
            for name, value in knobs.items():
                self._renderer.set_everywhere(name, value)
            self._view = view
        self._renderer.render(1)
        self._traced = None  # the mean, read when it is first asked for
        return True

    def of(self, pose, seconds, knobs, is_home):
        """The image of this view (is_home: the scene's own), or None."""
        if self.source == "file":
            return self.image if is_home else None
        if self.source == "traced" and self.frames > 0 and self._view == (pose, seconds, knobs):
            if self._traced is None:
                self._traced = self._renderer.output("image")
            return self._traced
        return None
