"""What the harness must know of a scene file before the renderer loads it: its content's hash and its bounce
cap."""

import json
import struct
import urllib.parse
from pathlib import Path

from harness import UserError
from harness.jobs import digest


def _document(file):
    """The JSON of a .gltf or .glb file, or {} when it has none: the renderer says what is wrong with it."""
    try:
        data = Path(file).read_bytes()
        if data[:4] == b"glTF":
            (length,) = struct.unpack_from("<I", data, 12)
            data = data[20 : 20 + length]
        document = json.loads(data)
    except (ValueError, struct.error):
        return {}
    return document if isinstance(document, dict) else {}


def _extras(document):
    extras = document
    for name in ("asset", "extras", "restirpg"):
        extras = extras.get(name, {}) if isinstance(extras, dict) else {}
    return extras if isinstance(extras, dict) else {}


def bounce_cap(file):
    """The cap that the scene's author asks for (asset extras "restirpg"), or None."""
    bounces = _extras(_document(file)).get("bounces")
    return bounces if isinstance(bounces, int) else None


def content_hash(file, environment=None):
    """Hash of the file, of the files it names, and of the environment; raises UserError."""
    path = Path(file)
    if not path.is_file():
        raise UserError(
            f"{file}: no such scene; scripts/make_scenes.py writes the embedded ones to out/scenes"
        )
    document = _document(file)
    named = [
        item.get("uri")
        for kind in ("buffers", "images")
        for item in document.get(kind, [])
        if isinstance(item, dict)
    ]
    named.append(_extras(document).get("environment"))
    parts = [path.read_bytes(), str(environment).encode()]
    others = [
        path.parent / urllib.parse.unquote(uri)
        for uri in named
        if isinstance(uri, str) and not uri.startswith("data:")
    ]
    for other in [*others, Path(environment or "")]:
        if other.is_file():
            parts.append(other.read_bytes())
    return digest(b"".join(digest(part).encode() for part in parts))
