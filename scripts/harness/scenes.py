"""Scene files: those of embedded scenes, and what the harness must know of one before the renderer loads it."""

import json
import struct
import urllib.parse
from pathlib import Path

from harness import UserError
from harness.jobs import digest


def file_of(name, folder):
    """The file `name`, or that of the embedded scene so called, written to `folder`; raises UserError."""
    from scenes import SCENES

    if Path(name).is_file():
        return str(name)
    if name not in SCENES:
        raise UserError(f"{name}: neither a file nor an embedded scene; scripts/make_scenes.py --list names those")
    Path(folder).mkdir(parents=True, exist_ok=True)
    return str(SCENES[name]().write(Path(folder)))


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


def bounce_cap(file, wanted=None):
    """`wanted`, or else the cap that the scene's author asks for (asset extras "restirpg"), or None."""
    if wanted is not None:
        return wanted
    bounces = _extras(_document(file)).get("bounces")
    return bounces if isinstance(bounces, int) else None


def _key_ranges(file):
    """(first key, last key, whether the one value holds until the last key) of each animation sampler, s."""
    document = _document(file)
    for animation in document.get("animations", []):
        for sampler in animation.get("samplers", []):
            times = document["accessors"][sampler["input"]]
            jump = sampler.get("interpolation") == "STEP" and times["count"] <= 2
            yield times["min"][0], times["max"][0], jump


def is_animated(file):
    """Whether anything moves in the scene."""
    return any(True for _ in _key_ranges(file))


def held_since(file, seconds):
    """The earliest time, s, from which on the animation stands until `seconds` as it does then.

    Times of one answer need one reference between them. Seen are pauses before and after all keys, and jumps
    between two (interpolation STEP).
    """
    since = 0.0
    for first, last, jump in _key_ranges(file):
        if seconds >= last:
            since = max(since, last)
        elif seconds > first and not jump:
            return seconds
    return since


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
