#!/usr/bin/python3
"""Tables of README.md and benchmarks/results, written from the CSV beside them.

    benchmarks/result_tables.py [--check] [PAGE.md ...]

A page marks a table by a comment, and this program writes the table below it:

    <!-- table: runs.csv frame=12 value=mape against=restir_pg -->

The file is the runs.csv of scripts/compare.py, or has its columns scene, method, seed or tile, and values, without
frames. Columns are its scenes, rows its methods: the mean over seeds of the value at that frame, ± one standard error,
and the change against a method, paired by seed or tile. `value` is a column of the file (mape, relmse; gpu_ms_total, in
older files gpu_ms: per frame, in a file without frames as it is), `methods=a,b` and `scenes=a,b` choose and order, and
the name of a method or of a scene as an option gives it a title: restir_pt="no guiding".

With pairs=a/b,c/d in place of `against` and `methods` rows are scenes, columns the changes of a against b and of c
against d, ± one standard error, each with the p-value of the paired t-test, corrected by Holm's method for all tests of
the table. --check changes nothing and says which tables are not what their file says.
"""

import argparse
import csv
import math
import re
import shlex
import sys
from pathlib import Path

from clone import ROOT

from restirpg.harness import UserError, files, program, statistics
from restirpg.nearest import did_you_mean

MARKER = re.compile(r"<!--\s*table\b.*")  # also one that cannot be followed
MARKED = re.compile(r"(<!-- table: (?P<file>\S+)(?P<options>(?: .*?)?) -->\n)\n?(?:\|.*\n)*\n*")
OPTIONS = {"frame", "value", "against", "methods", "scenes", "pairs"}


NAMES = ("scene", "method", "frame", "seed", "tile")  # columns that tell the rows apart


def check_name(page, option, name, names):
    """Raise UserError where a marker of the page names what its file does not have."""
    if name not in names:
        raise UserError(f"{page}: {option}={name}: there are: {', '.join(names)}{did_you_mean(name, names)}")


def number_in(page, file, row, column):
    """A column of a row as a number. Raises UserError."""
    try:
        return float(row[column])
    except (TypeError, ValueError):
        raise UserError(f"{page}: {file}: '{row[column]}' in the column {column} is no number") from None


def read_runs(page, file, frame, value):
    """{(scene, method): {seed or tile: value}} of the page's file, of one frame if it has frames; summed times become
    those of one frame."""
    try:
        with open(page.parent / file, newline="") as stream:
            rows = list(csv.DictReader(stream))
    except OSError as error:
        raise UserError(f"{page}: its file {page.parent / file} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise UserError(f"{page}: its file {page.parent / file} is no text in UTF-8") from None
    columns = list(rows[0]) if rows else []
    if not {*NAMES[:2]} <= set(columns) or not {*NAMES[3:]} & set(columns):
        raise UserError(f"{page}: {file} is no runs.csv of scripts/compare.py: it lacks scene, method, seed, or a row")
    if "frame" not in columns:
        if frame is not None:
            raise UserError(f"{page}: frame={frame}: {file} has no column of frames; leave it out")
    elif frame is None:
        raise UserError(f"{page}: frame must be given, as in frame=12: {file} has several")
    elif not (frame.isascii() and frame.isdigit()):
        raise UserError(f"{page}: frame={frame}: it is a whole number, as in frame=12")
    check_name(page, "value", value, [name for name in columns if name not in NAMES])
    runs, divisor = {}, int(frame) if frame is not None and value.endswith(("_ms", "_ms_total")) else 1
    name = "tile" if "tile" in columns else "seed"
    for row in rows:
        if row.get("frame") != frame:
            continue
        scene, method = Path(row["scene"]).stem, row["method"]
        which, own = number_in(page, file, row, name), runs.setdefault((scene, method), {})
        if which in own:
            raise UserError(f"{page}: {file} has two rows of {scene}, {method}, {name} {which:g}; leave one of them")
        own[which] = number_in(page, file, row, value) / divisor
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
    both = paired(runs, baseline)
    return f"{text}, {change(*both)}" if both else text


def paired(runs, baseline):
    """Values of two {seed: value} for the seeds that both have; None: there is no such seed, or no baseline."""
    seeds = sorted(runs.keys() & baseline.keys()) if runs and baseline else []
    return ([runs[seed] for seed in seeds], [baseline[seed] for seed in seeds]) if seeds else None


def change(values, baseline):
    """The relative change of the mean, ± one standard error, in percent."""
    quotient, error = statistics.ratio(values, baseline)
    spread = "" if math.isnan(error) else f" ± {100 * error:.1f}"
    return f"{100 * (quotient - 1):+.1f}{spread}%"


def changes(runs, scenes, pairs, titles):
    """Lines of a table of changes, one per scene; `pairs`: of methods."""
    both = {(scene, *pair): paired(*(runs.get((scene, name)) for name in pair)) for scene in scenes for pair in pairs}
    found = [key for key, values in both.items() if values]
    p_values = dict(zip(found, statistics.holm([statistics.paired(*both[key]).p for key in found])))

    def told(key):
        if key not in p_values:
            return "—"
        return change(*both[key]) + ("" if math.isnan(p_values[key]) else f", p = {p_values[key]:.1g}")

    names = [" against ".join(titles.get(name, name) for name in pair) for pair in pairs]
    rows = [[titles.get(scene, scene), *(told((scene, *pair)) for pair in pairs)] for scene in scenes]
    return [["", *names], ["---"] * (len(pairs) + 1), *rows]


def pairs_of(page, options, methods):
    """Of `pairs`. Raises UserError."""
    pairs = [tuple(pair.split("/")) for pair in options["pairs"].split(",")]
    if {"against", "methods"} & options.keys() or any(len(pair) != 2 for pair in pairs):
        raise UserError(f"{page}: pairs={options['pairs']}: give pairs=a/b,c/d, without against and methods")
    for name in (name for pair in pairs for name in pair):
        check_name(page, "pairs", name, methods)
    return pairs


def table(page, file, options):
    """The Markdown table that a marker of the page asks for."""
    if "value" not in options:
        raise UserError(f"{page}: a table takes {', '.join(sorted(OPTIONS))}; value must be given")
    value, against = options["value"], options.get("against")
    runs = read_runs(page, file, options.get("frame"), value)
    chosen = {}
    names = []
    for place, name in enumerate(("scenes", "methods")):
        known = list(dict.fromkeys(key[place] for key in runs))
        names += known
        chosen[name] = options[name].split(",") if name in options else known
        for one in chosen[name]:
            check_name(page, name, one, known)
    if against is not None:
        check_name(page, "against", against, known)
    for name in options.keys() - OPTIONS:
        check_name(page, "an option", name, [*sorted(OPTIONS), *names])
    if "pairs" in options:
        return written(changes(runs, chosen["scenes"], pairs_of(page, options, known), options))
    lines = [["", *(options.get(scene, scene) for scene in chosen["scenes"])], ["---"] * (len(chosen["scenes"]) + 1)]
    for method in chosen["methods"]:
        cells = [
            cell(
                runs[scene, method], None if method == against else runs.get((scene, against)), value.startswith("mape")
            )
            if (scene, method) in runs
            else "—"
            for scene in chosen["scenes"]
        ]
        lines.append([options.get(method, method), *cells])
    return written(lines)


def written(lines):
    """A table in Markdown."""
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def rewritten(page):
    """The page's text with its tables as their files give them."""

    def write(match):
        try:
            options = dict(option.partition("=")[::2] for option in shlex.split(match["options"]))
        except ValueError as error:
            raise UserError(f"{page}: {match[1].strip()}: {error}") from None
        return f"{match[1]}\n{table(page, match['file'], options)}\n"

    text = page.read_text()
    unfollowed = MARKER.search(MARKED.sub("", text))
    if unfollowed:
        raise UserError(
            f"{page}: '{unfollowed[0]}' is no marker, as <!-- table: FILE.csv value=NAME --> alone on its line is"
        )
    return MARKED.sub(write, text)


def main(arguments):
    """Write or check the pages. Returns 1 where a checked table is out of date."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "pages", type=Path, nargs="*", help="Markdown files (default: README.md and all of benchmarks/results)"
    )
    parser.add_argument("--check", action="store_true", help="change nothing, name the pages that would change")
    options = parser.parse_args(arguments)
    pages = options.pages or [ROOT / "README.md", *sorted((ROOT / "benchmarks/results").rglob("*.md"))]
    changed = [page for page in pages if page.read_text() != rewritten(page)]
    for page in changed:
        if not options.check:
            files.write(page, rewritten(page).encode())
        print(f"{page}: {'is not what its CSV says' if options.check else 'written'}")
    return 1 if changed and options.check else 0


if __name__ == "__main__":
    sys.exit(program.run("result_tables.py", lambda _: main(sys.argv[1:])))
