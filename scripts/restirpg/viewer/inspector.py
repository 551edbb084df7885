"""What is known of one pixel of a Session: geometry, values, reservoirs, the selected path, the guide."""

from restirpg.harness import UserError

from . import guide, reservoirs
from .probe import Probe
from .values import as_number


class Inspector:
    """Of one session."""

    def __init__(self, session):
        self._session, self._probe = session, None

    def geometry(self, x, y):
        """Depth, normal, material and albedo of what a pixel shows."""
        x, y = self._pixel(x, y)
        self._probe = self._probe or Probe(self._session.scene, self._session.size, self._session.options)
        return self._probe.at(self._session.camera, self._session.time, x, y)

    def reload(self):
        """Read the probe's shaders anew, if it was made."""
        if self._probe:
            self._probe.reload()

    def _pixel(self, x, y):
        width, height = self._session.size
        x, y = int(as_number(x)), int(as_number(y))
        if not (0 <= x < width and 0 <= y < height):
            raise UserError(f"pixel {x} {y} is not one of the {width}x{height}")
        return x, y

    def pixel(self, x, y):
        """What is known of a pixel: its geometry (None where it shows no surface), and values of each graph."""
        x, y = self._pixel(x, y)
        self._session.settle()
        panes, geometry = self._session.panes, self.geometry(x, y)
        return {
            "x": x,
            "y": y,
            "view_number": self._session.view_number,
            "geometry": geometry if geometry["depth"] > 0 else None,
            "panes": [pane.pixel(x, y) for pane in panes],
            "reservoirs": [reservoirs.at_pixel(pane, x, y) for pane in panes],
            "paths": [reservoirs.path_at_pixel(pane, x, y, self._session.camera) for pane in panes],
        }

    def guide(self, pane, x, y, product=False):
        """What guides the paths at a pixel of a graph, see guide.py."""
        chosen, (x, y) = self._session.pane(pane), self._pixel(x, y)
        self._session.settle()
        self.geometry(x, y)
        told = guide.at_pixel(chosen, self._probe, self._session, (x, y), product is True)
        return {**told, "pane": pane, "x": x, "y": y, "view_number": self._session.view_number}
