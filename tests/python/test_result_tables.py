"""benchmarks/result_tables.py: recorded pages say what their CSV says."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RUNS = """scene,method,seed,frame,mape,gpu_ms
a/room.glb,first,0,4,0.50,40
a/room.glb,first,1,4,0.30,80
a/room.glb,second,0,4,0.25,20
a/room.glb,second,1,4,0.15,40
a/hall.glb,first,0,4,0.20,40
"""
MARKER = "<!-- table: runs.csv frame=4 value=mape against=first -->"
# Means of two seeds differ from each by half their distance: that is the standard error. The second is half of the
# first in both seeds, so that the change has none.
TABLE = """|  | room | hall |
| --- | --- | --- |
| first | 40.0 ± 10.0% | 20.0 ± nan% |
| second | 20.0 ± 5.0%, -50.0 ± 0.0% | — |
"""


def run(*arguments):
    return subprocess.run(
        [sys.executable, ROOT / "benchmarks/result_tables.py", *map(str, arguments)], capture_output=True, text=True
    )


@pytest.fixture
def page(tmp_path):
    (tmp_path / "runs.csv").write_text(RUNS)
    file = tmp_path / "page.md"
    file.write_text(f"# Title\n\n{MARKER}\n\nWords\n")
    return file


def test_a_table_is_written_below_its_marker(page):
    assert run(page).returncode == 0
    text = f"# Title\n\n{MARKER}\n\n{TABLE}\nWords\n"
    assert page.read_text() == text
    assert run(page).stdout == "" and page.read_text() == text


def test_a_figure_that_the_file_does_not_have_is_found(page):
    run(page)
    assert run("--check", page).returncode == 0
    page.write_text(page.read_text().replace("20.0 ± 5.0", "19.0 ± 5.0"))
    done = run("--check", page)
    assert done.returncode == 1 and done.stdout == f"{page}: is not what its CSV says\n"


@pytest.mark.parametrize(
    "options, words",
    [("frame=4", "frame and value must be given"), ("frame=5 value=mape", "no run has frame 5")],
)
def test_a_marker_that_cannot_be_followed_is_one_line(page, options, words):
    page.write_text(f"<!-- table: runs.csv {options} -->\n")
    done = run(page)
    assert done.returncode == 2 and words in done.stderr and done.stderr.count("\n") == 1


def test_recorded_pages_say_what_their_files_say():
    done = run("--check")
    assert done.returncode == 0, done.stdout + done.stderr
