"""The records that kernels write, as NumPy sees them:
`renderer.read_port("reuse.reservoirs").view(record("PathReservoir"))`.

Layouts and constants are read from the headers that C++ and GLSL share: framework/shaders/*_types.h and the passes'
Shared.h, also those of passes along RESTIRPG_PLUGIN_PATH. An unknown name is a restirpg.WrongValueError.
"""

import functools
import re
from pathlib import Path

import numpy as np

import restirpg
from restirpg.nearest import did_you_mean

_SCALARS = {"uint": "<u4", "int": "<i4", "float": "<f4", "Address": "<u8", "uint64_t": "<u8"}
_VECTORS: dict[str, tuple[str, tuple[int, ...]]] = {
    **{
        f"{letter}vec{n}": (kind, (n,)) for letter, kind in (("", "<f4"), ("i", "<i4"), ("u", "<u4")) for n in (2, 3, 4)
    },
    "mat2": ("<f4", (2, 2)),
    "mat4x3": ("<f4", (4, 3)),  # columns
}


@functools.cache
def _headers():
    """The headers' text without comments. They are those that the framework was compiled with."""
    root = restirpg.GRAPHS.parent  # of a clone, or share/restirpg of an installed tree
    folder = next(path for path in (root / "shaders", root / "framework" / "shaders") if path.is_dir())
    installed = root.parents[1] / "lib" / "restirpg" / "passes"
    passes = installed if installed.is_dir() else root / "passes"
    return _text([*sorted(folder.rglob("*_types.h")), *sorted(passes.glob("*/Shared.h"))])


def _text(files):
    return re.sub(r"//.*", "", "\n".join(file.read_text() for file in files))


def _headers_of_other_passes():
    """The text of those that the plugin path adds, which may change; empty without the binding module."""
    try:
        places = restirpg.code_paths()
    except AttributeError:
        return ""
    files = [Path(place) / "Shared.h" for place in places]
    return _text([file for file in files if file.is_file()])


def _refuse(message):
    raise getattr(restirpg, "WrongValueError", ValueError)(message)


def names():
    """Of all records of the framework and of its own passes."""
    return list(_records(_headers()))


def _records(headers):
    """{record: the text of its members}."""
    return dict(re.findall(r"^struct (\w+) \{(.*?)\};", headers, re.MULTILINE | re.DOTALL))


def _constants(headers):
    """{constant: the text of its value}."""
    declared = ",".join(re.findall(r"RESTIRPG_CONST ([^;#]*=[^;]*);", headers))
    return dict(re.findall(r"(\w+)\s*=\s*([^,]+)", declared))


def _found(kind, name, read):
    """What is read under that name, and all that is read from the same headers."""
    known = read(_headers())
    if name not in known:
        known = {**read(_headers_of_other_passes()), **known}
    if name not in known:
        _refuse(f"there is no {kind} '{name}'; there are: {', '.join(known)}{did_you_mean(name, known)}")
    return known[name]


def constant(name):
    """A whole number of the headers: RESTIRPG_CONST."""
    text = _found("constant", name, _constants).strip()
    if not re.fullmatch(r"[\w\s+*<|()-]*", text):
        _refuse(f"constant '{name}' = {text}: no sum, product or shift of whole numbers")
    numbers = re.sub(r"\b(0x[0-9a-fA-F]+|\d+)[uU]\b", r"\1", text)
    others = {word: constant(word) for word in re.findall(r"\b[A-Za-z_]\w*", numbers)}
    return eval(numbers, {"__builtins__": {}}, others)


def record(name, **views):
    """The dtype of a record.

    views: members that are read as another type of the same size, or as a list of fields that take their place.
    """
    fields = []
    for statement in filter(None, map(str.strip, _found("record", name, _records).split(";"))):
        declared = re.fullmatch(r"(\w+) (\w+)(?:\[(\w+)\])?", statement)
        if not declared:
            _refuse(f"record '{name}': '{statement}' is not TYPE MEMBER or TYPE MEMBER[COUNT]; write one member a line")
        kind, member, count = declared.groups()
        shape = (int(count) if count.isdigit() else constant(count),) if count else ()
        if kind in _SCALARS:
            added = [(member, _SCALARS[kind], shape)]
        elif kind in _VECTORS:
            added = [(member, _VECTORS[kind][0], (*shape, *_VECTORS[kind][1]))]
        else:
            added = [(member, record(kind), shape)]
        if member in views:
            added = _seen_as(added, views.pop(member))
        fields += added
    if views:
        raise TypeError(f"{name} has no member {', '.join(views)}")
    return np.dtype(fields, align=True)  # as C++ aligns them, and so scalar block layout


def fields_of(dtype):
    """As a list: a view that spreads a record within another one."""
    return [(name, dtype[name]) for name in dtype.names]


def _seen_as(field, view):
    """The fields that a member's bytes are read as."""
    [(member, kind, shape)] = field
    size = np.dtype((kind, shape)).itemsize
    if isinstance(view, str):
        count = size // np.dtype(view).itemsize
        view = [(member, view, (count,) if count > 1 else ())]
    assert np.dtype(view).itemsize == size, f"{member} has {size} bytes"
    return view
