"""The pure-Python half: describing a graph needs no GPU and no binding module."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from restirpg import Graph, GraphError, Port, prev

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "scripts"


def evaluate(file, folder):
    """Run the evaluator as the program does. Returns (exit code, standard output, standard error)."""
    done = subprocess.run(
        [sys.executable, "-B", "-m", "restirpg.evaluate", str(file)],
        cwd=folder,
        text=True,
        capture_output=True,
        env={**os.environ, "PYTHONPATH": str(PACKAGE)},
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def refusal(tmp_path, text):
    """The one line on standard error for the graph file g.py with this text."""
    (tmp_path / "g.py").write_text(text)
    code, output, errors = evaluate("g.py", tmp_path)
    assert code == 2 and output == "" and errors.count("\n") == 1
    return errors.rstrip("\n")


def test_keywords_become_inputs_and_knobs():
    graph = Graph("G")
    gbuffer = graph.add("gbuffer", "GBuffer", jitter=True)
    graph.add(
        "paths",
        "Paths",
        surface=gbuffer.surface,
        guide=prev("fit.guide"),
        other=None,
        cells="world",
        bounces=8,
    )
    described = graph.description()["passes"]
    assert described[0]["inputs"] == {} and described[0]["knobs"] == {"jitter": True}
    assert described[1]["inputs"] == {
        "surface": {"pass": "gbuffer", "output": "surface"},
        "guide": {"pass": "fit", "output": "guide", "delayed": True},
        "other": None,
    }
    assert described[1]["knobs"] == {"cells": "world", "bounces": 8}


def test_places_are_those_of_the_calls():
    graph = Graph("G")
    line = sys._getframe().f_lineno + 1
    node = graph.add("a", "A", bounces=3)
    graph.output("image", node.mean)
    described = graph.description()
    assert described["passes"][0]["line"] == line
    assert described["outputs"][0]["line"] == line + 1
    assert os.path.abspath(described["passes"][0]["file"]) == os.path.abspath(__file__)


def test_a_pass_is_found_by_name():
    graph = Graph("G")
    added = graph.add("a", "A")
    assert graph["a"] is added
    assert graph["a"].mean == Port("a", "mean")
    with pytest.raises(GraphError, match="no pass 'b' has been added yet; passes so far: a"):
        graph["b"]


def test_knobs_may_be_called_name_or_type():
    graph = Graph("G")
    graph.add("a", "A", name="x", type="y")
    assert graph.description()["passes"][0]["knobs"] == {"name": "x", "type": "y"}


def test_numpy_scalars_are_knobs():
    numpy = pytest.importorskip("numpy", reason="NumPy is not installed; the graph half works without it")
    graph = Graph("G")
    graph.add("a", "A", x=numpy.float32(0.5), n=numpy.int64(3), b=numpy.bool_(True))
    assert json.loads(json.dumps(graph.description()))["passes"][0]["knobs"] == {"x": 0.5, "n": 3, "b": True}


@pytest.mark.parametrize(
    "value, message",
    [
        ([1], "'knob' is given a list; knobs are numbers, booleans or text"),
        (float("nan"), "'knob' is given nan; knobs are finite"),
        (
            Graph("other").add("b", "B"),
            "'knob' is given the pass <pass 'b'>; name one of its outputs, as in pass.output",
        ),
    ],
)
def test_what_no_knob_can_hold_is_refused(value, message):
    with pytest.raises(GraphError) as error:
        Graph("G").add("a", "A", knob=value)
    assert str(error.value) == message


@pytest.mark.parametrize("argument", ["fit", "fit.", ".guide", "a.b.c", "", 3, None])
def test_prev_takes_a_pass_and_an_output(argument):
    with pytest.raises(GraphError, match=r'prev\(\) takes "pass.output" or a port, not '):
        prev(argument)


def test_prev_delays_a_port():
    assert prev(Port("a", "b")) == prev("a.b") == Port("a", "b", delayed=True)


@pytest.mark.parametrize("port", ["accumulate.mean", None, Port("a", "b", delayed=True)])
def test_outputs_are_undelayed_ports(port):
    with pytest.raises(GraphError, match="output 'image' must be an output of a pass"):
        Graph("G").output("image", port)


def test_graph_files_of_a_folder_share_modules(tmp_path):
    (tmp_path / "graphs").mkdir()
    (tmp_path / "graphs" / "pipeline.py").write_text(
        "from restirpg import Graph\n\ndef pipeline(n):\n    g = Graph('G')\n    g.add('a', 'A', n=n)\n    return g\n"
    )
    (tmp_path / "graphs" / "g.py").write_text("from pipeline import pipeline\nprint('hello')\ngraph = pipeline(3)\n")
    code, output, errors = evaluate("graphs/g.py", tmp_path)
    assert (code, errors) == (0, "hello\n")
    added = json.loads(output)["passes"][0]
    assert (added["file"], added["line"], added["knobs"]) == (
        os.path.join("graphs", "pipeline.py"),
        5,
        {"n": 3},
    )
    assert sorted(os.listdir(tmp_path / "graphs")) == ["g.py", "pipeline.py"]


def test_mistakes_are_one_located_line(tmp_path):
    start = "from restirpg import Graph, prev\ng = Graph('G')\n"
    assert refusal(tmp_path, start + "prev('x')\n") == "g.py:3: prev() takes \"pass.output\" or a port, not 'x'"
    assert refusal(tmp_path, start + "1 / 0\n") == "g.py:3: ZeroDivisionError: division by zero"
    assert refusal(tmp_path, start + "import nosuch\n") == "g.py:3: ModuleNotFoundError: No module named 'nosuch'"
    assert refusal(tmp_path, start + "raise ValueError('two\\nlines')\n") == "g.py:3: ValueError: two lines"
    assert refusal(tmp_path, start + "import json; json.loads('x')\n").startswith("g.py:3: JSONDecodeError: ")
    assert refusal(tmp_path, start + "def f(:\n") == "g.py:3: SyntaxError: invalid syntax"
    assert refusal(tmp_path, "\0") == "g.py:1: ValueError: source code string cannot contain null bytes"
    assert refusal(tmp_path, "from restirpg import Graph\n\ngraph = Graph(b'x')\n") == (
        "g.py:3: a graph's name is text, not b'x'"
    )
    assert refusal(tmp_path, start + "graph = g\ng.name = b'x'\n") == (
        "g.py:1: TypeError: Object of type bytes is not JSON serializable"
    )
    assert refusal(tmp_path, start) == (
        "g.py:1: the file has no variable 'graph'; end it with graph = ..., a restirpg.Graph"
    )


def test_a_mistake_in_a_shared_module_is_located_there(tmp_path):
    (tmp_path / "shared.py").write_text("def f():\n    return undefined\n")
    assert refusal(tmp_path, "import shared\nshared.f()\n") == "shared.py:2: NameError: name 'undefined' is not defined"


def test_a_missing_file_is_one_line(tmp_path):
    code, _, errors = evaluate("none.py", tmp_path)
    assert (code, errors) == (2, "none.py: cannot read the graph file: No such file or directory\n")


def test_without_the_binding_module_the_renderer_is_refused_by_name():
    code = "import restirpg, sys; sys.modules['restirpg._native'] = None; restirpg.Renderer"
    done = subprocess.run(
        [sys.executable, "-B", "-c", code],
        env={**os.environ, "PYTHONPATH": str(PACKAGE)},
        text=True,
        capture_output=True,
        check=False,
    )
    assert "AttributeError: restirpg.Renderer needs the binding module restirpg._native" in done.stderr


@pytest.mark.parametrize(
    "file",
    [file for file in sorted((ROOT / "graphs").glob("*.py")) if "\ngraph = " in file.read_text()],
    ids=lambda file: file.name,
)
def test_every_graph_file_evaluates(file):
    assert evaluate(file, ROOT)[0] == 0
