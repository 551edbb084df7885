#!/usr/bin/python3
"""Tables of benchmarks/results, written from the CSV beside them.

    benchmarks/result_tables.py [--check] [PAGE.md ...]

A page marks a table by a comment, and this program writes the table below it:

    <!-- table: runs.csv frame=12 value=mape against=restir_pg -->

The file is the runs.csv of scripts/compare.py. Columns are its scenes, rows its methods: the mean over seeds of the
value at that frame, ± one standard error, and the change against a method, paired by seed or tile. `value` is a column
of the file (mape, relmse; gpu_ms_total, in older files gpu_ms: per frame), `methods=a,b` and `scenes=a,b` choose and
order. --check changes nothing and says which tables are not what their file says.
"""

import argparse
import csv
import math
import re
import sys
from pathlib import Path

from restirpg.harness import UserError, files, program, statistics
from restirpg.nearest import did_you_mean

RESULTS = Path(__file__).resolve().parent / "results"
MARKED = re.compile(r"(<!-- table: (?P<file>\S+) (?P<options>.*?) -->\n)\n?(?:\|.*\n)*\n*")
OPTIONS = {"frame", "value", "against", "methods", "scenes"}


NAMES = ("scene", "method", "frame", "seed", "tile")  # columns that tell the rows apart


def check_name(page, option, name, names):
    """Raise UserError where a marker of the page names what its file does not have."""
    if name not in names:
        raise UserError(f"{page}: {option}={name}: there are: {', '.join(names)}{did_you_mean(name, names)}")


def read_runs(page, file, frame, value):
    """{(scene, method): {seed or tile: value}} of one frame of the page's file; summed times become those of one
    frame."""
    if not (frame.isascii() and frame.isdigit()):
        raise UserError(f"{page}: frame={frame}: it is a whole number, as in frame=12")
    try:
        with open(page.parent / file, newline="") as stream:
            rows = list(csv.DictReader(stream))
    except OSError as error:
        raise UserError(f"{page}: its file {page.parent / file} cannot be read: {error.strerror}") from None
    columns = list(rows[0]) if rows else []
    if not {*NAMES[:3]} <= set(columns):
        raise UserError(
            f"{page}: {file} is no runs.csv of scripts/compare.py: it lacks {', '.join(NAMES[:3])}, or a row"
        )
    check_name(page, "value", value, [name for name in columns if name not in NAMES])
    runs = {}
    for row in rows:
        if row["frame"] != frame:
            continue
        try:
            number = float(row[value]) / (int(frame) if value.endswith(("_ms", "_ms_total")) else 1)
        except ValueError:
            raise UserError(f"{page}: value={value}: '{row[value]}' in {file} is no number") from None
        runs.setdefault((Path(row["scene"]).stem, row["method"]), {})[
            int(row["tile"] if "tile" in row else row["seed"])
        ] = number
    if not runs:
        raise UserError(f"{page}: frame={frame}: no run of {file} has it")
    return runs


def cell(runs, baseline, percent):
    """Mean ± standard error of {seed: value}, and the change against another such dictionary, in percent."""
    scale, unit = (100, "%") if percent else (1, "")
    mean, error = statistics.mean_se(list(runs.values()))
    digits = 1 if percent or mean >= 10 else 3
    spread = "" if math.isnan(error) else f" ± {scale * error:.{digits}f}"
    text = f"{scale * mean:.{digits}f}{spread}{unit}"
    seeds = sorted(runs.keys() & baseline.keys()) if baseline is not None else []
    if not seeds:
        return text
    quotient, error = statistics.ratio([runs[seed] for seed in seeds], [baseline[seed] for seed in seeds])
    spread = "" if math.isnan(error) else f" ± {100 * error:.1f}"
    return f"{text}, {100 * (quotient - 1):+.1f}{spread}%"


def table(page, file, options):
    """The Markdown table that a marker of the page asks for."""
    unknown = options.keys() - OPTIONS
    if unknown or not {"frame", "value"} <= options.keys():
        raise UserError(f"{page}: a table takes {', '.join(sorted(OPTIONS))}; frame and value must be given")
    value, against = options["value"], options.get("against")
    runs = read_runs(page, file, options["frame"], value)
    chosen = {}
    for place, name in enumerate(("scenes", "methods")):
        known = list(dict.fromkeys(key[place] for key in runs))
        chosen[name] = options[name].split(",") if name in options else known
        for one in chosen[name]:
            check_name(page, name, one, known)
    if against is not None:
        check_name(page, "against", against, known)
    lines = [["", *chosen["scenes"]], ["---"] * (len(chosen["scenes"]) + 1)]
    for method in chosen["methods"]:
        cells = [
            cell(
                runs[scene, method], None if method == against else runs.get((scene, against)), value.startswith("mape")
            )
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
        return f"{match[1]}\n{table(page, match['file'], options)}\n"

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
