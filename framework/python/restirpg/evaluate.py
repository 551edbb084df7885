"""Evaluate a graph file: `python3 -m restirpg.evaluate FILE` prints the description of its `graph` as JSON.

The program runs this in a process of its own, so that a graph file can do neither it nor the next file any
harm. A mistake in the file is one line `FILE:LINE: message` on standard error and exit code 2.
"""

import contextlib
import json
import os
import sys
import traceback

from restirpg.graph import Graph, GraphError, shown_path


class EvaluationError(Exception):
    """A located, one-line message for the user."""


def _place(error, file):
    """"FILE:LINE" of the innermost line of the graph file's own folder in the error's traceback."""
    if isinstance(error, SyntaxError) and error.filename:
        return f"{shown_path(error.filename)}:{error.lineno or 1}"
    folder = os.path.dirname(os.path.abspath(file))
    own = [entry for entry in traceback.extract_tb(error.__traceback__)
           if os.path.dirname(os.path.abspath(entry.filename)) == folder]
    return f"{shown_path(own[-1].filename)}:{own[-1].lineno}" if own else f"{shown_path(file)}:1"


def _message(error):
    """What went wrong, in one line; Python's own errors keep their class name."""
    text = " ".join(str(error.msg if isinstance(error, SyntaxError) else error).split())
    if isinstance(error, GraphError):
        return text
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def evaluate(file):
    """The Graph that `file` leaves in its variable `graph`. Raises EvaluationError.

    The folder of `file` is first on the module path, so that its graph files can share a module. What the
    file prints goes to standard error.
    """
    try:
        with open(file, "rb") as stream:
            source = stream.read()
    except OSError as error:
        raise EvaluationError(f"{shown_path(file)}: cannot read the graph file: {error.strerror}") from error
    sys.path.insert(0, os.path.dirname(os.path.abspath(file)))
    names = {"__name__": "__graph__", "__file__": file}
    try:
        with contextlib.redirect_stdout(sys.stderr):
            exec(compile(source, file, "exec"), names)
    except (Exception, SystemExit) as error:
        raise EvaluationError(f"{_place(error, file)}: {_message(error)}") from error
    graph = names.get("graph")
    if not isinstance(graph, Graph):
        found = "has no variable 'graph'"
        if graph is not None:
            found = f"has a {type(graph).__name__} in its variable 'graph'"
        raise EvaluationError(f"{shown_path(file)}:1: the file {found}; "
                              "end it with graph = ..., a restirpg.Graph")
    return graph


def main(arguments):
    """The command line. Returns the exit code."""
    if len(arguments) != 1:
        print("usage: python3 -m restirpg.evaluate FILE", file=sys.stderr)
        return 2
    try:
        text = json.dumps(evaluate(arguments[0]).description(), indent=1, allow_nan=False)
    except EvaluationError as error:
        print(error, file=sys.stderr)
        return 2
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
