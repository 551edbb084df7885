#!/usr/bin/python3
"""Write the embedded scenes: a .glb each, and its .hdr sky where it has one. The same bytes on every run."""

import argparse
import pathlib
import sys

try:
    from harness import UserError, files
    from scenes import SCENES
except ModuleNotFoundError as missing:
    print(f"make_scenes.py: {sys.executable} lacks '{missing.name}': use a Python with NumPy",
          file=sys.stderr)
    sys.exit(2)

DEFAULT_FOLDER = pathlib.Path(__file__).resolve().parent.parent / "out" / "scenes"


class OneLineParser(argparse.ArgumentParser):
    """Reports a wrong argument in one line."""

    def error(self, message):
        self.exit(2, f"make_scenes.py: {message}\n")


def parse_arguments():
    """The command line's names (checked) and folder."""
    parser = OneLineParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="scenes to write (default: all)")
    parser.add_argument("--out", type=pathlib.Path, default=DEFAULT_FOLDER, metavar="DIR",
                        help="folder to write to, made if missing (default: out/scenes of the repository)")
    parser.add_argument("--list", action="store_true", help="list the scenes, with what each one is for")
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in SCENES:
            parser.error(f"no scene '{name}'; there are: {', '.join(SCENES)}")
    return arguments


def main():
    """Write or list the scenes."""
    arguments = parse_arguments()
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


if __name__ == "__main__":
    sys.exit(main())
