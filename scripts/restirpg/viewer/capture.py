"""What the page can download: the picture as PNG, the outputs as EXR with their provenance, the graph as a file."""

import contextlib
import json
import re
import tempfile
from pathlib import Path

import restirpg
from restirpg.harness import UserError
from restirpg.harness.guiding import LEARNT

from . import camera, graphs, pictures

#: Of a picture that depends on earlier moves of the camera.
_KEPT = {"history": "kept over moves of the camera"}


def png(session, pane):
    """The picture as shown, with its provenance as texts."""
    texts = {
        "graph": _graph(session, pane).decode(),
        "scene": str(session.scene.file),
        "sceneHash": session.scene.hash,
        "camera": camera.as_json(session.camera),
        "time": f"{session.time:.6g}",
        "seed": str(session.seed),
        "frames": str(pane.frames),
        "exposure": f"{session.exposure:.6g}",
        "port": pane.port or "",
        "commit": restirpg.COMMIT,
        **(_KEPT if session.keep else {}),
    }
    return pictures.png(session.pixels(pane), {f"restirpg.{name}": text for name, text in texts.items()})


def save(session, pane, file):
    """Write the graph's outputs as EXR with their provenance. Where history is kept over moves of the camera it is the
    picture alone, as it is shown: the graph's own means are over all moves."""
    pane.renderer.save(file, output=pane.renderer.output_names[0] if session.keep else "")
    attributes = restirpg.read_exr_attributes(file)
    graph = json.loads(attributes["restirpg.graph"])
    graph["passes"] = [entry for entry in graph["passes"] if entry["name"] != LEARNT]
    graph["outputs"] = [entry for entry in graph["outputs"] if entry["pass"] != LEARNT]
    attributes["restirpg.graph"] = json.dumps(graph)
    if session.keep:
        attributes |= {f"restirpg.{name}": text for name, text in {"frames": str(pane.frames), **_KEPT}.items()}
    layers = {"": pane.picture()} if session.keep else _layers(pane.renderer)
    restirpg.write_exr(file, layers, attributes=attributes)


def _layers(renderer):
    """The outputs that are images, as Renderer.save names them."""
    images = {}
    for name in renderer.output_names:
        with contextlib.suppress(restirpg.WrongValueError):  # it is no image
            images[name if images else ""] = renderer.output(name)
    return images


def _exr(session, pane):
    with tempfile.TemporaryDirectory(prefix="restirpg-") as folder:
        file = Path(folder) / "capture.exr"
        save(session, pane, file)
        return file.read_bytes()


def _graph(_, pane):
    return json.dumps(graphs.with_knobs(pane.description, pane.settings), indent=1).encode()


_KINDS = {
    "picture.png": (png, "image/png"),
    "outputs.exr": (_exr, "image/x-exr"),
    "graph.json": (_graph, "application/json"),
}


def make(session, name, number):
    """(bytes, MIME type, a file name) of the download `name` of the graph `number` (text). Raises UserError."""
    if name not in _KINDS:
        raise UserError(f"there is no download '{name}'; there are {', '.join(_KINDS)}")
    if not (number.isdecimal() and int(number) < len(session.panes)):
        raise UserError(f"there is no graph {number!r}")
    session.settle()
    function, content_type = _KINDS[name]
    pane = session.panes[int(number)]
    return function(session, pane), content_type, f"{stem_of(pane)}_{pane.frames}{Path(name).suffix}"


def stem_of(pane):
    """The graph's name as the beginning of a file's."""
    return re.sub(r"[^A-Za-z0-9]+", "_", pane.name).strip("_").lower() or "graph"
