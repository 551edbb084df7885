"""What the pixels see, apart from the graphs in view: a renderer of the primary hits alone, made when first asked."""

import restirpg

_IMAGES = ("depth", "geometric_normal", "normal", "material", "albedo")
_KEPT = ("device", "backend", "validation")  # of a graph's options; the others are of its passes, or of its first frame


class Probe:
    """Primary hits of a scene from any camera."""

    def __init__(self, scene, size, options):
        graph = restirpg.Graph("Primary hits")
        gbuffer = graph.add("gbuffer", "GBuffer")
        for name in _IMAGES:
            graph.output(name, getattr(gbuffer, name))
        kept = {name: options[name] for name in _KEPT if name in options}
        self.renderer = restirpg.Renderer(scene, graph, size=size, **kept)
        self._scene, self._rendered, self._images = scene, None, {}

    def reload(self):
        """Read the shaders anew."""
        self.renderer.reload()
        self._rendered = None

    def render(self, pose, seconds):
        """One frame from there, unless it is the last one."""
        if self._rendered == (pose, seconds):
            return
        self.renderer.move_camera(**pose)
        if self._scene.duration > 0:
            self.renderer.set_time(seconds)
        self.renderer.cut()
        self.renderer.render(1)
        self._images = {name: self.renderer.output(name) for name in _IMAGES}
        self._rendered = pose, seconds

    def at(self, pose, seconds, x, y):
        """{depth (m, 0 at a miss), normal, material, ...} of a pixel."""
        self.render(pose, seconds)
        values = {name: image[y, x].tolist() for name, image in self._images.items()}
        return {name: value[0] if len(value) == 1 else value for name, value in values.items()}
