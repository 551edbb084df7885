#!/usr/bin/python3
"""Tables of benchmarks/results, written from the CSV beside them.

    benchmarks/result_tables.py [--check] [PAGE.md ...]

A page marks a table by a comment, and this program writes the table below it:

    <!-- table: runs.csv frame=12 value=mape against=restir_pg -->

The file is the runs.csv of scripts/compare.py. Columns are its scenes, rows its methods: the mean over seeds of the
value at that frame, ± one standard error, and the change against a method, paired by seed. `value` is a column of the
file (mape, relmse, gpu_ms: per frame), `methods=a,b` and `scenes=a,b` choose and order. --check changes nothing and
says which tables are not what their file says.
"""

import argparse
import csv
import re
import sys
from pathlib import Path

from restirpg.harness import UserError, files, program, statistics

RESULTS = Path(__file__).resolve().parent / "results"
MARKED = re.compile(r"(<!-- table: (?P<file>\S+) (?P<options>.*?) -->\n)\n?(?:\|.*\n)*\n*")
OPTIONS = {"frame", "value", "against", "methods", "scenes"}


def read_runs(file, frame, value):
    """{(scene, method): {seed: value}} of one frame; gpu_ms becomes that of one frame."""
    runs = {}
    with open(file, newline="") as stream:
        for row in csv.DictReader(stream):
            if int(row["frame"]) == frame:
                number = float(row[value]) / (frame if value.endswith("_ms") else 1)
                runs.setdefault((Path(row["scene"]).stem, row["method"]), {})[int(row["seed"])] = number
    if not runs:
        raise UserError(f"{file}: no run has frame {frame}")
    return runs


def cell(runs, baseline, percent):
    """Mean ± standard error of {seed: value}, and the change against another such dictionary, in percent."""
    scale, unit = (100, "%") if percent else (1, "")
    mean, error = statistics.mean_se(list(runs.values()))
    digits = 1 if percent or mean >= 10 else 3
    text = f"{scale * mean:.{digits}f} ± {scale * error:.{digits}f}{unit}"
    seeds = sorted(runs.keys() & baseline.keys()) if baseline is not None else []
    if not seeds:
        return text
    quotient, error = statistics.ratio([runs[seed] for seed in seeds], [baseline[seed] for seed in seeds])
    return f"{text}, {100 * (quotient - 1):+.1f} ± {100 * error:.1f}%"


def table(folder, file, options):
    """The Markdown table that a marker asks for."""
    unknown = options.keys() - OPTIONS
    if unknown or not {"frame", "value"} <= options.keys():
        raise UserError(f"{folder / file}: a table takes {', '.join(sorted(OPTIONS))}; frame and value must be given")
    value, against = options["value"], options.get("against")
    runs = read_runs(folder / file, int(options["frame"]), value)
    chosen = {
        name: options[name].split(",") if name in options else list(dict.fromkeys(key[place] for key in runs))
        for place, name in enumerate(("scenes", "methods"))
    }
    lines = [["", *chosen["scenes"]], ["---"] * (len(chosen["scenes"]) + 1)]
    for method in chosen["methods"]:
        cells = [
            cell(runs[scene, method], None if method == against else runs.get((scene, against)), value == "mape")
            if (scene, method) in runs
            else "—"
            for scene in chosen["scenes"]
        ]
        lines.append([method, *cells])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def rewritten(page):
    """The page's text with its tables as their files give them."""

    def write(match):
        options = dict(option.partition("=")[::2] for option in match["options"].split())
        return f"{match[1]}\n{table(page.parent, match['file'], options)}\n"

    return MARKED.sub(write, page.read_text())


def main(arguments):
    """Write or check the pages. Returns 1 where a checked table is out of date."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", type=Path, nargs="*", help="Markdown files (default: all of benchmarks/results)")
    parser.add_argument("--check", action="store_true", help="change nothing, name the pages that would change")
    options = parser.parse_args(arguments)
    changed = [page for page in options.pages or sorted(RESULTS.rglob("*.md")) if page.read_text() != rewritten(page)]
    for page in changed:
        if not options.check:
            files.write(page, rewritten(page).encode())
        print(f"{page}: {'is not what its CSV says' if options.check else 'written'}")
    return 1 if changed and options.check else 0


if __name__ == "__main__":
    sys.exit(program.run("result_tables.py", lambda _: main(sys.argv[1:])))
