"""restirpg: light transport methods as render graphs.

`Graph` and `prev` describe a graph in plain Python and need nothing else. The renderer (`load_scene`,
`load_graph`, `Renderer`, ...) lives in the binding module `restirpg._native`, which is loaded at the first
use of one of its names: describing a graph must not need a GPU, a driver or a built tree.
"""

import importlib

from restirpg.graph import Graph, GraphError, Port, prev

__all__ = ["Graph", "GraphError", "Port", "prev"]


def _load_native():
    return importlib.import_module("restirpg._native")


def __getattr__(name):
    """Names of the binding module (PEP 562)."""
    if name.startswith("__") or name == "_native":
        raise AttributeError(f"module 'restirpg' has no attribute '{name}'")
    try:
        native = _load_native()
    except ImportError as error:
        raise AttributeError(
            f"restirpg.{name} needs the binding module restirpg._native: {error}; "
            "build the project and put <build>/python first on PYTHONPATH") from error
    return getattr(native, name)


def __dir__():
    try:
        return sorted({*__all__, *(name for name in dir(_load_native()) if not name.startswith("_"))})
    except ImportError:
        return sorted(__all__)
