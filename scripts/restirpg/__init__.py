"""restirpg: light transport methods as render graphs.

`Graph` and `prev` describe a graph in plain Python and need nothing else. The renderer (`load_scene`,
`load_graph`, `Renderer`, ...) lives in the binding module `restirpg._native`, which is loaded at the first
use of one of its names: describing a graph must not need a GPU, a driver or a built tree.
"""

import importlib
import os
from pathlib import Path
from typing import TYPE_CHECKING

from restirpg.denoising import denoise, have_denoiser
from restirpg.graph import Graph, GraphError, Port, prev

if TYPE_CHECKING:
    from restirpg._native import *

__all__ = [
    "COMMIT", "Error", "GRAPHS", "Graph", "GraphDescription", "GraphError", "MissingFileError", "PLUGIN_ABI", "Port", "Renderer",
    "Scene", "WrongIndexError", "WrongValueError", "code_paths", "denoise", "describe_pass", "devices", "have_denoiser",
    "load_graph", "load_scene", "measure_errors", "prev", "read_exr", "read_exr_attributes", "view", "write_exr", "write_png",
]  # fmt: skip

_folder = os.path.dirname(os.path.realpath(__file__))
_root = os.path.dirname(os.path.dirname(_folder))  # of a clone, or share/restirpg of an installed tree
_in_wheel = os.path.join(_folder, "share", "restirpg", "graphs")
#: The folder of the graph files that come with the package.
GRAPHS = Path(_in_wheel if os.path.isdir(_in_wheel) else os.path.join(_root, "graphs"))


def _build_folders():
    """Where a clone finds its binding module: along PYTHONPATH, and in the build tree."""
    build = os.path.join(os.environ.get("RESTIRPG_BUILD") or os.path.join(_root, "build"), "python")
    given = [folder for folder in os.environ.get("PYTHONPATH", "").split(os.pathsep) if folder]
    return [os.path.join(os.path.abspath(folder), "restirpg") for folder in (*given, build)]


# An installed package has it in its own folder, which comes first.
__path__ += _build_folders()


def _load_native():
    return importlib.import_module("restirpg._native")


def __getattr__(name):
    """`view`, and names of the binding module (PEP 562)."""
    if name == "_native" or name.startswith("__") and name != "__version__":
        raise AttributeError(f"module 'restirpg' has no attribute '{name}'")
    if name == "view":
        return importlib.import_module("restirpg.viewer").view
    try:
        native = _load_native()
    except ImportError as error:
        raise AttributeError(
            f"restirpg.{name} needs the binding module restirpg._native: {error}; "
            "build it with scripts/run, or name its build folder in RESTIRPG_BUILD"
        ) from error
    return getattr(native, name)


def __dir__():
    return sorted(__all__)
