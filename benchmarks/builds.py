#!/usr/bin/python3
"""Compare two builds of the renderer: start-up, frames and passes, interleaved, as ratios with their spread.

    benchmarks/builds.py OLD_BUILD NEW_BUILD [--pairs 5] [--graphs ...] [--scenes ...] [--size 160x90] [--frames 8]
                         [--csv FILE]

OLD_BUILD and NEW_BUILD are build folders, the old one of another clone or worktree. A graph of this repository is read
from the clone that a build lies in, since ports and knobs may have other names there. The builds take turns (old, new,
old, new ...), so that what else the machine does meets both; each turn is a process of its own. Before the first turn
each build runs once uncounted, which fills its own cache of kernels (BUILD/cache/mesa). A ratio is old time over new
time of one pair: above 1 the new build is faster. Of the ratios the table has the geometric mean and, as spread, the
factor of one standard error of that mean.

Rows: `start`: making a renderer, warm caches; `second`: another one in the same process; `frame`: all passes (both of
them CPU seconds of the process and wall time); one row a pass, by the device's timestamps.
"""

import argparse
import csv
import io
import json
import math
import os
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def clocks():
    """CPU and wall ms so far."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return [1e3 * (used.ru_utime + used.ru_stime), 1e3 * time.perf_counter()]


def measure(graph, scene, size, frames):
    """Times of this process's build, in ms by row and clock."""
    import restirpg

    loaded, described, rows = restirpg.load_scene(scene), restirpg.load_graph(graph), {}

    def timed(row, work, divisor=1):
        before = clocks()
        result = work()
        for clock, start, end in zip(("CPU", "wall"), before, clocks()):
            rows[f"{row}, {clock}"] = (end - start) / divisor
        return result

    renderer = timed("start", lambda: restirpg.Renderer(loaded, described, size=size))
    renderer.render(2)  # kernels may be loaded at their first dispatch, and history is first used in the second frame
    before = dict(renderer.total_gpu_times())
    timed("frame", lambda: renderer.render(frames), frames)
    for name, after in renderer.total_gpu_times().items():
        rows[f"{name}, device"] = (after - before[name]) / frames
    timed("second", lambda: restirpg.Renderer(loaded, described, size=size))
    return rows


def graph_of(build, graph):
    """The file of that name among the graphs of the build's own clone; any other graph as it is."""
    own = Path(build).resolve().parent / "graphs" / Path(graph).name
    return str(own) if Path(graph).resolve().parent == ROOT / "graphs" and own.is_file() else graph


def package_of(build):
    """The folder of a build's Python package."""
    return Path(build) / "python"


def turn(build, case):
    """One measurement in a process of its own."""
    case = {**case, "graph": graph_of(build, case["graph"])}
    package = package_of(build)
    done = subprocess.run(
        [sys.executable, __file__, "--measure", json.dumps(case)],
        env={**os.environ, "PYTHONPATH": str(package), "MESA_SHADER_CACHE_DIR": str(package.parent / "cache/mesa")},
        capture_output=True,
        text=True,
    )
    if done.returncode != 0:
        from restirpg.harness import UserError

        raise UserError(f"{build}: {(done.stderr.strip() or 'it ended without a message').splitlines()[-1]}")
    return json.loads(done.stdout.splitlines()[-1])


def compare(pairs):
    """Rows of (name, old ms, new ms, ratio, spread) of (old, new) measurements."""
    rows = []
    for name in pairs[0][0]:
        if name not in pairs[0][1]:
            continue
        old, new = ([pair[side][name] for pair in pairs] for side in (0, 1))
        logs = [math.log(a / b) for a, b in zip(old, new) if a > 0 and b > 0]
        if len(logs) < 2:
            continue
        error = statistics.stdev(logs) / math.sqrt(len(logs))
        rows.append(
            (name, statistics.median(old), statistics.median(new), math.exp(statistics.mean(logs)), math.exp(error))
        )
    return rows


def parse(arguments):
    """The command line."""
    from restirpg.harness import program

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("old", help="build folder")
    add("new", help="build folder")
    add("--pairs", type=program.whole(2), default=5, help="(%(default)s)")
    add("--graphs", nargs="+", default=[str(ROOT / "graphs/restir_pg.py")], help="(%(default)s)")
    add("--scenes", nargs="+", default=[str(ROOT / "out/scenes/door_ajar.glb")], help="(%(default)s)")
    add("--size", type=program.size, default=(160, 90), metavar="WxH", help="pixels (160x90)")
    add("--frames", type=program.positive, default=8, help="(%(default)s)")
    add("--csv", metavar="FILE", help="write all rows there")
    return parser.parse_args(arguments)


def check(options):
    """Raise UserError where a build, a graph or a scene is not there, or the rows cannot be written."""
    from restirpg.harness import UserError, files

    builds = (options.old, options.new)
    for build in builds:
        if not package_of(build).is_dir():
            raise UserError(f"{build}: no build folder of restirpg: there is no {package_of(build)}; build it there")
    graphs = [graph_of(build, graph) for build in builds for graph in options.graphs]
    for file in [*graphs, *options.scenes]:
        if not Path(file).is_file():
            kind = "graph" if file in graphs else "scene; scripts/make_scenes.py writes the embedded ones to out/scenes"
            raise UserError(f"{file}: no such {kind}")
    if options.csv:
        files.prepare(options.csv, [*graphs, *options.scenes], "--csv")


def run(options):
    """Measure, print and write. Returns the exit code."""
    from restirpg.harness import files

    check(options)
    size = f"{options.size[0]}x{options.size[1]}"
    table = [("graph", "scene", "size", "row", "pairs", "old_ms", "new_ms", "ratio", "spread")]
    for graph in options.graphs:
        for scene in options.scenes:
            case = {"graph": graph, "scene": scene, "size": options.size, "frames": options.frames}
            for build in (options.old, options.new):
                turn(build, case)
            pairs = [(turn(options.old, case), turn(options.new, case)) for _ in range(options.pairs)]
            print(f"\n{Path(graph).stem}, {Path(scene).stem}, {size}, {options.pairs} pairs\n")
            print("| | old, ms | new, ms | old / new | spread |\n| --- | --- | --- | --- | --- |")
            for name, old, new, ratio, spread in compare(pairs):
                case_columns = (Path(graph).stem, Path(scene).stem, size, name, options.pairs)
                table.append((*case_columns, f"{old:.4g}", f"{new:.4g}", f"{ratio:.3f}", f"{spread:.3f}"))
                print(f"| {name} | {old:.4g} | {new:.4g} | {ratio:.2f} | x/ {spread:.3f} |", flush=True)
            if options.csv:  # case by case: what follows may fail
                stream = io.StringIO(newline="")
                csv.writer(stream, lineterminator="\n").writerows(table)
                files.write(options.csv, stream.getvalue())
    return 0


def main(arguments):
    """The command line. Returns the exit code."""
    import clone  # noqa: F401  (not at the top: a measuring process has an old build's package)

    from restirpg.harness import program

    options = parse(arguments)
    return program.run("builds.py", lambda _: run(options))


def measured(case):
    """Print the times as JSON, or end with a mistake in one line: what main's process reads."""
    import restirpg

    try:
        rows = measure(**case)
    except restirpg.Error as error:
        sys.exit(" ".join(str(error).split()))
    print(json.dumps(rows))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--measure"]:
        measured(json.loads(sys.argv[2]))
    else:
        sys.exit(main(sys.argv[1:]))
