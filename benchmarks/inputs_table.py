#!/usr/bin/python3
"""Measure every file of ../shared/inputs and write benchmarks/results/inputs: README.md and inputs.csv.

    PYTHONPATH=build/python:tests/python benchmarks/inputs_table.py

Rows, exact values and what commit aa3076d gave are those of tests/python/shared_inputs.csv, which
tests/python/test_shared_inputs.py tests. Exit code 1 when a row is wrong.
"""

import csv
import io
import sys
from pathlib import Path

from shared_inputs import Fault, Refused, is_right, measure, rows, shared_folder

from restirpg.harness import files
from restirpg.harness.report import commit

ROOT = Path(__file__).resolve().parents[1]

RESULTS = ROOT / "benchmarks" / "results" / "inputs"
HEAD = """# The inputs of ../shared/inputs

One row a file and setting: the value that a correct renderer gives and where it comes from, what
commit aa3076d gave ("before"), and what {commit} gives ("after"). 64 frames of path_tracer.py at
16x16, the mean of the red channel, unless the row says otherwise; `variance` is that of single
frames over the variance of the file named by `to`. Each row is a test of
tests/python/test_shared_inputs.py; written by `benchmarks/inputs_table.py`. {right} of {all} rows
are known to be right.

| input | quantity | exact | where it comes from | before | after | |
| --- | --- | --- | --- | --- | --- | --- |
"""


def exact(row):
    """The expectation in words."""
    if row.quantity == "refused":
        return "one line of refusal"
    if row.quantity == "variance":
        return f"at most {row.tolerance}"
    if row.quantity.startswith("finite"):
        return "a finite picture"
    choice = " or one line of refusal" if "refused" in row.quantity else ""
    return (f"{row.expected} ± {row.tolerance}" if float(row.tolerance) else row.expected) + choice


def text(value):
    """A measured value for the table."""
    if isinstance(value, Refused):
        return f"refused: {value.replace(f'{shared_folder()}/inputs/', '')[:100]}"
    return str(value) if isinstance(value, Fault) else f"{value:.4g}"


def main():
    """Measure, print and write."""
    if shared_folder() is None:
        sys.exit("inputs_table.py: ../shared/inputs is not there; name its parent folder in RESTIRPG_SHARED")
    lines, table, wrong = [], [], 0
    for row in rows():
        value = measure(row)
        right = is_right(row, value)
        wrong += not right
        line = [row.name, row.quantity, exact(row), row.source, row.was, text(value), "right" if right else "WRONG"]
        table.append(line)
        lines.append("| " + " | ".join(cell.replace("|", " or ") for cell in line) + " |")
        print(*lines[-1:], flush=True)
    head = HEAD.format(commit=commit(), right=len(lines) - wrong, all=len(lines))
    files.write(RESULTS / "README.md", head + "\n".join(lines) + "\n")
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(("input", "quantity", "exact", "source", "before", "after", "verdict"))
    writer.writerows(table)
    files.write(RESULTS / "inputs.csv", stream.getvalue())
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
