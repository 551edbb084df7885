"""restirpg: light transport methods as render graphs.

`Graph` and `prev` describe a graph in plain Python and need nothing else. The renderer (`load_scene`,
`load_graph`, `Renderer`, ...) lives in the binding module `restirpg._native`, which is loaded at the first
use of one of its names: describing a graph must not need a GPU, a driver or a built tree.
"""

import importlib
import os

from restirpg.denoising import denoise, have_denoiser
from restirpg.graph import Graph, GraphError, Port, prev

__all__ = ["Graph", "GraphError", "Port", "denoise", "have_denoiser", "prev"]


def _build_folders():
    """Where a clone finds its binding module: along PYTHONPATH, and in the build tree."""
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
    build = os.path.join(os.environ.get("RESTIRPG_BUILD") or os.path.join(root, "build"), "python")
    given = [folder for folder in os.environ.get("PYTHONPATH", "").split(os.pathsep) if folder]
    return [os.path.join(os.path.abspath(folder), "restirpg") for folder in (*given, build)]


# An installed package has it in its own folder, which comes first.
__path__ += _build_folders()


def _load_native():
    return importlib.import_module("restirpg._native")


def __getattr__(name):
    """`view`, and names of the binding module (PEP 562)."""
    if name.startswith("__") or name == "_native":
        raise AttributeError(f"module 'restirpg' has no attribute '{name}'")
    if name == "view":
        return importlib.import_module("restirpg.viewer").view
    try:
        native = _load_native()
    except ImportError as error:
        raise AttributeError(
            f"restirpg.{name} needs the binding module restirpg._native: {error}; "
            "build it with scripts/run, or name its build folder in RESTIRPG_BUILD") from error
    return getattr(native, name)


def __dir__():
    try:
        return sorted({*__all__, "view", *(name for name in dir(_load_native()) if not name.startswith("_"))})
    except ImportError:
        return sorted(__all__)
