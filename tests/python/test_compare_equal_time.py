"""scripts/compare.py --equal-frame-time on the fake renderer, whose frames cost 0.25 + ms + neighbours / 2
milliseconds."""

import csv
import re
import subprocess
import sys

import pytest
from harness_runs import ENVIRONMENT, arguments, compare

KNOB = {"equal_frame_time": "paths.neighbours", "frames": 8, "seeds": 4}


def read(folder, name):
    """A CSV file of the report by method."""
    with open(folder / "out" / name) as file:
        return {row["method"]: row for row in csv.DictReader(file)}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """2.25 ms against 3.95 ms, which 3.4 neighbours cost."""
    folder = tmp_path_factory.mktemp("equal")
    run = compare(folder, "plain.json", "plain.json@ms=3.7,noise=0.5,label=dear", **KNOB)
    assert run.returncode == 0, run.stderr
    return folder, run


def test_the_cheaper_methods_knob_is_raised_until_its_frame_costs_the_same(finished):
    rows = read(finished[0], "equal_time.csv")
    assert set(rows) == {"plain", "dear"}
    assert rows["plain"]["setting"] == "paths.neighbours=3.40" and rows["dear"]["setting"] == "own"
    assert float(rows["plain"]["ratio_below"]) == pytest.approx(3.75 / 3.95)
    assert float(rows["plain"]["ratio_above"]) == pytest.approx(4.25 / 3.95)
    assert all(float(row["time_in_runs"]) == pytest.approx(1, rel=0.01) for row in rows.values())
    assert "Equal frame time: single frames" in finished[1].stdout and "paths.neighbours=3.40" in finished[1].stdout


def test_its_error_is_interpolated_between_the_two_settings(finished):
    runs, found = read(finished[0], "summary.csv"), read(finished[0], "equal_time.csv")
    three, four = (float(runs[f"plain paths.neighbours={count}"]["mape_single"]) for count in (3, 4))
    assert four / three == pytest.approx(0.9, rel=0.01)  # a tenth of the noise
    assert float(found["plain"]["mape"]) == pytest.approx(0.6 * three + 0.4 * four)
    # 0.9^3.4 of the noise, to the dear one's half.
    assert 1 + float(found["dear"]["change"]) == pytest.approx(0.5 / (0.6 * 0.9**3 + 0.4 * 0.9**4), rel=0.03)
    assert float(found["dear"]["p"]) < 0.01


def test_a_method_that_stays_cheaper_is_compared_at_the_knobs_largest_value(tmp_path):
    """8 neighbours take 6.25 ms of 10.25."""
    run = compare(tmp_path, "plain.json", "plain.json@ms=10,noise=0.5,label=dear", **KNOB)
    assert run.returncode == 0, run.stderr
    row = read(tmp_path, "equal_time.csv")["plain"]
    assert row["setting"] == "paths.neighbours=8.00, the largest: 0.61 of the time"
    assert float(row["time_in_runs"]) == pytest.approx(6.25 / 10.25, rel=0.01)
    assert float(row["mape"]) == pytest.approx(
        float(read(tmp_path, "summary.csv")["plain paths.neighbours=8"]["mape_single"])
    )


def test_the_knob_is_found_between_the_last_doubling_and_its_largest_value(tmp_path):
    """From 2 neighbours on steps of 1, 2 and 4 would end at 9; 6.4 neighbours cost 5.45 ms."""
    run = compare(tmp_path, "plain.json@neighbours=2,label=plain", "plain.json@ms=5.2,label=dear", **KNOB)
    assert run.returncode == 0, run.stderr
    assert read(tmp_path, "equal_time.csv")["plain"]["setting"] == "paths.neighbours=6.40"


def test_of_equal_cost_nothing_is_raised(tmp_path):
    run = compare(tmp_path, "plain.json", "plain.json@noise=0.5,label=quiet", **KNOB)
    assert run.returncode == 0, run.stderr
    assert not (tmp_path / "out/equal_time.csv").exists()


def test_a_knob_that_no_method_has_is_refused(tmp_path):
    run = compare(tmp_path, **{**KNOB, "equal_frame_time": "paths.noise"})
    assert run.returncode == 2 and "'paths.noise'" in run.stderr and run.stderr.count("\n") == 1


def test_it_is_measured_in_tiles_too(tmp_path):
    run = compare(
        tmp_path, "plain.json", "plain.json@ms=3.7,label=dear", **{**KNOB, "at": "7,8", "tiles": 6, "tile_size": 8}
    )
    assert run.returncode == 0, run.stderr
    assert read(tmp_path, "equal_time.csv")["plain"]["setting"] == "paths.neighbours=3.40"


#: compare.py with a line of progress for each step.
TALKATIVE = """
import sys
from restirpg.harness import compare, display
display.SECONDS_BETWEEN_LINES = -1
sys.exit(compare.main(sys.argv[1:]))
"""


def test_its_runs_count_as_work_where_all_others_are_finished(tmp_path):
    methods = ("plain.json", "plain.json@ms=3.7,label=dear")
    assert compare(tmp_path, *methods, frames=8, seeds=4).returncode == 0
    command = [sys.executable, "-c", TALKATIVE, *arguments(tmp_path, *methods, **KNOB)[2:]]
    run = subprocess.run(command, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    shares = [int(share) for share in re.findall(r"^(\d+)% rendered", run.stderr, re.MULTILINE)]
    assert shares == sorted(shares) and 0 < shares[len(shares) // 2] < 100 and shares[-1] == 100
