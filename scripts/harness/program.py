"""What the harness's programs share: arguments of the command line, and how each ends."""

import argparse
import sys

from harness import UserError
from harness.display import Display


def size(text):
    """`WxH` in pixels."""
    width, _, height = text.partition("x")
    if not (width.isdigit() and height.isdigit() and 8 <= int(width) <= 16384 and 8 <= int(height) <= 16384):
        raise argparse.ArgumentTypeError(f"'{text}' is not WIDTHxHEIGHT of at least 8x8, as in 160x90")
    return int(width), int(height)


def positive(text):
    """A whole number of at least 1."""
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of at least 1")
    return int(text)


def bounces(text):
    """A bounce cap: a whole number from 0 on, which is direct light alone."""
    if not text.isdigit():
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of at least 0")
    return int(text)


def frame_numbers(text):
    """`K,K,...`, ascending, counted from 1."""
    parts = text.split(",")
    numbers = tuple(int(part) for part in parts if part.isdigit())
    if len(numbers) != len(parts) or numbers != tuple(sorted(set(numbers))) or numbers[0] < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is no ascending list of frames from 1 on, as in 1,8,16")
    return numbers


def add_runner(parser, out):
    """Arguments of who runs the jobs and where results go; `out`: the default folder."""
    parser.add_argument(
        "--jobs",
        type=positive,
        default=1,
        help="runs at a time: more than one spoils the times (%(default)s)",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="run on the workers of this Dask scheduler, as tcp://head:8786, in place of --jobs; they must see "
        "the repository, its build, scenes, graphs and the cache under the same paths",
    )
    parser.add_argument("--out", default=out, help="folder of the report, CSV and EXR files (%(default)s)")
    parser.add_argument("--cache", help="folder of finished runs (OUT/cache)")


def run(name, body):
    """body(display)'s exit code; 2 and one line for a user's mistake, 130 after Ctrl-C."""
    display = Display()
    try:
        return body(display)
    except UserError as error:
        display.stop()
        print(f"{name}: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        display.stop()
        print(f"{name}: {error}; choose another folder with --out", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        display.stop()
        print("\ninterrupted; finished runs are kept: the same command goes on from here", file=sys.stderr)
        return 130
