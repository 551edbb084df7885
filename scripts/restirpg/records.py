"""The records that kernels write, as NumPy sees them:
`renderer.read_port("reuse.vertices").view(record("PathVertex"))`.

Layouts and constants are read from the headers that C++ and GLSL share: framework/shaders/*_types.h and the passes'
Shared.h.
"""

import functools
import re

import numpy as np

import restirpg

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
    files = [*sorted(folder.rglob("*_types.h")), *sorted(passes.glob("*/Shared.h"))]
    return re.sub(r"//.*", "", "\n".join(file.read_text() for file in files))


def names():
    """Of all records."""
    return re.findall(r"^struct (\w+)", _headers(), re.MULTILINE)


def constant(name):
    """A whole number of the headers: RESTIRPG_CONST."""
    value, _, shift = re.search(rf"RESTIRPG_CONST {name} = ([^;]*);", _headers())[1].replace("u", "").partition("<<")
    return int(value, 0) << int(shift or 0)


def record(name, **views):
    """The dtype of a record.

    views: members that are read as another type of the same size, or as a list of fields that take their place.
    """
    body = re.search(rf"^struct {name} \{{(.*?)\}};", _headers(), re.MULTILINE | re.DOTALL)[1]
    fields = []
    for kind, member, count in re.findall(r"(\w+) (\w+)(?:\[(\d+)\])?;", body):
        shape = (int(count),) if count else ()
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
