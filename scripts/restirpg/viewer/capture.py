"""What the page can download: the picture as PNG, the outputs as EXR with their provenance, the graph as a file."""

import json
import re
import tempfile
from pathlib import Path

from restirpg.harness import UserError

from . import graphs, pictures


def _png(session, pane):
    return pictures.png(session.pixels(pane))


def _exr(_, pane):
    with tempfile.TemporaryDirectory(prefix="restirpg-") as folder:
        file = Path(folder) / "capture.exr"
        pane.renderer.save(file)
        return file.read_bytes()


def _graph(_, pane):
    return json.dumps(graphs.with_knobs(pane.description, pane.changed), indent=1).encode()


_KINDS = {"picture.png": (_png, "image/png"), "outputs.exr": (_exr, "image/x-exr"), "graph.json": (_graph, "application/json")}


def make(session, name, number):
    """(bytes, MIME type, a file name) of the download `name` of the graph `number` (text). Raises UserError."""
    if name not in _KINDS:
        raise UserError(f"there is no download '{name}'; there are {', '.join(_KINDS)}")
    if not (number.isdecimal() and int(number) < len(session.panes)):
        raise UserError(f"there is no graph {number!r}")
    session.settle()
    function, content_type = _KINDS[name]
    pane = session.panes[int(number)]
    stem = re.sub(r"[^A-Za-z0-9]+", "_", pane.name).strip("_").lower() or "graph"
    return function(session, pane), content_type, f"{stem}_{pane.frames}{Path(name).suffix}"
