"""scripts/compare.py --equal-frame-time on the fake renderer, whose frames cost 0.25 + ms + neighbours / 2
milliseconds."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from harness_runs import by_method, changed, compare, csv_rows

from restirpg.harness import equal_cost

KNOB = {"equal_frame_time": "paths.neighbours", "frames": 8, "seeds": 4}


def read(folder, name):
    """A CSV file of the report by method."""
    return by_method(folder / "out" / name)


def verdicts(run):
    """The last column of the first table, by method."""
    text = run.stdout[run.stdout.index("Equal frame time: ") :]
    lines = text[: text.index("\n\n", text.index("──"))].splitlines()
    return {line.split()[0]: re.split(r"  +", line.strip())[-1] for line in lines if line.startswith("  ")}


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
    found = read(finished[0], "equal_time.csv")
    three, four = (float(found["plain"][f"mape_{end}"]) for end in ("below", "above"))
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
    assert float(row["mape"]) == pytest.approx(float(row["mape_above"]))


def test_nobody_is_told_apart_whose_frames_take_another_time(tmp_path):
    """The largest value is not enough; shares are of the slowest method's time, not of the largest found."""
    methods = ("plain.json@noise=0.5,label=quiet", "plain.json@ms=10,label=dear", "plain.json@ms=10,label=near")
    run = compare(tmp_path, *methods, **KNOB)
    assert run.returncode == 0, run.stderr
    words = verdicts(run)
    assert words["quiet"] == "baseline, not at equal time (×0.61)"
    assert words["dear"] == words["near"] == "the first is not at equal time (×0.61)"
    assert all(row["p"] == "nan" for row in read(tmp_path, "equal_time.csv").values())
    run = compare(tmp_path, *(methods[number] for number in (1, 0, 2)), **KNOB)
    words = verdicts(run)
    assert words["dear"] == "baseline" and words["quiet"] == "not at equal time (×0.61)"
    assert words["near"].startswith("not different")


def at_cost(ms, spread=0.0):
    """A method of a SceneFindings whose frames take these milliseconds in four runs."""
    return SimpleNamespace(single=np.ones(4), frame_ms=ms * (1 + spread * np.array([-1, 1, -1, 1])))


def compared(dear, *others):
    """equal_cost.compare() of methods without knobs, the slowest of which the search has named first."""
    methods = [SimpleNamespace(label=str(number), **vars(each)) for number, each in enumerate((dear, *others))]
    return equal_cost.compare(SimpleNamespace(methods=methods, raised={}, equal_cost=equal_cost.EqualCost("0")))


def test_times_are_shares_of_the_method_that_was_aimed_at_with_their_noise():
    [_, above, below] = compared(at_cost(10), at_cost(10.4), at_cost(9))
    assert above.time == (pytest.approx(1.04), pytest.approx(0, abs=1e-9)) and above.is_equal
    assert below.time[0] == pytest.approx(0.9) and not below.is_equal
    [_, noisy] = compared(at_cost(10), at_cost(9, 0.2))  # a standard error of 0.104: noise makes nothing equal
    assert noisy.time[1] == pytest.approx(0.9 * 0.2 * (4 / 3) ** 0.5 / 2)
    assert not noisy.is_equal and np.isnan(noisy.p)


def test_the_knob_is_found_between_the_last_doubling_and_its_largest_value(tmp_path):
    """From 2 neighbours on steps of 1, 2 and 4 would end at 9; 6.4 neighbours cost 5.45 ms."""
    run = compare(tmp_path, "plain.json@neighbours=2,label=plain", "plain.json@ms=5.2,label=dear", **KNOB)
    assert run.returncode == 0, run.stderr
    assert read(tmp_path, "equal_time.csv")["plain"]["setting"] == "paths.neighbours=6.40"


def test_of_equal_cost_nothing_is_raised_and_the_table_says_so(tmp_path):
    run = compare(tmp_path, "plain.json", "plain.json@noise=0.5,label=quiet", **KNOB)
    assert run.returncode == 0, run.stderr
    assert [row["setting"] for row in read(tmp_path, "equal_time.csv").values()] == ["own", "own"]
    words = verdicts(run)
    assert words["plain"] == "baseline" and words["quiet"].startswith("lower")


def test_one_method_alone_is_refused(tmp_path):
    run = compare(tmp_path, "plain.json", **KNOB)
    assert run.returncode == 2 and "--equal-frame-time compares methods" in run.stderr and run.stderr.count("\n") == 1


def test_in_brief_the_answer_and_the_warnings_are_there(tmp_path):
    methods = ("plain.json", "plain.json@ms=3.7,noise=0.5,bounces=2,label=dear", "plain.json@ms=1,label=cheap")
    run = compare(tmp_path, *methods, brief=[], **KNOB)
    assert run.returncode == 0, run.stderr
    said = " ".join(run.stdout.split())
    assert re.search(r"At equal frame time, dear has [\d.]+% less error than plain, cheap [\d.]+% less\.", said)
    assert "warning: dear: its bounce cap is 2, that of the reference is 4" in said
    assert "paths.neighbours" not in said[: said.index("At equal frame time")]  # no raised setting counts as a method


def test_a_knob_that_no_method_has_is_refused(tmp_path):
    run = compare(tmp_path, **{**KNOB, "equal_frame_time": "paths.noise"})
    assert run.returncode == 2 and "'paths.noise'" in run.stderr and run.stderr.count("\n") == 1


def test_all_frames_of_at_are_averaged_and_named(tmp_path):
    run = compare(tmp_path, "plain.json", "plain.json@ms=3.7,label=dear", **{**KNOB, "at": "1,4,8"})
    assert run.returncode == 0, run.stderr
    assert "Equal frame time: single frames, mean of frames 1, 4 and 8" in run.stdout
    frames = csv_rows(tmp_path / "out/frames.csv")
    errors = [float(row["mape"]) for row in frames if row["method"] == "dear"]
    assert len(errors) == 3
    assert float(read(tmp_path, "equal_time.csv")["dear"]["mape"]) == pytest.approx(np.mean(errors))


def test_it_is_measured_in_tiles_too(tmp_path):
    run = compare(
        tmp_path, "plain.json", "plain.json@ms=3.7,label=dear", **{**KNOB, "at": "7,8", "tiles": 6, "tile_size": 8}
    )
    assert run.returncode == 0, run.stderr
    assert read(tmp_path, "equal_time.csv")["plain"]["setting"] == "paths.neighbours=3.40"


def test_a_method_named_as_a_raised_setting_would_be_stays_in_the_comparison(tmp_path):
    """The first method is raised to 3 and 4 neighbours; the baseline has 3 of its own, and its default label says so."""
    methods = ("plain.json@paths.neighbours=3", "plain.json", "plain.json@ms=3.7,noise=0.5,label=dear")
    run = compare(tmp_path, *methods, **KNOB)
    assert run.returncode == 0, run.stderr
    labels = ["plain paths.neighbours=3", "plain", "dear"]
    rows = read(tmp_path, "equal_time.csv")
    assert list(rows) == labels
    assert [row["setting"] for row in rows.values()] == ["paths.neighbours=3.40", "paths.neighbours=3.40", "own"]
    # With 3.4 neighbours it is the baseline: the same runs.
    assert rows["plain"]["mape"] == rows["plain paths.neighbours=3"]["mape"]
    assert float(rows["plain"]["change"]) == 0 and float(rows["plain"]["p"]) == 1


def test_raised_settings_are_no_methods(finished, tmp_path):
    """No other table has them, and they are in no family of tests: without them the numbers are the same."""
    run = compare(tmp_path, "plain.json", "plain.json@ms=3.7,noise=0.5,label=dear", frames=8, seeds=4)
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "out/summary.csv").read_text() == (finished[0] / "out/summary.csv").read_text()
    assert not list((finished[0] / "out/images").glob("*neighbours*"))


def test_a_knob_that_the_method_sets_is_replaced(tmp_path):
    """One of 2 neighbours that is raised to 3 is rendered as one of 3 is."""
    methods = ("plain.json@paths.neighbours=2", "plain.json@paths.neighbours=3", "plain.json@ms=3.7,label=dear")
    run = compare(tmp_path, *methods, **KNOB)
    assert run.returncode == 0, run.stderr
    jobs = set()
    for file in (tmp_path / "out/cache").glob("*.npz"):
        with np.load(file) as kept:
            meta = json.loads(str(kept["meta"]))
        if "job" in meta and "reference" not in meta["job"]["label"]:
            jobs.add((meta["job"]["seed"], json.dumps(meta["knobs"]), file.name))
    assert len(jobs) == 4 * 4  # seeds; 2, 3 and 4 neighbours, and the dear one
    assert len({job[:2] for job in jobs}) == len(jobs)  # no two files hold the same run


#: A line of progress for each step.
TALKATIVE = "from restirpg.harness import display; display.SECONDS_BETWEEN_LINES = -1"


def test_its_runs_count_as_work_where_all_others_are_finished(tmp_path):
    methods = ("plain.json", "plain.json@ms=3.7,label=dear")
    assert compare(tmp_path, *methods, frames=8, seeds=4).returncode == 0
    run = compare(tmp_path, *methods, program=changed(TALKATIVE), **KNOB)
    assert run.returncode == 0, run.stderr
    shares = [int(share) for share in re.findall(r"^(\d+)% rendered", run.stderr, re.MULTILINE)]
    assert shares == sorted(shares) and 0 < shares[len(shares) // 2] < 100 and shares[-1] == 100
