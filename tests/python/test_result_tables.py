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
| first | 40.0 ± 10.0% | 20.0% |
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


@pytest.mark.parametrize("name", ["gpu_ms", "gpu_ms_total"])
def test_summed_times_become_those_of_a_frame_in_files_of_either_age(tmp_path, name):
    (tmp_path / "runs.csv").write_text(RUNS.replace("gpu_ms", name))
    page = tmp_path / "page.md"
    page.write_text(f"<!-- table: runs.csv frame=4 value={name} scenes=room -->\n")
    assert run(page).returncode == 0
    assert "| first | 15.0 ± 5.0 |" in page.read_text()


def test_tiles_are_paired_as_seeds_are(tmp_path):
    text = RUNS.replace("seed,frame,mape", "tile,frame,mape_single")
    (tmp_path / "runs.csv").write_text(text)
    page = tmp_path / "page.md"
    page.write_text(f"{MARKER.replace('value=mape', 'value=mape_single')}\n")
    assert run(page).returncode == 0
    assert TABLE in page.read_text()


def test_a_file_without_frames_is_read_and_rows_take_titles(tmp_path):
    (tmp_path / "runs.csv").write_text(
        "".join(line.replace(",4,", ",") + "\n" for line in RUNS.splitlines()).replace(",frame", "")
    )
    page = tmp_path / "page.md"
    page.write_text('<!-- table: runs.csv value=mape against=first first="no guiding, as it is" -->\n')
    assert run(page).returncode == 0
    assert TABLE.replace("| first |", "| no guiding, as it is |") in page.read_text()
    page.write_text(f"{MARKER}\n")
    assert "frame=4: runs.csv has no column of frames; leave it out" in run(page).stderr


def test_a_figure_that_the_file_does_not_have_is_found(page):
    run(page)
    assert run("--check", page).returncode == 0
    page.write_text(page.read_text().replace("20.0 ± 5.0", "19.0 ± 5.0"))
    done = run("--check", page)
    assert done.returncode == 1 and done.stdout == f"{page}: is not what its CSV says\n"


@pytest.mark.parametrize(
    "options, words",
    [
        ("frame=4", "value must be given"),
        ("value=mape", "frame must be given, as in frame=12: runs.csv has several"),
        (
            "frame=4 value=mape secnd=other",
            "an option=secnd: there are: against, frame, methods, pairs, scenes, value, room, hall, first, second",
        ),
        ("frame=5 value=mape", "frame=5: no run of runs.csv has it"),
        ("frame=last value=mape", "frame=last: it is a whole number"),
        ("frame=4 value=mapee", "value=mapee: there are: mape, gpu_ms; did you mean 'mape'?"),
        ("frame=4 value=scene", "value=scene: there are: mape, gpu_ms"),
        ("frame=4 value=mape methods=first,secnd", "methods=secnd: there are: first, second; did you mean 'second'?"),
        ("frame=4 value=mape scenes=rom", "scenes=rom: there are: room, hall; did you mean 'room'?"),
        ("frame=4 value=mape against=frst", "against=frst: there are: first, second; did you mean 'first'?"),
        ('frame=4 value=mape first="no', "No closing quotation"),
        ("frame=4 value=mape pairs=second/frst", "pairs=frst: there are: first, second; did you mean 'first'?"),
        ("frame=4 value=mape pairs=second", "give pairs=a/b,c/d, without against and methods"),
        ("frame=4 value=mape pairs=second/first against=first", "give pairs=a/b,c/d, without against and methods"),
    ],
)
def test_a_marker_that_cannot_be_followed_is_one_line(page, options, words):
    page.write_text(f"<!-- table: runs.csv {options} -->\n")
    done = run(page)
    assert done.returncode == 2 and f"{page}: " in done.stderr and words in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "marker",
    ["<!-- table: runs.csv -->", "<!--table: runs.csv value=mape -->", "<!-- table: runs.csv value=mape --> |"],
)
def test_a_marker_that_is_written_otherwise_is_not_passed_over(page, marker):
    page.write_text(f"{marker}\n")
    done = run(page)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and str(page) in done.stderr


def test_changes_are_tested_and_corrected_for_all_tests_of_the_table(tmp_path):
    """t-tests with one degree of freedom: p = 1 - 2 atan(|t|) / pi."""
    lines = ["scene,method,tile,mape"]
    # By room: differences 0.1 and 0.2, t = 3, p = 0.205; by hall: 0.1 and 0.3, t = 2, p = 0.295. Holm: 2 x 0.205, then that.
    for scene, differences in (("room", (0.1, 0.2)), ("hall", (0.1, 0.3))):
        for tile, difference in enumerate(differences):
            lines += [f"{scene},first,{tile},0.5", f"{scene},second,{tile},{0.5 - difference}"]
    (tmp_path / "tiles.csv").write_text(
        "\n".join([*lines, "shed,first,0,1", "shed,second,0,2", "yard,first,0,1"]) + "\n"
    )
    page = tmp_path / "page.md"
    page.write_text('<!-- table: tiles.csv value=mape pairs=second/first second="the second" shed="a shed" -->\n')
    done = run(page)
    assert done.returncode == 0, done.stderr
    assert page.read_text().partition("\n\n")[2] == (
        "|  | the second against first |\n| --- | --- |\n| room | -30.0 ± 10.0%, p = 0.4 |\n"
        "| hall | -40.0 ± 20.0%, p = 0.4 |\n| a shed | +100.0% |\n| yard | — |\n\n"
    )


def test_times_of_a_file_without_frames_are_as_they_are(tmp_path):
    lines = ["scene,method,seed,gpu_ms", "room.glb,first,0,40", "room.glb,first,1,80"]
    (tmp_path / "runs.csv").write_text("\n".join(lines) + "\n")
    page = tmp_path / "page.md"
    page.write_text("<!-- table: runs.csv value=gpu_ms -->\n")
    done = run(page)
    assert done.returncode == 0 and "| first | 60.0 ± 20.0 |" in page.read_text(), done.stderr


def test_two_rows_of_one_run_are_refused(page):
    (page.parent / "runs.csv").write_text(RUNS + "b/room.glb,first,1,4,0.90,80\n")
    done = run(page)
    assert done.returncode == 2 and "runs.csv has two rows of room, first, seed 1" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("row", ["a/room.glb,first,2,4", "a/room.glb,first,x,4,0.1,5"])
def test_a_row_that_is_no_run_is_one_line(page, row):
    (page.parent / "runs.csv").write_text(RUNS + row + "\n")
    done = run(page)
    assert done.returncode == 2 and "is no number" in done.stderr and done.stderr.count("\n") == 1


def test_recorded_pages_say_what_their_files_say():
    done = run("--check")
    assert done.returncode == 0, done.stdout + done.stderr
