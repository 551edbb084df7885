"""Describe a render graph: passes, the edges between their ports, knobs and the graph's outputs.

A description is plain data. `Graph.description()` returns it as a dictionary, the C++ side reads it as JSON
and checks it against what each pass declares::

    {
      "name": "Path tracer",
      "file": "graphs/path_tracer.py",
      "passes": [
        {"name": "gbuffer", "type": "GBuffer", "file": "graphs/path_tracer.py", "line": 5,
         "inputs": {}, "knobs": {"jitter": true}},
        {"name": "accumulate", "type": "Accumulate", "file": "graphs/path_tracer.py", "line": 9,
         "inputs": {"direct": {"pass": "paths", "output": "radiance"},
                    "indirect": null,
                    "history": {"pass": "accumulate", "output": "sums", "delayed": true}},
         "knobs": {}}
      ],
      "outputs": [
        {"name": "image", "pass": "accumulate", "output": "mean",
         "file": "graphs/path_tracer.py", "line": 11}
      ]
    }

`null` is an input left unwired on purpose; `delayed` (default false) reads the resource as it was one frame
ago; `file` and `line` are optional and serve error messages only. A file written by hand may leave out empty
`inputs` and `knobs`.
"""

import math
import os
import sys
from dataclasses import dataclass

MOST_PASSES = 1000  # as framework/graph/description.cpp has it

_PACKAGE = os.path.dirname(os.path.abspath(__file__))


class GraphError(ValueError):
    """A mistake in a graph file that shows before the passes are known."""


def shown_path(path):
    """`path` as an error message shows it: relative to the working directory where it lies below it. Bytes that are no
    UTF-8 become \\xff: JSON cannot hold them."""
    absolute = os.path.abspath(path)
    relative = os.path.relpath(absolute)
    shown = absolute if relative.startswith(os.pardir) else relative
    return os.fsencode(shown).decode("utf-8", "backslashreplace")


def _caller():
    """Where the innermost function outside this package was called: {"file", "line"}."""
    frame = sys._getframe(1)
    while frame.f_back and os.path.dirname(os.path.abspath(frame.f_code.co_filename)) == _PACKAGE:
        frame = frame.f_back
    return {"file": shown_path(frame.f_code.co_filename), "line": frame.f_lineno}


@dataclass(frozen=True)
class Port:
    """An output of a pass, this frame's or (delayed) the frame before's."""

    pass_name: str
    output: str
    delayed: bool = False

    def source(self):
        """The port as the description has it."""
        source = {"pass": self.pass_name, "output": self.output}
        if self.delayed:
            source["delayed"] = True
        return source


class PassNode:
    """A pass of a graph. Its attributes are its outputs: `gbuffer.surface`."""

    def __init__(self, name):
        self._name = name

    def __getattr__(self, output):
        if output.startswith("_"):
            raise AttributeError(output)
        return Port(self._name, output)

    def __repr__(self):
        return f"<pass '{self._name}'>"


def prev(port):
    """`port`, a Port or "pass.output", as it was one frame ago; zero on the first frame and after a cut.

    The pass may be one that is added later: this is how a graph feeds back.
    """
    if isinstance(port, Port):
        return Port(port.pass_name, port.output, delayed=True)
    name, dot, output = port.partition(".") if isinstance(port, str) else ("", "", "")
    if not (name and dot and output) or "." in output:
        raise GraphError(f'prev() takes "pass.output" or a port, not {port!r}')
    return Port(name, output, delayed=True)


def _knob_value(name, value):
    """`value` as JSON has it, or a GraphError."""
    if hasattr(value, "item") and getattr(value, "shape", None) == ():
        value = value.item()  # a NumPy scalar
    if isinstance(value, PassNode):
        raise GraphError(f"'{name}' is given the pass {value!r}; name one of its outputs, as in pass.output")
    if not isinstance(value, (bool, int, float, str)):
        raise GraphError(f"'{name}' is given a {type(value).__name__}; knobs are numbers, booleans or text")
    if isinstance(value, float) and not math.isfinite(value):
        raise GraphError(f"'{name}' is given {value}; knobs are finite")
    return value


class Graph:
    """A render graph: passes in the order of `add`, and named outputs, the first of which is the picture."""

    def __init__(self, name):
        if not isinstance(name, str):
            raise GraphError(f"a graph's name is text, not {name!r}")
        self.name = name
        self.file = _caller()["file"]
        self._passes = []
        self._nodes = {}
        self._outputs = []

    def add(self, name, pass_type, /, **wiring):
        """Add the pass `name`, an instance of the plugin `pass_type`, and return it.

        A keyword whose value is a Port wires an input, one whose value is None leaves an optional input
        unwired, any other sets a knob. Whether the pass has them is checked when the graph is loaded.
        """
        if len(self._passes) == MOST_PASSES:
            raise GraphError(f"a graph has at most {MOST_PASSES} passes")
        if not isinstance(name, str) or not isinstance(pass_type, str):
            raise GraphError(f"a pass has a name and a type, both text, not {name!r} and {pass_type!r}")
        inputs, knobs = {}, {}
        for key, value in wiring.items():
            if value is None or isinstance(value, Port):
                inputs[key] = value.source() if value else None
            else:
                knobs[key] = _knob_value(key, value)
        self._passes.append({"name": name, "type": pass_type, **_caller(), "inputs": inputs, "knobs": knobs})
        self._nodes[name] = PassNode(name)
        return self._nodes[name]

    def __getitem__(self, name):
        """The pass added under `name`."""
        if name not in self._nodes:
            added = ", ".join(self._nodes) or "none"
            raise GraphError(f"no pass '{name}' has been added yet; passes so far: {added}")
        return self._nodes[name]

    def output(self, name, port):
        """Make `port` readable under `name`. The first is the picture an EXR holds as plain R, G, B."""
        if not isinstance(name, str):
            raise GraphError(f"the name of an output is text, not {name!r}")
        if not isinstance(port, Port) or port.delayed:
            raise GraphError(f"output '{name}' must be an output of a pass, as in accumulate.mean, not {port!r}")
        if len(self._outputs) == MOST_PASSES:
            raise GraphError(f"a graph has at most {MOST_PASSES} outputs")
        self._outputs.append({"name": name, **port.source(), **_caller()})

    def description(self):
        """The graph as a dictionary; the schema stands at the top of this module."""
        return {"name": self.name, "file": self.file, "passes": self._passes, "outputs": self._outputs}
