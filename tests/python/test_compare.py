"""scripts/compare.py from end to end on the fake renderer: findings, cache, interruptions, failures,
mistakes."""

import importlib.util
import io
import json
import re
import subprocess

import numpy as np
import pytest
from harness_runs import ENVIRONMENT, ROOT, SCRIPT, by_method, changed, compare, write_graph

from restirpg.harness import display
from restirpg.harness.jobs import seed_of


def write_exr(file, broken, value):
    """A picture as the fake renderer reads it, `broken` of whose pixels have that value."""
    image = np.ones((24, 32, 3), np.float32)
    image[0, :broken] = value
    with open(file, "wb") as stream:
        np.save(stream, image)


def summary(folder, out="out"):
    """summary.csv: method -> {column: value}."""
    return by_method(folder / out / "summary.csv")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A comparison of three methods with known differences."""
    folder = tmp_path_factory.mktemp("compare")
    methods = [
        "plain.json",
        "plain.json@noise=0.5,ms=8.75,label=quiet",
        "plain.json@blotch=4,memory=0.6,label=blotchy",
        "plain.json@gain=1.05,label=bright",
    ]
    run = compare(folder, *methods, program=SCRIPT, size="64x48", frames=16, seeds=8)
    assert run.returncode == 0, run.stderr
    return folder, run


def test_errors_are_those_of_the_known_noise(finished):
    # relMSE of n frames of variance s^2: s^2 / n times the mean of T^2 / (T^2 + 0.01). Five standard errors.
    spec = importlib.util.spec_from_file_location("fake", ROOT / "tests/python/fake_renderer/restirpg/_native.py")
    fake = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(fake)
    truth = fake.truth(64, 48)
    for method, noise in (("plain", 1), ("quiet", 0.5)):
        row = summary(finished[0])[method]
        expected = noise**2 / 16 * np.mean(truth**2 / (truth**2 + 0.01))
        # The reference's own estimated variance (512 frames) is uncertain to 1%, a 30th of the error's.
        assert abs(float(row["relmse_frame"]) - expected) < 5 * float(row["relmse_frame_se"]) + 0.002 * expected
        # A single frame's error is exponential: its mean absolute value is 2 / e of its standard deviation.
        y = (truth @ np.array([0.2126, 0.7152, 0.0722]))[..., None]
        single = noise * 2 / np.e * np.mean(truth / (y + 0.01 * y.mean()))
        assert abs(float(row["mape_single"]) - single) < 5 * float(row["mape_single_se"]) + 0.005 * single


def test_a_bounce_cap_of_none_is_a_cap(tmp_path):
    """0 is direct light alone, for methods and reference; it is not "the graph's own", which is 4."""
    run = compare(tmp_path, "plain.json", size="16x16", frames=2, seeds=2, bounces=0)
    assert run.returncode == 0, run.stderr
    caps = set()
    for path in (tmp_path / "out/cache").glob("*.npz"):
        with np.load(path) as file:
            knobs = json.loads(str(file["meta"])).get("knobs")
        caps |= {knobs["paths"]["bounces"]} if knobs else set()
    assert caps == {0}
    assert "bounce cap</th><td>0" in (tmp_path / "out/report.html").read_text().replace("\n", "")


@pytest.mark.parametrize("setting, told", [("noise=0.5", "4"), ("bounces=2", "plain 4, quiet 2")])
def test_the_report_says_the_graphs_bounce_caps(tmp_path, setting, told):
    run = compare(tmp_path, "plain.json", f"plain.json@{setting},label=quiet")
    assert run.returncode == 0, run.stderr
    told = f"bounce cap of scene.gltf</th><td>{told} (the graphs&#39; own)"
    text = (tmp_path / "out/report.html").read_text()
    assert told in text.replace("\n", "") and "over all methods and scenes of the report (Holm)" in " ".join(
        text.split()
    )


def verdict(stdout):
    """The verdict on the first scene, in one line."""
    text = " ".join(stdout.split())
    return text[text.index("seeds") : text.index("reference:")]


def test_the_verdict_comes_first_in_one_sentence(finished):
    said = verdict(finished[1].stdout)
    less = float(re.search(r"In single frames, quiet has ([\d.]+)% less error than plain", said)[1])
    assert 45 < less < 55  # half the noise
    assert said.count(". ") == 1 and "; at equal time, " in said
    assert re.search(r"; quiet .*not told apart from it\.", said)


def test_the_verdict_is_short_where_nothing_is_told_apart(tmp_path):
    run = compare(tmp_path, "plain.json", "plain.json@label=a", "plain.json@label=b", size="16x16", frames=2, seeds=2)
    assert "No method is told apart from plain, in single frames or at equal time." in " ".join(run.stdout.split())
    run = compare(tmp_path, "plain.json", "plain.json@label=a", size="16x16", frames=2, seeds=2)
    assert ") a is not told apart from plain, in single frames or at equal time." in " ".join(run.stdout.split())


def test_twice_the_error_and_more_has_no_exponent(tmp_path):
    run = compare(tmp_path, "plain.json@noise=0.01", "plain.json@label=a", size="16x16", frames=2, seeds=4)
    more = int(re.search(r"a has (\d+)% more error than plain", " ".join(run.stdout.split()))[1])
    assert more > 300


def test_in_brief_there_is_a_verdict_and_one_table_of_80_columns(tmp_path):
    long = "plain.json@noise=0.5,label=a method whose name is rather long"
    run = compare(tmp_path, "plain.json", long, brief=[], frames=4)
    table = run.stdout.split("device:")[1]
    assert "less error than plain" in " ".join(table.split()) and "at equal time" in table
    assert all(len(line) <= 80 for line in table.splitlines()[1:] if not line.startswith("out/report.html"))
    assert "8×8 blocks" not in table and "8×8 blocks" in (tmp_path / "out/tables.txt").read_text()


def test_labels_are_no_markup(tmp_path):
    label = "pt[/old] :bug: $x^$"
    options = {"program": SCRIPT, "size": "16x16", "frames": 2, "seeds": 2}
    run = compare(tmp_path, "plain.json", f"plain.json@label={label}", **options)
    assert run.returncode == 0, run.stderr
    assert f" {label} " in run.stdout
    brief = subprocess.run([*run.args, "--brief"], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    assert f" {label} " in brief.stdout, brief.stderr


def test_a_first_frame_that_takes_longer_than_the_common_time_has_no_errors_then(tmp_path):
    run = compare(tmp_path, "plain.json", "plain.json@ms=100,label=slow", size="16x16", frames=2, seeds=2)
    assert run.returncode == 0, run.stderr
    assert "nan" not in run.stdout
    [row] = re.findall("^ *slow .*", run.stdout[run.stdout.index("Equal time") :], re.MULTILINE)[:1]
    assert row.split()[-1] == "—"
    assert "at equal time, slow is not tested against plain." in " ".join(run.stdout.split())


def test_work_that_was_not_foreseen_is_counted(monkeypatch):
    monkeypatch.setattr(display, "SECONDS_BETWEEN_LINES", -1)
    stream = io.StringIO()
    told = display.Display(stream)
    told.start(0)
    told.advance(0, "a")
    told.advance(4, "b")
    told.start(10)
    told.skip(10)
    told.extend(8)
    told.advance(2, "c")
    shares = [(line.split()[0], line[-2]) for line in stream.getvalue().splitlines()]
    assert shares == [("0%", "a"), ("100%", "b"), ("25%", "c")]


def test_equal_time_compares_at_the_time_of_the_fastest(finished):
    # 2.25 ms per frame against 9 ms: half the noise at a quarter of the frames is the same error.
    rows = summary(finished[0])
    assert float(rows["quiet"]["common_gpu_ms"]) == pytest.approx(16 * 2.25)
    ratio = float(rows["quiet"]["relmse_time"]) / float(rows["plain"]["relmse_time"])
    assert ratio == pytest.approx(1, abs=0.1)
    assert float(rows["quiet"]["relmse_frame_p"]) < 1e-6 < float(rows["quiet"]["relmse_time_p"])


def test_bias_blotches_and_boiling_are_found_where_they_are_and_only_there(finished):
    rows = summary(finished[0])
    assert float(rows["bright"]["bias_p"]) < 0.01 < float(rows["plain"]["bias_p"])
    assert float(rows["bright"]["bias"]) == pytest.approx(0.05, abs=5 * float(rows["bright"]["bias_se"]))
    for column, blotchy in (("spatial_frame", 16), ("spatial_image", 16), ("temporal", 0.6)):
        assert abs(float(rows["blotchy"][column]) - blotchy) < 5 * float(rows["blotchy"][column + "_se"])
        plain = 0 if column == "temporal" else 1
        assert abs(float(rows["plain"][column]) - plain) < 5 * float(rows["plain"][column + "_se"])
    assert "biased" in finished[1].stdout and "smallest detectable" in finished[1].stdout


def test_a_second_start_renders_nothing_and_prints_the_same(finished):
    folder, first = finished
    before = {path.name: path.stat().st_mtime_ns for path in (folder / "out/cache").glob("*.npz")}
    again = subprocess.run(first.args, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True)
    assert before == {path.name: path.stat().st_mtime_ns for path in (folder / "out/cache").glob("*.npz")}
    assert again.stdout.split("out/report.html")[0] == first.stdout.split("out/report.html")[0]


@pytest.mark.parametrize("knob, words", [("crash_seed", "SIGSEGV"), ("fail_seed", "the device was lost")])
def test_a_failed_run_is_reported_and_the_rest_goes_on(tmp_path, knob, words):
    run = compare(tmp_path, "plain.json", f"plain.json@{knob}={seed_of(0, 'run', 2)},label=bad")
    assert run.returncode == 1
    assert words in run.stderr and run.stderr.count("failed:") == 2
    assert "1 of 4 seeds are left out" in run.stdout
    assert set(summary(tmp_path)) == {"plain", "bad"}
    assert words in (tmp_path / "out/report.html").read_text()


def test_without_a_baseline_nothing_else_takes_its_place(tmp_path):
    run = compare(
        tmp_path, f"plain.json@fail_seed={seed_of(0, 'run', 0)},label=plain", "plain.json@label=other", seeds=1
    )
    assert run.returncode == 1 and not summary(tmp_path)
    assert "scene.gltf: left out: no run of 'plain', the baseline, was finished" in run.stderr


def test_invalid_pixels_are_counted_in_all_measured_pictures_and_in_the_reference(tmp_path):
    write_graph(tmp_path, "truth", broken=2)
    run = compare(tmp_path, "plain.json", "plain.json@broken=3,label=bad", reference_graph="truth.json")
    assert run.returncode == 0, run.stderr
    assert f"bad: NaN or infinite pixels, {3 * 8 * 4} in all measured pictures" in run.stdout
    assert f"reference: {2 * 16} NaN or infinite pixels of its batches count as black" in run.stdout
    assert "plain: NaN" not in run.stdout


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_picture_with_invalid_pixels_is_no_reference(tmp_path, value):
    write_exr(tmp_path / "truth.exr", 5, value)
    run = compare(tmp_path, "plain.json", reference="truth.exr")
    assert run.returncode == 2 and run.stderr.count("\n") == 1
    assert "truth.exr: 5 of its pixels are NaN or infinite" in run.stderr
    assert len(list((tmp_path / "out/cache").glob("*.npz"))) == 1  # the graph's knobs: nothing was rendered


def test_scenes_read_outside_of_their_folders_only_where_that_is_allowed(tmp_path):
    (tmp_path / "outside.gltf").write_text("")
    refused = compare(tmp_path, "plain.json", scenes="outside.gltf")
    assert refused.returncode == 2 and "outside of the scene's folder" in refused.stderr
    allowed = compare(tmp_path, "plain.json", "--allow-outside", scenes="outside.gltf")
    assert allowed.returncode == 0, allowed.stderr


def test_modules_of_the_current_folder_are_not_imported(tmp_path):
    """It may be anybody's: neither the program nor its workers look there before the standard library."""
    for name in ("json", "socket", "threading"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('a module of the current folder was run')\n")
    run = compare(tmp_path, "plain.json", program=SCRIPT, frames=2, seeds=2)
    assert run.returncode == 0, run.stderr


def test_runs_that_shared_the_machine_are_told_apart_from_those_that_did_not(finished, tmp_path):
    assert "were not alone" not in finished[1].stdout
    assert "some runs were not alone (--jobs)" in compare(tmp_path, jobs=2).stdout


def test_one_seed_is_compared_but_not_tested(tmp_path):
    run = compare(tmp_path, program=SCRIPT, seeds=1)
    assert run.returncode == 0, run.stderr
    assert "not tested" in run.stdout and "lower (" not in run.stdout
    text = " ".join(run.stdout.split())
    assert "quiet is not tested against plain, in single frames or at equal time." in text


def test_one_seed_has_no_standard_error(tmp_path):
    run = compare(tmp_path, seeds=1, brief=[])
    assert run.returncode == 0, run.stderr
    assert "nan" not in run.stdout and re.search(r"^ *quiet +[\d.]+% +[\d.]+% ", run.stdout, re.MULTILINE), run.stdout


def test_files_of_an_earlier_comparison_do_not_stay(tmp_path):
    """But for those that others wrote, or changed."""
    first = compare(tmp_path, "plain.json", "plain.json@label=b", "plain.json@label=c", at="4,8")
    assert "tables.txt, summary.csv, runs.csv, frames.csv and images/*.exr lie beside it" in first.stdout, first.stderr
    images = tmp_path / "out/images"
    assert (tmp_path / "out/frames.csv").exists() and (images / "scene.b.exr").exists()
    for own in (tmp_path / "out/mine.csv", images / "scene.mine.exr", images / "scene.c.exr"):
        own.write_text("mine")
    second = compare(tmp_path, "plain.json")
    assert "tables.txt, summary.csv, runs.csv and images/*.exr lie beside it" in second.stdout, second.stderr
    there = {str(path.relative_to(tmp_path / "out")) for path in (tmp_path / "out").rglob("*.*")}
    expected = {"report.html", "tables.txt", "summary.csv", "runs.csv", "written.json", "mine.csv"}
    expected |= {f"images/scene.{name}.exr" for name in ("reference", "plain", "mine", "c")}
    assert {name for name in there if not name.startswith("cache/")} == expected


def test_a_picture_can_be_the_reference(finished, tmp_path):
    run = compare(tmp_path, size="64x48", reference=finished[0] / "out/images/scene.reference.exr")
    assert run.returncode == 0, run.stderr
    assert "taken as exact" in run.stdout


@pytest.mark.parametrize(
    "methods, options, words",
    [
        (["absent.py"], {}, "absent.py: no such graph file"),
        (["plain.json@noise"], {}, "'noise' is not NAME=VALUE"),
        (["plain.json@gian=2"], {}, "no pass has a knob 'gian'"),
        (["plain.json@paths.gian=2"], {}, "no knob 'paths.gian'"),
        (["plain.json@output=normal"], {}, "no output 'normal'; there are: image"),
        (["plain.json", "plain.json"], {}, "two pictures would be called 'plain'"),
        (["plain.json@label=a/b", "plain.json@label=a b"], {}, "two pictures would be called 'a/b'"),
        (["plain.json@label="], {}, "give it another @label=NAME"),
        (["plain.json@label=" + 300 * "x"], {}, "give it another @label=NAME"),
        (["plain.json"], {"scenes": "absent.glb"}, "absent.glb: no such scene"),
        (["plain.json"], {"scenes": "broken.glb"}, "broken.glb: not a scene"),
        (["plain.json"], {"size": "12"}, "'12' is not WIDTHxHEIGHT"),
        (["plain.json"], {"frames": "0"}, "'0' is not a whole number"),
        (["plain.json"], {"reference": "plain.json"}, "plain.json: cannot be read"),
        (["plain.json"], {"scenes": ["scene.gltf", "again/scene.gltf"]}, "two scenes would be called 'scene'"),
        (["plain.json"], {"scenes": ["scene.gltf", "broken.glb"], "reference": "x.exr"}, "reference of 2 scenes"),
        (["bad.json"], {}, "bad.json: not JSON"),
        (
            ["plain.json"],
            {"out": "plain.json"},
            "plain.json: cannot be written to: not a folder; choose another folder with",
        ),
        (["plain.json"], {"camera": -1}, "'-1' is not a whole number of at least 0"),
        (["plain.json"], {"seeds": 10**12}, "at most 1000000"),
        (["plain.json"], {"at": "1,99999999999"}, "no ascending list"),
        (["plain.json@noise=" + 9999 * "["], {}, "noise"),
        (["plain.json@noise=" + 9999 * "9"], {}, "noise"),
        (["deep.json"], {}, "deep.json: not JSON"),
        (["plain.json"], {"scenes": "."}, "no such scene"),
        (["plain.json"], {"scheduler": "nowhere"}, "nowhere"),
    ],
)
def test_a_mistake_is_one_line_and_exit_code_2(tmp_path, methods, options, words):
    (tmp_path / "broken.glb").touch()
    (tmp_path / "bad.json").write_text("{")
    (tmp_path / "deep.json").write_text(10**5 * "[")
    # Without matplotlib, for that takes a second to import, and what is wrong is told at once.
    run = compare(tmp_path, *methods, program=changed('sys.modules["matplotlib"] = None'), **options)
    assert run.returncode == 2
    lines = [line for line in run.stderr.splitlines() if not line.startswith(("usage:", " "))]
    assert len(lines) == 1 and words in lines[0], run.stderr
