"""What the harness's programs share: arguments of the command line, and how each ends."""

import argparse
import contextlib
import os
import signal
import sys
import tempfile
from pathlib import Path

from restirpg.harness import UserError, files
from restirpg.harness.cache import Cache
from restirpg.harness.display import Display
from restirpg.harness.motion import TURN
from restirpg.harness.workers import Pool, one_line

LARGEST = 10**6  # of counts on a command line: plans are made of each frame and run
ENDING = (signal.SIGINT, signal.SIGTERM)


def size(text):
    """`WxH` in pixels."""
    width, _, height = text.partition("x")
    number = text.isascii() and len(text) < 12 and width.isdigit() and height.isdigit()
    if not (number and 8 <= int(width) <= 16384 and 8 <= int(height) <= 16384):
        raise argparse.ArgumentTypeError(f"'{text}' is not WIDTHxHEIGHT of at least 8x8, as in 160x90")
    return int(width), int(height)


def whole(least):
    """The type of whole numbers from `least` on."""

    def number(text):
        if not (text.isascii() and text.isdigit() and len(text) < 8 and least <= int(text) <= LARGEST):
            raise argparse.ArgumentTypeError(
                f"'{text}' is not a whole number of at least {least} and at most {LARGEST}"
            )
        return int(text)

    return number


positive = whole(1)
bounces = whole(0)  # a cap of 0 is direct light alone


def length(text):
    """A positive number."""
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 0 < number < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is no positive number")
    return number


def frame_numbers(text):
    """`K,K,...`, ascending, counted from 1."""
    parts = text.split(",")
    numbers = tuple(int(part) for part in parts if part.isascii() and part.isdigit() and len(part) < 8)
    ascend = numbers == tuple(sorted(set(numbers)))
    if len(numbers) != len(parts) or not ascend or numbers[0] < 1 or numbers[-1] > LARGEST:
        raise argparse.ArgumentTypeError(f"'{text}' is no ascending list of frames from 1 on, as in 1,8,16")
    return numbers


def add_allow_outside(parser):
    """What a scene may read, as `restirpg render` has it."""
    parser.add_argument(
        "--allow-outside", action="store_true", help="let a scene read files that lie outside of its own folder"
    )


def add_motion(parser):
    """What a Motion is made of."""
    parser.add_argument(
        "--fps", type=length, default=0.0, metavar="F", help="play the scene's animation, F frames per second"
    )
    parser.add_argument(
        "--circle",
        type=length,
        default=0.0,
        metavar="METRES",
        help=f"move the camera on a circle of this radius in its image plane, {TURN} frames per turn",
    )


def add_runner(parser, out):
    """Arguments of who runs the jobs and where results go; `out`: the default folder."""
    parser.add_argument(
        "--jobs",
        type=positive,
        default=1,
        help="runs at a time; with more than one the measured times are too long (%(default)s)",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="run on the workers of this Dask scheduler, such as tcp://head:8786, in place of --jobs; they must see "
        "the repository, its build, scenes, graphs and the cache under the same paths",
    )
    parser.add_argument("--out", default=out, help="folder of the report, CSV and EXR files (%(default)s)")
    parser.add_argument("--cache", help="folder of finished runs (OUT/cache)")


class Interrupted(KeyboardInterrupt):
    """Ctrl-C, or SIGTERM. Its argument: what is kept."""

    signal = signal.SIGINT


def _interrupt(number, _):
    for ended in ENDING:  # a second one must not interrupt the ending
        signal.signal(ended, signal.SIG_IGN)
    error = Interrupted("nothing was kept")
    error.signal = number
    raise error


def _pool(folder, count, scheduler):
    """A Pool of `count` workers, or a Cluster at a Dask scheduler's address."""
    if not scheduler:
        return Pool(folder, count)
    from restirpg.harness.cluster import Cluster  # which a run without a scheduler does not need

    return Cluster(folder, scheduler)


@contextlib.contextmanager
def runner(options, display, count=None):
    """The cache and the pool that the command line asks for, `count` processes or those of --jobs."""
    with contextlib.ExitStack() as stack:
        folder = Path(options.cache or Path(options.out) / "cache")
        kept = f"are kept in {folder}: the same command goes on from here"
        try:
            files.make_folder(folder, "--cache")
        except UserError as error:
            if options.scheduler or folder.is_file():  # whose workers may see no other; a mistake
                raise
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="restirpg-")))
            kept = "are not kept"
            display.message(f"{error}; going on without it: finished runs will not be kept")
        cache = Cache(folder, display.message)
        pool = stack.enter_context(_pool(cache.folder, count or options.jobs, options.scheduler))
        try:
            yield cache, pool
        except Interrupted as error:
            error.args = (f"its {pool.finished} finished runs {kept}",)
            raise


@contextlib.contextmanager
def _interruptible():
    """Within, Ctrl-C and SIGTERM raise Interrupted, unless the process was started to ignore them. Afterwards they do
    what they did before: who called this may go on, and start programs, which would ignore what this process does."""
    before = {number: signal.getsignal(number) for number in ENDING}
    try:
        for number, handler in before.items():
            if handler != signal.SIG_IGN:
                signal.signal(number, _interrupt)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@_interruptible()
def run(name, body):
    """body(display)'s exit code; 2 and one line for a user's mistake; 130 after Ctrl-C and 143 after SIGTERM."""
    display = Display()
    try:
        return body(display)
    except UserError as error:
        display.stop()
        print(f"{name}: {one_line(error)}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # who read what is printed has ended
        display.stop()
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 2
    except (OSError, MemoryError) as error:
        display.stop()
        print(f"{name}: {one_line(error)}", file=sys.stderr)
        return 2
    except Interrupted as error:
        display.stop()
        print(f"\n{name}: interrupted by {signal.Signals(error.signal).name}; {error}", file=sys.stderr)
        return 128 + error.signal
