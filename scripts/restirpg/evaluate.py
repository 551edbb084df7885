"""Evaluate a graph file: `python3 -m restirpg.evaluate FILE [SECONDS]` prints the description of its `graph` as JSON.

The program runs this in a process of its own, so that a graph file can do neither it nor the next file any
harm. A mistake in the file is one line `FILE:LINE: message` on standard error and exit code 2.
"""

import contextlib
import json
import os
import resource
import signal
import sys
import traceback

import restirpg
from restirpg.graph import Graph, GraphError, shown_path


class EvaluationError(Exception):
    """A located, one-line message for the user."""


def _innermost(stack, file):
    """ "FILE:LINE" of the innermost line of the graph file's own folder in a traceback or stack."""
    folder = os.path.dirname(os.path.abspath(file))
    own = [entry for entry in stack if os.path.dirname(os.path.abspath(entry.filename)) == folder]
    return f"{shown_path(own[-1].filename)}:{own[-1].lineno}" if own else f"{shown_path(file)}:1"


def _place(error, file):
    """ "FILE:LINE" of what raised the error."""
    if isinstance(error, SyntaxError) and error.filename:
        return f"{shown_path(error.filename)}:{error.lineno or 1}"
    return _innermost(traceback.extract_tb(error.__traceback__), file)


def _message(error):
    """What went wrong, in one line; Python's own errors keep their class name."""
    text = " ".join(str(error.msg if isinstance(error, SyntaxError) else error).split())
    if isinstance(error, GraphError):
        return text
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def evaluate(file):
    """The Graph that `file` leaves in its variable `graph`. Raises EvaluationError.

    The folder of `file` is first on the module path, so that its graph files can share a module, and restirpg's own
    graphs are last: `from pipeline import pipeline` works anywhere. What the file prints goes to standard error.
    """
    try:
        with open(file, "rb") as stream:
            source = stream.read()
    except OSError as error:
        raise EvaluationError(f"{shown_path(file)}: cannot read the graph file: {error.strerror}") from error
    sys.path.insert(0, os.path.dirname(os.path.abspath(file)))
    sys.path.append(str(restirpg.GRAPHS))
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
        raise EvaluationError(f"{shown_path(file)}:1: the file {found}; end it with graph = ..., a restirpg.Graph")
    return graph


def as_json(graph, file):
    """The description of the graph of that file. Raises EvaluationError."""
    try:
        return json.dumps(graph.description(), indent=1, allow_nan=False)
    except Exception as error:  # of values that the file has put past Graph's own checks
        raise EvaluationError(f"{_place(error, file)}: {_message(error)}") from error


def _bound(file, seconds):
    """End this process, saying where it was, after so many seconds. Let it have half of the machine's memory at
    most."""

    def end(number, frame):
        # Not by an exception, which the file may catch.
        place = _innermost(traceback.extract_stack(frame), file)
        print(
            f"{place}: evaluating the graph file takes more than {seconds} s; look for a loop that does not end",
            file=sys.stderr,
            flush=True,
        )
        os._exit(2)

    signal.signal(signal.SIGALRM, end)
    signal.alarm(seconds)
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    given = [limit for limit in resource.getrlimit(resource.RLIMIT_AS) if limit != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min([memory, *given]),) * 2)


def main(arguments):
    """The command line. Returns the exit code."""
    file, seconds = (*arguments, "30")[:2] if arguments else ("", "")
    if len(arguments) > 2 or not seconds.isdecimal():
        print("usage: python3 -m restirpg.evaluate FILE [SECONDS]", file=sys.stderr)
        return 2
    _bound(file, int(seconds))
    try:
        text = as_json(evaluate(file), file)
    except EvaluationError as error:
        print(error, file=sys.stderr)
        return 2
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
