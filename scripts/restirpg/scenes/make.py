"""Write the embedded scenes: a .glb each, and its .hdr sky where it has one. The same bytes on every run."""

import argparse
import pathlib
import sys

from restirpg import commands
from restirpg.harness import UserError, files
from restirpg.scenes import SCENES

DEFAULT_FOLDER = pathlib.Path("out/scenes")


class OneLineParser(argparse.ArgumentParser):
    """Reports a wrong argument in one line."""

    def error(self, message):
        self.exit(2, f"make_scenes.py: {message}\n")


def parse(arguments):
    """The command line's names (checked) and folder."""
    parser = OneLineParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="scenes to write (default: all)")
    parser.add_argument("--out", type=pathlib.Path, default=DEFAULT_FOLDER, metavar="DIR",
                        help="folder to write to, made if missing (default: %(default)s)")
    parser.add_argument("--list", action="store_true", help="list the scenes, with what each one is for")
    arguments = commands.parsed(parser, arguments)
    for name in arguments.names:
        if name not in SCENES:
            parser.error(f"no scene '{name}'; there are: {', '.join(SCENES)}")
    return arguments


def main(arguments):
    """Write or list the scenes."""
    arguments = parse(arguments)
    if arguments.list:
        for name, build in SCENES.items():
            print(f"{name:24} {build.__doc__.splitlines()[0]}")
        return 0
    try:
        files.make_folder(arguments.out, "--out")
        for name in arguments.names or SCENES:
            print(SCENES[name]().write(arguments.out))
    except UserError as error:
        print(f"make_scenes.py: {error}", file=sys.stderr)
        return 2
    return 0
