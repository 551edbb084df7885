"""scripts/compare.py --reference: what the header of the picture says is compared with what is asked for."""

import json
import shutil

import numpy as np
import pytest
from harness_runs import compare, write_graph

from restirpg.harness import given_reference

KNOBS = json.dumps({"paths": {"bounces": 2, "jitter": True}})


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """The folder of a comparison that has written its reference, out/images/scene.reference.exr."""
    folder = tmp_path_factory.mktemp("first")
    run = compare(folder, "plain.json", frames=2, seeds=2)
    assert run.returncode == 0, run.stderr
    return folder


def given(folder, **changes):
    """truth.exr: the reference with other attributes, None takes one away."""
    file = folder / "out/images/scene.reference.exr"
    with open(file, "rb") as stream:
        image, header = np.load(stream), json.loads(stream.read())
    header |= {f"restirpg.{name}": value for name, value in changes.items()}
    with open(folder / "truth.exr", "wb") as stream:
        np.save(stream, image)
        stream.write(json.dumps({name: value for name, value in header.items() if value is not None}).encode())
    return "truth.exr"


def warnings(folder, *methods, **options):
    """The warnings of a comparison with truth.exr, each in one line."""
    run = compare(folder, *(methods or ["plain.json"]), frames=2, seeds=2, reference="truth.exr", **options)
    assert run.returncode == 0, run.stderr
    text = " ".join(run.stdout[: run.stdout.index("Equal frames")].split())
    return [line.strip() for line in text.split("warning: ")[1:]]


def test_one_of_another_scene_is_refused_in_a_line(first):
    given(first, sceneHash="0" * 16, scene="hall.glb")
    run = compare(first, "plain.json", frames=2, seeds=2, reference="truth.exr")
    assert run.returncode == 2 and run.stderr.count("\n") == 1
    assert (
        "truth.exr: this reference is of another scene, or of another version of it (hall.glb, hash 000" in run.stderr
    )


def test_one_that_says_nothing_or_the_same_is_taken(first):
    given(first, sceneHash=None)
    assert warnings(first) == []
    given(first)
    assert warnings(first) == []


def test_what_it_shows_otherwise_is_told(first):
    write_graph(first, "sharp", jitter=False)
    given(first, knobs=KNOBS, camera="1", environment="sky.exr", pose="0,0,0", denoised="true", history="kept")
    told = warnings(first, "sharp.json")
    assert len(told) == 7, told
    for words in (
        "truth.exr: its camera was moved: the difference",
        "truth.exr: it was denoised: the difference",
        "truth.exr: its history was kept over moves of the camera: the difference",
        "truth.exr: its camera is number 1, for the methods it is 0: the difference",
        "truth.exr: its environment is sky.exr, for the methods it is that of the scene",
        "sharp: its bounce cap is 4, that of truth.exr is 2",
        "sharp: its pixel filter (jitter) is false, that of truth.exr is true",
    ):
        assert any(line.startswith(words) for line in told), (words, told)
    assert "@gbuffer.jitter=true sets it" in " ".join(told)


def test_an_environment_is_known_by_its_content(first):
    sky = first / "sky.exr"
    sky.write_bytes(b"one")
    run = compare(first, "plain.json", frames=2, seeds=2, environment="sky.exr", out="sky")
    assert run.returncode == 0, run.stderr
    shutil.copy(first / "sky/images/scene.reference.exr", first / "truth.exr")
    assert warnings(first, environment="sky.exr", out="same") == []
    shutil.copy(sky, first / "renamed.exr")
    assert warnings(first, environment="renamed.exr", out="same") == []
    sky.write_bytes(b"another")
    (told,) = warnings(first, environment="sky.exr", out="same")
    assert told.startswith("truth.exr: its environment is sky.exr (hash ") and told.count("sky.exr (hash ") == 2


@pytest.mark.parametrize(
    "size, window, words",
    [
        ("1920x1080", "960,540,32,24", "960,540,32,24 of a picture of 1920x1080; here it is 0,0,32,24 of 32x24"),
        ("32x240", None, "0,0,32,240 of a picture of 32x240"),
        ("32x24", "0,0,32,12", "0,0,32,12 of a picture of 32x24"),
    ],
)
def test_one_of_other_pixels_is_refused_in_a_line(first, size, window, words):
    given(first, size=size, window=window)
    run = compare(first, "plain.json", frames=2, seeds=2, reference="truth.exr")
    assert run.returncode == 2 and run.stderr.count("\n") == 1
    assert "truth.exr: this reference is of other pixels (" + words in run.stderr


@pytest.mark.parametrize(
    "options, named",
    [
        ({"reference_graph": "plain.json"}, "--reference-graph"),
        ({"reference_frames": 16, "reference_batches": 2}, "--reference-batches, --reference-frames"),
    ],
)
def test_how_one_would_be_rendered_is_refused_beside_it(tmp_path, options, named):
    run = compare(tmp_path, "plain.json", reference="truth.exr", **options)
    assert run.returncode == 2 and run.stderr.count("\n") == 1
    assert f"--reference takes the place of a rendered one; leave out {named}" in run.stderr


def test_methods_of_two_pixel_filters_are_told_of_a_rendered_reference_alone(first):
    for jitter in (True, False):
        write_graph(first, f"filter_{jitter}", jitter=jitter)
    run = compare(first, "filter_True.json", "filter_False.json", frames=2, seeds=2, out="rendered")
    (told,) = [line for line in run.stdout.splitlines() if line.startswith("warning: ")]
    assert told.startswith("warning: filter_False: its pixel filter (jitter) is false, that of the reference is true: ")
    assert told.endswith("; @gbuffer.jitter=false gives all the same")
    given(first)
    assert warnings(first, "filter_True.json", "filter_False.json", out="given") == []


@pytest.mark.parametrize("text", ["no JSON", "[1]", '{"a": 3}', '{"a": {"bounces": "x"}, "b": {"bounces": 1}}'])
def test_a_header_of_another_program_is_not_taken_amiss(text):
    assert given_reference.mean_of_header({given_reference.KNOBS: text}) == {}
