"""scripts/reproduce.py --paper-size: what it makes of finished scenes, and what it refuses."""

import csv
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import paper_figure
import pytest
from harness_runs import ENVIRONMENT, changed, csv_rows, write_graph

import restirpg
from restirpg.harness import UserError, compare
from restirpg.harness.paper import full_size

ROOT = Path(__file__).parents[2]
COLUMNS = ("scene", "method", "tiles", "frames", "mape", "mape_se", "mape_reference_se", "change", "change_se",
           "change_reference_se", "p", "gpu_ms_per_frame", "wall_ms_per_frame")  # fmt: skip
ROWS = {
    "restir_pt": (0.30, 0.01, 0.002, 0, 0, 0, "nan", 9000, 9100),
    "restir_pg": (0.27, 0.01, 0.002, -0.1, 0.01, 0.004, 1e-6, 11000, 11100),
    "raw_pt_ruppert2020": (0.26, 0.01, 0.002, -0.1333, 0.08, 0.004, 0.09, 12000, 12100),
}


def run(*arguments):
    """The program's finished process."""
    return subprocess.run(
        [sys.executable, ROOT / "scripts/reproduce.py", "--paper-size", *map(str, arguments)],
        capture_output=True,
        text=True,
    )


@pytest.fixture
def recorded(tmp_path):
    """A folder in which one scene is finished."""
    folder = tmp_path / "out" / "room"
    folder.mkdir(parents=True)
    with open(folder / "tiles.csv", "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(COLUMNS)
        writer.writerows(("scenes/room.glb", method, 64, 10, *numbers) for method, numbers in ROWS.items())
    write_runs(folder / "runs.csv", "room")
    return folder.parent


def write_runs(file, scene):
    """The errors of two frames in two tiles: no more of a runs.csv than is read."""
    with open(file, "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(("scene", "method", "tile", "frame", "mape", "mape_single", "relmse"))
        for method in ROWS:
            for tile in range(2):
                for frame in (11, 12):
                    writer.writerow((f"scenes/{scene}.glb", method, tile, frame, 9, frame + tile, 10 * frame + tile))


def test_the_table_says_plainly_who_errs_least(recorded, tmp_path):
    done = run("--collect", recorded, "--results", tmp_path / "results")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "results/tables.md").read_text()
    assert "| room | restir_pg | 27.00 ± 1.00 ± 0.20% | -10.00 ± 1.00 ± 0.40% | 1e-06 | 11.0 |" in text
    assert "the lowest mean error has raw_pt_ruppert2020, 26.0%; restir_pg does not have the lowest: 27.0%" in text
    assert (
        "restir_pg errs 10.0% less than restir_pt; raw_pt_ruppert2020 errs 13.3% less than restir_pt, which is not significant."
        in text
    )
    found = csv_rows(tmp_path / "results/summary.csv")
    assert [(row["scene"], row["method"]) for row in found] == [("room", method) for method in ROWS]


def test_the_errors_of_each_tile_are_means_over_its_frames(recorded, tmp_path):
    assert run("--collect", recorded, "--results", tmp_path / "results").returncode == 0
    found = csv_rows(tmp_path / "results/tile_errors.csv")
    assert [tuple(row.values()) for row in found] == [
        ("room", method, str(tile), str(11.5 + tile), str(115 + tile)) for method in ROWS for tile in range(2)
    ]


def test_a_scene_without_the_errors_of_its_tiles_is_told(recorded, tmp_path):
    (recorded / "room/runs.csv").unlink()
    done = run("--collect", recorded, "--results", tmp_path / "results")
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "room/runs.csv: the errors of the tiles are missing" in done.stderr
    assert not (tmp_path / "results").exists()


def test_a_standard_error_that_is_not_known_is_a_dash(recorded, tmp_path):
    table = recorded / "room/tiles.csv"
    table.write_text(table.read_text().replace(",0.002,", ",nan,").replace(",0.004,", ",nan,"))
    done = run("--collect", recorded, "--results", tmp_path / "results")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "results/tables.md").read_text()
    assert "| room | restir_pg | 27.00 ± 1.00 ± —% | -10.00 ± 1.00 ± —% | 1e-06 | 11.0 |" in text and "nan" not in text


def test_scenes_whose_times_have_their_older_names_are_collected_with_the_others(recorded, tmp_path):
    older = recorded / "older"
    older.mkdir()
    text = (recorded / "room/tiles.csv").read_text().replace("_ms_per_frame", "_ms")
    (older / "tiles.csv").write_text(text.replace("room.glb", "older.glb"))
    write_runs(older / "runs.csv", "older")
    done = run("--collect", recorded, "--results", tmp_path / "results")
    assert done.returncode == 0, done.stderr
    with open(tmp_path / "results/summary.csv", newline="") as stream:
        found = list(csv.DictReader(stream))
    assert {row["scene"]: float(row["gpu_ms_per_frame"]) for row in found} == {"room": 12000, "older": 12000}
    assert "gpu_ms" not in found[0]


def test_what_it_cannot_do_is_said_in_a_line(tmp_path):
    room = tmp_path / "room.glb"
    room.touch()
    twice = (f"{room}@64x64", f"{room}@32x32")
    for arguments, words in (
        ((), "no scene given"),
        ((room, "absent.glb"), "absent.glb: no such scene"),
        (("--list", "absent.glb"), "absent.glb: no such scene"),
        ((room, "--results", tmp_path), "--results is where --collect writes"),
        (("--collect", tmp_path, room), "leave out --list and the scenes"),
        (("--collect", tmp_path), "no scene is finished there"),
        ((*twice, "--out", tmp_path), "two scenes would be called 'room'"),
    ):
        done = run(*arguments)
        assert done.returncode == 2 and words in done.stderr and done.stderr.count("\n") == 1


@pytest.fixture
def hours(tmp_path):
    """What --list says with these arguments: {scene: (hours at least, at most)}."""
    rooms = [tmp_path / "veach_ajar.glb", tmp_path / "hall.glb"]
    for room in rooms:
        room.touch()

    def told(*arguments):
        done = run("--list", *arguments, rooms[0], f"{rooms[1]}@960x540")
        assert done.returncode == 0, done.stderr
        lines = (re.match(r"(\S+) +\S+  (\S+) to (\S+) hours, ", text) for text in done.stdout.splitlines())
        return {line[1]: (float(line[2]), float(line[3])) for line in lines}

    return told


def test_the_hours_of_each_scene_are_told(hours):
    found = hours("--bounces", 4)
    assert list(found) == ["veach_ajar", "hall"]
    low, high = found["veach_ajar"]
    assert 2 < low / found["hall"][0] < 4 and 0.3 < low < high < 3


def test_the_hours_are_those_of_the_options(hours):
    plain, longer = hours(), hours("--reference-frames", 102400, "--tiles", 32)
    assert longer["hall"][1] > 10 * plain["hall"][1]
    assert hours("--seeds", 4)["veach_ajar"][1] > 3 * plain["veach_ajar"][1]


def test_help_has_the_defaults_of_the_program_that_is_asked():
    own, of_compare = (
        " ".join(subprocess.run([sys.executable, *command, "--help"], capture_output=True, text=True).stdout.split())
        for command in ([ROOT / "scripts/reproduce.py", "--paper-size"], [ROOT / "scripts/compare.py"])
    )
    for words, others in (
        ("pixels (1920x1080)", "pixels (160x90)"),
        ("frames of a run (the last of --at)", "frames of a run (32, or the last of --at)"),
        ("in place of the mean of all frames (11,12,13,14,15,16,17,18,19,20)", "in place of the mean of all frames --"),
        ("with --at (64)", "with --at --"),
        ("over all its batches (1024)", "over all its batches (32 times --frames)"),
    ):
        assert words in own and others in of_compare, (words, own)


def test_an_option_that_there_is_not_is_refused(tmp_path):
    done = run("--list", "--nonsense", "room.glb")
    assert done.returncode == 2 and done.stdout == "" and "--nonsense" in done.stderr


@pytest.mark.parametrize("arguments, refused", [([], None), (["--reference-batches", "4"], "--reference-batches")])
def test_a_reference_that_is_given_is_not_one_that_is_rendered(tmp_path, arguments, refused):
    """The program has defaults of its own of how one is rendered."""
    options = full_size.parse([*arguments, "--reference", "truth.exr", "room.glb"])
    if not refused:
        compare.refuse_ignored(options, full_size.parse([]))
        return
    with pytest.raises(UserError, match=f"leave out {refused}$"):
        compare.refuse_ignored(options, full_size.parse([]))


def test_each_scene_is_compared_with_what_the_command_line_says(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(full_size.compare, "run", lambda *arguments: asked.append(arguments) or 0)
    room = tmp_path / "room.glb"
    room.touch()
    assert full_size.main(["--bounces", "4", "--device", "D", f"{room}@32x24", "--tiles", "8", "--out", "o"]) == 0
    [(options, name, _)] = asked
    settings = compare.settings_from(options)
    assert name == "reproduce.py" and settings.scenes == (str(room),) and settings.size == (32, 24)
    assert (settings.bounces, settings.tiles, settings.seeds, settings.at) == (4, 8, 1, tuple(range(11, 21)))
    assert {method.device for method in settings.methods} == {"D"} and len(settings.methods) == len(full_size.GRAPHS)
    assert (options.out, options.cache) == ("o/room", "o/cache")


#: The program with graphs of the fake renderer.
ON_THE_FAKE_RENDERER = """
from restirpg.harness.paper import full_size
full_size.graph_file = lambda name: "plain.json"
sys.exit(commands.reproduce())
"""


def test_the_report_says_by_which_command_it_was_made(tmp_path):
    write_graph(tmp_path)
    (tmp_path / "room.gltf").touch()
    command = [*changed(ON_THE_FAKE_RENDERER), "--paper-size", "room.gltf", "--size", "32x24", "--at", "2,3"]
    command += ["--tiles", "4", "--tile-size", "8", "--reference-graph", "plain.json", "--reference-frames", "32"]
    done = subprocess.run([*command, "--out", "out"], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "out/room/report.html").read_text()
    assert "<td>scripts/reproduce.py --paper-size room.gltf --size 32x24 " in text


def figure(recorded, *arguments, crop="4,4"):
    """benchmarks/paper_figure.py, run to its end."""
    command = [sys.executable, ROOT / "benchmarks/paper_figure.py", recorded / "room", "--crop", "0,0", "--crop", crop]
    command += ["--scene", "room.glb", "--side", 4, "--bounces", 0, "--png", recorded / "figure.png", *arguments]
    return subprocess.run(list(map(str, command)), capture_output=True, text=True)


def test_the_figure_s_command_is_as_its_help_says():
    command = paper_figure.__doc__.split("\n\n")[1].replace("X,Y", "0,0").replace("N ", "4 ")
    options = paper_figure.parse(re.sub(r"\[.*?\]", "", command).split()[1:])
    assert (options.scene, options.bounces, len(options.crop)) == ("SCENE.glb", 4, 2)


def test_a_figure_that_cannot_be_drawn_is_one_line(recorded):
    images = recorded / "room/images"
    images.mkdir()
    for method in ROWS:
        restirpg.write_exr(images / f"room.{method}.whole.exr", {"": np.ones((9, 16, 3), np.float32)})
    beyond = figure(recorded, crop="4,6")
    assert "--crop 4,6: 4x4 pixels from there reach beyond the picture of 16x9" in beyond.stderr
    third = figure(recorded, "--crop", "1,1")
    assert "the figure has two crops, not 3" in third.stderr
    scene = figure(recorded)
    assert "room.glb" in scene.stderr
    table = recorded / "room/tiles.csv"
    whole = table.read_text()
    table.write_text(whole.replace(",mape_se,", ",spread,"))
    column = figure(recorded)
    assert "tiles.csv: it lacks numbers in a column mape or mape_se" in column.stderr
    table.write_text(whole.replace("restir_pg,", "other,"))
    other = figure(recorded)
    assert "tiles.csv: no row is of restir_pg" in other.stderr
    table.unlink()
    absent = figure(recorded)
    assert "tiles.csv: cannot be read: No such file or directory; name the folder of a scene" in absent.stderr
    for done in (beyond, third, scene, column, other, absent):
        assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
