#!/usr/bin/python3
"""Measure every file of ../shared/inputs and write benchmarks/results/inputs: README.md and inputs.csv.

    benchmarks/inputs_table.py

Rows, exact values and what commit aa3076d gave are those of tests/python/shared_inputs.csv, which
tests/python/test_shared_inputs.py tests. Exit code: 0; 1 when a row is wrong; 2 where there is nothing to measure.
"""

import argparse
import csv
import io
import sys

from clone import ROOT

from restirpg.harness import UserError, files, program, render
from restirpg.harness.report import commit

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


def text(inputs, value):
    """A measured value for the table. inputs: the module shared_inputs."""
    if isinstance(value, inputs.Refused):
        return f"refused: {value.replace(f'{inputs.shared_folder()}/inputs/', '')[:100]}"
    return str(value) if isinstance(value, inputs.Fault) else f"{value:.4g}"


def measured():
    """The rows of the table, each a list of its cells; printed as they come."""
    sys.path.append(str(ROOT / "tests" / "python"))
    import shared_inputs as inputs

    if inputs.shared_folder() is None:
        raise UserError("../shared/inputs is not there; name its parent folder in RESTIRPG_SHARED")
    table = []
    for row in inputs.rows():
        value = inputs.measure(row)
        verdict = "right" if inputs.is_right(row, value) else "WRONG"
        table.append([row.name, row.quantity, exact(row), row.source, row.was, text(inputs, value), verdict])
        print(as_markdown(table[-1]), flush=True)
    return table


def as_markdown(cells):
    """A row of the page's table."""
    return "| " + " | ".join(cell.replace("|", " or ") for cell in cells) + " |"


def write_table():
    """Measure, print and write. Returns the exit code."""
    table = measured()
    right = sum(row[-1] == "right" for row in table)
    head = HEAD.format(commit=commit(), right=right, all=len(table))
    files.write(RESULTS / "README.md", head + "\n".join(map(as_markdown, table)) + "\n")
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(("input", "quantity", "exact", "source", "before", "after", "verdict"))
    writer.writerows(table)
    files.write(RESULTS / "inputs.csv", stream.getvalue())
    return 0 if right == len(table) else 1


def main():
    """The command line. Returns the exit code."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()

    def body(_):
        render.find_package()
        return write_table()

    return program.run("inputs_table.py", body)


if __name__ == "__main__":
    sys.exit(main())
