"""scripts/compare.py --tiles: errors measured in random tiles of a picture, of which alone a reference is rendered."""

import json
import math

import numpy as np
import pytest
from harness_runs import compare, csv_rows, write_graph

from restirpg.colour import luminance
from restirpg.harness import UserError, tiles
from restirpg.harness import statistics as st

AT = {"at": "3,4,5", "frames": 5, "seeds": 1, "reference_frames": 64, "reference_batches": 4}


def frames(folder):
    """frames.csv: (method, frame) -> row."""
    return {(row["method"], row["frame"]): row for row in csv_rows(folder / "out/frames.csv")}


def picture_and_truth(rng):
    """A truth with a strong gradient, and a picture of it whose error grows with it and across it."""
    y, x = np.mgrid[0:64, 0:96]
    truth = np.exp(-x / 20 + y / 40)[..., None] * np.array([1.0, 0.7, 0.5])
    return truth * (1 + rng.normal(0, 0.1 + 0.4 * (x > 60)[..., None], truth.shape)), truth


def mape(picture, truth):
    """Of the whole picture, as ErrorMeasure has it."""
    y = luminance(truth)[..., None]
    return np.mean(np.abs(picture - truth) / (0.01 * y.mean() + y))


def estimates(count, draws):
    """MAPE by `count` tiles of 96, less the whole picture's, and what standard error the tiles claim, over seeds."""
    picture, truth = picture_and_truth(np.random.default_rng(1))
    found = []
    for seed in range(draws):
        corners = tiles.choose((96, 64), count, 8, seed)
        own = tiles.errors(tiles.stack(picture, corners, 8), tiles.stack(truth, corners, 8), 8)["mape"]
        found.append((own.mean() - mape(picture, truth), st.mean_se(own)[1]))
    return np.array(found).T


def test_the_mean_over_tiles_is_the_pictures_error_without_bias():
    # Null hypothesis: the mean of 2000 estimates by 24 of 96 tiles is the whole picture's MAPE. False alarm: 1 in
    # 16,000 (4 standard errors). A bias of 2% of MAPE is 6 standard errors.
    difference, claimed = estimates(24, 2000)
    mean, se = st.mean_se(difference)
    assert abs(mean) < 4 * se < 0.004
    # Without replacement the spread is sqrt(1 - 24/96) of what independent tiles have.
    assert difference.std() == pytest.approx(math.sqrt(0.75) * math.sqrt(np.mean(claimed**2)), rel=0.08)


def test_a_mean_of_each_tile_of_its_own_would_be_found():
    picture, truth = picture_and_truth(np.random.default_rng(1))
    corners = tiles.choose((96, 64), 96, 8, 0)
    own = [mape(picture[y : y + 8, x : x + 8], truth[y : y + 8, x : x + 8]) for x, y in corners]
    assert abs(np.mean(own) - mape(picture, truth)) > 0.01 > 4 * st.mean_se(estimates(24, 500)[0])[1]


def test_all_tiles_measure_what_the_whole_picture_measures(tmp_path):
    methods = ["plain.json", "plain.json@noise=0.5,broken=3,label=quiet"]
    whole = compare(tmp_path, *methods, **AT)
    assert whole.returncode == 0, whole.stderr
    expected = frames(tmp_path)
    run = compare(tmp_path, *methods, **AT, tiles=12, tile_size=8)
    assert run.returncode == 0, run.stderr
    found = frames(tmp_path)
    assert found.keys() == expected.keys()
    for key, row in found.items():
        if key[0] == "plain":
            for name in ("mape", "relmse", "bias"):
                assert float(row[name]) == pytest.approx(float(expected[key][name]), rel=1e-5), (key, name)
        assert float(row["mape_se"]) > 0
    assert "Mean of 3 single frames, 3 to 5, in 12 tiles" in run.stdout
    assert "In single frames, 3 to 5, quiet has " in run.stdout and "(12 tiles)" in run.stdout


def test_another_reference_takes_no_run_again_and_costs_the_tiles_alone(tmp_path):
    first = compare(tmp_path, **AT, tiles=5, tile_size=8)
    assert first.returncode == 0, first.stderr
    before = set((tmp_path / "out/cache").glob("*.npz"))
    again = compare(tmp_path, **{**AT, "reference_frames": 128}, tiles=5, tile_size=8)
    assert again.returncode == 0, again.stderr
    jobs = []
    for path in set((tmp_path / "out/cache").glob("*.npz")) - before:
        with np.load(path) as file:
            job = json.loads(str(file["meta"])).get("job")
            jobs += [(job["label"].split()[0], file["image"].shape)] if job else []
    assert jobs == [("reference", (40, 8, 3))] * 4


def test_the_references_noise_has_a_standard_error_of_its_own(tmp_path):
    """16 times the frames quarter it, about: 16 batches tell it to 20%."""
    found = {}
    for frames in (64, 1024):
        options = {**AT, "reference_frames": frames, "reference_batches": 16}
        assert compare(tmp_path, **options, tiles=12, tile_size=8).returncode == 0
        found[frames] = [float(row["mape_reference_se"]) for row in csv_rows(tmp_path / "out/tiles.csv")]
    for few, many in zip(found[64], found[1024]):
        assert 2 < few / many < 8


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"tile_size": 8}, "--tile-size is that of --tiles; leave it out, or add --tiles"),
        ({"tiles": 4, "tile_size": 8}, "--at 11,12,13"),
        ({**AT, "tiles": 4, "tile_size": 7}, "--tile-size"),
        ({**AT, "tiles": 13, "tile_size": 8}, "only 12 tiles"),
    ],
)
def test_what_cannot_be_tiled_is_refused_in_a_line(tmp_path, options, words):
    run = compare(tmp_path, **options)
    assert run.returncode == 2 and words in run.stderr and run.stderr.count("\n") == 1


def test_tiles_are_drawn_once_each_and_by_the_seed():
    corners = tiles.choose((96, 64), 96, 8, 3)
    assert sorted(corners) == sorted({(x, y) for x in range(0, 96, 8) for y in range(0, 64, 8)})
    assert tiles.choose((96, 64), 9, 8, 3) == tiles.choose((96, 64), 9, 8, 3) != tiles.choose((96, 64), 9, 8, 4)
    with pytest.raises(UserError, match="only 96 tiles"):
        tiles.choose((96, 64), 97, 8, 3)


def test_an_exr_of_the_whole_picture_is_a_reference_too(tmp_path):
    with open(tmp_path / "truth.exr", "wb") as stream:
        np.save(stream, np.full((24, 32, 3), 0.2, np.float32))
    write_graph(tmp_path)
    run = compare(tmp_path, at="3,4,5", seeds=1, tiles=5, tile_size=8, reference="truth.exr")
    assert run.returncode == 0, run.stderr
