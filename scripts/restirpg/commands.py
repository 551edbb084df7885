"""The commands of the package, each the `main` of a module that is imported when the command starts."""

import importlib
import os
import signal
import sys


def _run(module):
    """Call main(arguments) of the module. Returns the exit code."""
    if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # until program.run: no stack trace of what is being imported
    try:
        return importlib.import_module(module).main(sys.argv[1:])
    except ModuleNotFoundError as missing:
        name = os.path.basename(sys.argv[0])
        print(
            f"{name}: {sys.executable} lacks the module '{missing.name}': install it, or use another Python",
            file=sys.stderr,
        )
        return 2


def parsed(parser, arguments):
    """What parser.parse_args gives; where a shell asks for completions, they are the answer, by argcomplete."""
    if "_ARGCOMPLETE" in os.environ:
        import argcomplete

        argcomplete.autocomplete(parser)
    return parser.parse_args(arguments)


def program():
    """Run the program of an installed package in place of this process; its graph files are evaluated by this
    Python."""
    file = os.path.join(os.path.dirname(os.path.realpath(__file__)), "bin", "restirpg")
    os.environ.setdefault("RESTIRPG_PYTHON", sys.executable)
    os.execv(file, [file, *sys.argv[1:]])


def compare():
    """Compare methods."""
    return _run("restirpg.harness.compare")


def reproduce():
    """Reproduce the paper's evaluation."""
    return _run("restirpg.harness.reproduce")


def scenes():
    """Write the embedded scenes."""
    return _run("restirpg.scenes.make")


def see_guide():
    """Draw what guides the paths at some pixels."""
    return _run("restirpg.harness.see_guide")


def view():
    """Look at a scene through graphs, live."""
    return _run("restirpg.viewer.start")
