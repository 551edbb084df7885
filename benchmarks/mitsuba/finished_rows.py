"""CSV files of finished runs, which an interrupted program finds again."""

import csv
import io

from restirpg.harness import files


def read_rows(path):
    """The rows of the CSV file so far."""
    if not path.is_file():
        return []
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def append_row(path, columns, row):
    """Add one run."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows([*read_rows(path), dict(zip(columns, row))])
    files.write(path, stream.getvalue())
