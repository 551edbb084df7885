#!/usr/bin/python3
"""Kill programs at random moments, start them again until they are done, and compare what they then say.

    benchmarks/kills.py [--kills 50] [--seed 1] [--cases render compare reproduce] [--warm] [--markdown FILE]

Each case runs once undisturbed, which gives its numbers and how long it takes. Then its whole process group is
killed (SIGKILL) at a moment drawn evenly over that time (the shortest that a whole run took so far), started again in
the same folder, killed again ..., until it ends before its moment comes: a round. Numbers of a round must be those of
the undisturbed run: pixels of all pictures, errors of all runs; times are left out. The next round begins in an empty
folder, compiled kernels included; with --warm all rounds share their cache, so that what a kill does to it stays. Exit
code: 0; 1 when a number differs or a program fails; 2 for a mistake in what was asked.
"""

import argparse
import contextlib
import csv
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import clone

from restirpg.harness import UserError, files, program, render, scenes

SMALL = ["--size", "16x9", "--frames", "2", "--seeds", "2", "--reference-frames", "8", "--reference-batches", "2"]


def render_command(scene, folder):
    """A picture as EXR and PNG."""
    return [
        str(clone.program()),
        "render",
        str(clone.ROOT / "graphs" / "restir_pt.py"),
        "--scene",
        scene,
        "--size",
        "32x18",
        "--frames",
        "32",
        "-o",
        str(folder / "image.exr"),
        "--png",
        str(folder / "image.png"),
    ]


def compare_command(scene, folder):
    """Two methods, their runs, references and pictures."""
    graphs = [str(clone.ROOT / "graphs" / name) for name in ("path_tracer.py", "restir_di.py")]
    return [
        sys.executable,
        str(clone.ROOT / "scripts" / "compare.py"),
        *graphs,
        "--scenes",
        scene,
        *SMALL,
        "--out",
        str(folder),
    ]


def reproduce_command(scene, folder):
    """Runs of four methods, and calls."""
    what = ["figure", "5", "table", "1", "--quick", "--scenes", scene]
    return [sys.executable, str(clone.ROOT / "scripts" / "reproduce.py"), *what, *SMALL, "--out", str(folder)]


COMMANDS = {"render": render_command, "compare": compare_command, "reproduce": reproduce_command}


def numbers_in(folder):
    """{file: its content} of what a program left: pixels, PNG files of pictures alone, errors of runs and cells."""
    import restirpg

    found = {}
    for file in sorted(folder.rglob("*")):
        name = str(file.relative_to(folder))
        if file.suffix == ".exr":
            found[name] = restirpg.read_exr(file).tobytes()
        elif file.name == "image.png":
            found[name] = file.read_bytes()
        elif file.name in ("runs.csv", "table_1.csv"):
            with open(file, newline="") as stream:
                rows = list(csv.DictReader(stream))
            found[name] = [{key: value for key, value in row.items() if "_ms" not in key} for row in rows]
    return found


def unfinished_in(folder):
    """Names of what was being written, by Python or by C++, when a program was killed."""
    return sorted(file.name for name in ("*.part", ".restirpg-*.tmp") for file in folder.rglob(name))


@dataclass
class Outcome:
    """What became of a case."""

    seconds: float  # of the undisturbed run
    numbers: int  # files compared
    kills: int = 0
    rounds: int = 0
    wrong: list = field(default_factory=list)  # a line each


@contextlib.contextmanager
def started(command, environment):
    """The command in a process group of its own, which is killed at the end if it still runs."""
    process = subprocess.Popen(
        command, env=environment, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        process.stderr.close()


def run_to_end(command, environment, moment=None):
    """(seconds, line of failure or None) of a command that ended by itself; (None, None) where it had to be killed after
    `moment` seconds."""
    start = time.monotonic()
    with started(command, environment) as process:
        try:
            errors = process.communicate(timeout=moment)[1].splitlines()
        except subprocess.TimeoutExpired:
            return None, None
    failure = f"ended with {process.returncode}: {errors[-1] if errors else ''}" if process.returncode else None
    return time.monotonic() - start, failure


def kill_until_it_ends(command, environment, kills, draws, seconds):
    """Start the command until it ends by itself before a moment within `seconds`, or was killed `kills` times.
    Returns (how often it was killed, how long its end took or None, line of failure or None)."""
    for killed in range(kills):
        ended, failure = run_to_end(command, environment, draws.uniform(0, seconds))
        if ended is not None:
            return killed, ended, failure
    return kills, None, None


def fault_in(folder, found, right):
    """What is wrong with a round's folder, where these numbers were found: the end of a line, or ""."""
    if found != right:
        differing = sorted(name for name in right.keys() | found.keys() if right.get(name) != found.get(name))
        return f": {', '.join(differing)} differ"
    parts = unfinished_in(folder)
    return f": left {', '.join(parts)}" if parts else ""


def torture(command_for, folder, kills, draws, numbers, environment):
    """The Outcome of so many kills. command_for(folder): the command that works in that folder; draws: a random.Random;
    numbers(folder): what must be the same; environment(folder): its environment."""
    whole = folder / "whole"
    whole.mkdir(parents=True)
    seconds, failure = run_to_end(command_for(whole), environment(whole))
    if failure:
        raise UserError(f"{command_for(whole)[1]}: without any kill it {failure}")
    right = numbers(whole)
    outcome = Outcome(seconds, len(right))
    while outcome.kills < kills:
        own = folder / f"round_{outcome.rounds + 1}"
        own.mkdir()
        command, variables = command_for(own), environment(own)
        killed, ended, failure = kill_until_it_ends(command, variables, kills - outcome.kills, draws, seconds)
        outcome.kills += killed
        if killed == 0 and not failure:  # undisturbed: a machine that was busy at first must not make kills rare
            seconds = min(seconds, ended)
        if not failure:
            _, failure = run_to_end(command, variables)  # its end, or, after it, once more
        if not failure and unfinished_in(own):  # of a worker that outlived this start: the next one removes it
            _, failure = run_to_end(command, variables)
        outcome.rounds += 1
        if fault := f" {failure}" if failure else fault_in(own, numbers(own), right):
            outcome.wrong.append(f"round {outcome.rounds}{fault}")
        else:
            shutil.rmtree(own)
        if failure and killed == 0:  # it fails by itself now, and would for ever
            break
    return outcome


def with_caches(folder):
    """The environment of a program whose compiled kernels, ours and Mesa's, are kept below `folder` alone."""
    names = {"RESTIRPG_CACHE_DIR": folder / "kernels", "MESA_SHADER_CACHE_DIR": folder / "mesa"}
    for own in names.values():
        own.mkdir(parents=True, exist_ok=True)  # Mesa makes no parents, and would keep nothing
    return {**os.environ, **{name: str(own) for name, own in names.items()}}


def parse(arguments):
    """The command line as a namespace."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=program.positive, default=50, help="in all (%(default)s)")
    parser.add_argument("--seed", type=program.whole(0), default=1, help="of the moments (%(default)s)")
    parser.add_argument("--cases", nargs="+", choices=COMMANDS, default=list(COMMANDS), help="(all)")
    parser.add_argument("--warm", action="store_true", help="rounds share compiled kernels")
    parser.add_argument("--markdown", type=Path, help="file to write the table to")
    return parser.parse_args(arguments)


def main(arguments):
    """The command line. Returns the exit code."""
    options = parse(arguments)

    def body(_):
        render.find_package()
        if options.markdown:
            files.prepare(options.markdown, [], "--markdown")
        out = Path(tempfile.mkdtemp(prefix="restirpg-kills-"))
        scene = scenes.file_of("cornell_box", out)

        def environment(folder):
            # Not in the folder: what a kill leaves unfinished there stays until another kernel is written, which may be
            # never.
            return with_caches(out / "caches" / ("warm" if options.warm else folder.relative_to(out)))

        lines = [
            "| program | undisturbed | files compared | kills | rounds | rounds that differ or fail |",
            "| --- | --- | --- | --- | --- | --- |",
        ]
        wrong = []
        for number, case in enumerate(options.cases):
            share = options.kills // len(options.cases) + (number < options.kills % len(options.cases))
            outcome = torture(
                lambda folder: COMMANDS[case](scene, folder),  # noqa: B023  (called before the next case)
                out / case,
                share,
                random.Random(f"{options.seed} {case}"),
                numbers_in,
                environment,
            )
            wrong += [f"{case}, {line}" for line in outcome.wrong]
            lines.append(
                f"| {case} | {outcome.seconds:.1f} s | {outcome.numbers} | {outcome.kills} | {outcome.rounds} "
                f"| {len(outcome.wrong)} |"
            )
            print(lines[-1], flush=True)
        if options.markdown:
            files.write(options.markdown, "\n".join(lines) + "\n")
        if wrong:
            print("\n".join([*wrong, f"{out}: what is left of it"]))
            return 1
        shutil.rmtree(out)
        print(f"{options.kills} kills: the same numbers each time")
        return 0

    return program.run("kills.py", body)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
