"""The renderer through Python: frames, seeds, windows, cuts, knobs, interrupts and refusals."""

import locale
import os
import re
import shutil
import signal
import subprocess
import threading
import time

import numpy as np
import pytest
from renderer_scenes import GRAPH, ROOT, SIZE, check_samples, frame_graph, image_after, make_renderer, refusal, restirpg

from restirpg.harness import render
from restirpg.harness.jobs import parse_method


def test_an_output_is_a_finite_float32_array_of_rows(renderer):
    image = image_after(renderer, 2)
    assert image.shape == (SIZE[1], SIZE[0], 3) and image.dtype == np.float32
    check_samples(renderer)
    assert np.isfinite(image).all() and image.mean() > 0.05
    # Rows from the top: the light hangs from the ceiling.
    assert image[: SIZE[1] // 2].mean() > image[SIZE[1] // 2 :].mean()


def test_the_same_seed_gives_the_same_bytes_and_another_seed_another_picture(scene):
    first, again, other = (image_after(make_renderer(scene, seed=seed), 3) for seed in (5, 5, 6))
    assert first.tobytes() == again.tobytes()
    assert first.tobytes() != other.tobytes()


def test_a_seed_and_a_cut_begin_the_run_of_a_new_renderer(scene):
    graph = restirpg.load_graph(GRAPH.with_name("restir_pt.py"))  # history everywhere
    fresh = {seed: image_after(make_renderer(scene, graph, seed=seed), 3).tobytes() for seed in (5, 6)}
    renderer = make_renderer(scene, graph, seed=9)
    renderer.render(4)
    for seed in (5, 6, 5):
        renderer.seed = seed
        renderer.cut()
        assert renderer.seed == seed
        assert image_after(renderer, 3).tobytes() == fresh[seed]
    assert fresh[5] != fresh[6]


def test_a_window_has_the_bytes_that_the_whole_picture_has_there(scene):
    whole = image_after(make_renderer(scene, seed=5), 3)
    renderer = make_renderer(scene, seed=5, window=(3, 10, 16, 8))
    assert renderer.window == (3, 10, 16, 8) and renderer.size == SIZE
    assert image_after(renderer, 3).tobytes() == whole[10:18, 3:19].tobytes()
    renderer.move_window(16, 24)
    assert renderer.frame == 0 and renderer.window == (16, 24, 16, 8)
    assert image_after(renderer, 3).tobytes() == whole[24:, 16:].tobytes()
    assert np.unique(whole[10:18, 3:19]).size > 100  # no blank wall

    def memory(renderer):
        return sum(bytes for name, bytes in renderer.memory().items() if name != "scene")

    assert 8 * memory(renderer) == memory(make_renderer(scene))


def test_a_window_beyond_the_picture_is_refused(scene):
    for window in ((0, 0, 33, 8), (30, 0, 3, 8), (0, 32, 8, 1), (0, 0, 0, 8), (2**32 - 1, 0, 8, 8)):
        assert "does not lie in the picture of 32x32" in refusal(make_renderer, scene, window=window)
    renderer = make_renderer(scene, window=(0, 0, 8, 8))
    assert "a window of 8x8 pixels at 25,0" in refusal(renderer.move_window, 25, 0)
    assert renderer.window == (0, 0, 8, 8)


def test_frames_add_up_whichever_way_they_are_asked_for(scene):
    in_one = make_renderer(scene)
    in_three = make_renderer(scene)
    in_one.render(5)
    for count in (1, 0, 4):
        in_three.render(count)
    assert in_one.frame == in_three.frame == 5
    assert in_one.output("image").tobytes() == in_three.output("image").tobytes()


def test_mean_and_variance_are_those_of_the_frames_seen_one_by_one(scene):
    renderer = make_renderer(scene, frame_graph())
    frames = []
    for _ in range(12):
        renderer.render(1)
        frames.append(renderer.output("radiance").astype(float) + renderer.output("emission"))
    frames = np.array(frames)
    np.testing.assert_allclose(renderer.output("mean"), frames.mean(0), rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(renderer.output("variance"), frames.var(0, ddof=1), rtol=2e-5, atol=1e-7)


def test_a_cut_forgets_every_frame(renderer):
    first = image_after(renderer, 2)
    more = image_after(renderer, 3)
    renderer.cut()
    assert renderer.frame == 0
    assert image_after(renderer, 2).tobytes() == first.tobytes() != more.tobytes()


@pytest.mark.parametrize(
    ("graph", "knob", "value"),
    [
        ("restir_pt", "paths.nee", False),  # paths to lights without a surface are found no more
        ("path_tracer", "paths.direct", False),
        ("path_tracer", "gbuffer.jitter", False),
        ("raw_pt_derevyannykh2022", "guide.lobe", "vmf"),  # its moments are of other numbers
        ("raw_pt_derevyannykh2022", "guide.product", None),
        ("raw_pt_alber2025", "guide.product", None),
    ],
)
def test_a_knob_that_the_histories_do_not_cover_empties_them(scene, graph, knob, value):
    renderer = make_renderer(scene, restirpg.load_graph(ROOT / f"graphs/{graph}.py"), size=(8, 8))
    renderer.render(2)
    value = not renderer.get(knob) if value is None else value
    assert renderer.get(knob) != value
    renderer.set(knob, value)
    assert renderer.frame == 0 and renderer.get(knob) == value


def test_knobs_of_a_method_are_read_as_those_of_the_command_line(renderer):
    source = (ROOT / "framework/graph/knob.cpp").read_text()
    words = [re.findall(r'"(\w+)"', group) for group in re.findall(r"for \(const char\* \w+ : \{(.*?)\}\)", source)]
    assert [[word for word, on in render.SWITCHES.items() if on == value] for value in (True, False)] == words
    for word, on in {**render.SWITCHES, "Off": False, "TRUE": True}.items():
        renderer.set("paths.nee", not on)
        render.apply_knobs(renderer, parse_method(f"{GRAPH}@paths.nee={word}").knobs, GRAPH)
        assert renderer.get("paths.nee") is on, word
    with pytest.raises(restirpg.WrongValueError, match='"perhaps"'):
        render.apply_knobs(renderer, parse_method(f"{GRAPH}@nee=perhaps").knobs, GRAPH)


def test_knobs_are_read_set_and_refused_by_name(renderer):
    assert renderer.knobs()["paths"]["bounces"] == renderer.get("paths.bounces")
    renderer.set("paths.bounces", 3)
    assert renderer.get("paths.bounces") == 3
    assert renderer.set_everywhere("bounces", np.uint8(4)) == 1
    assert renderer.get("paths.bounces") == 4
    assert renderer.set_everywhere("no_such_knob", 1) == 0
    with pytest.raises(restirpg.WrongValueError, match="has no knob 'bonces'; knobs: .*did you mean 'bounces'"):
        renderer.get("paths.bonces")
    for path, value in [
        ("paths.bounces", "many"),
        ("paths.bounces", -1),
        ("paths.bounces", 2.5),
        ("paths.bounces", None),
        ("paths.bounces", float("nan")),
        ("paths.bonces", 2),
        ("pads.bounces", 2),
        ("bounces", 2),
    ]:
        assert "\n" not in refusal(renderer.set, path, value)
    assert renderer.get("paths.bounces") == 4


def test_a_pass_tells_its_ports_and_knobs():
    declared = restirpg.describe_pass("PathTracerGuided")
    knobs = {knob["name"]: knob for knob in declared["knobs"]}
    assert declared["meaning"] and (knobs["bounces"]["type"], knobs["bounces"]["minimum"]) == ("uint", 0)
    assert [type(knobs["bounces"][end]) for end in ("minimum", "maximum")] == [int, int]  # a setting that it takes
    assert [type(knobs["alpha"][end]) for end in ("minimum", "maximum")] == [float, float]
    assert knobs["nee"]["default"] is True and "minimum" not in knobs["nee"]
    splat = {knob["name"]: knob for knob in restirpg.describe_pass("GuidingSplat")["knobs"]}
    assert splat["final_edges"]["choices"] == ["all", "scattered", "none"]
    outputs = {port["name"]: port for port in declared["outputs"]}
    assert (outputs["radiance"]["type"], outputs["radiance"]["channels"]) == ("Image3", 3)
    assert {"name", "type", "channels", "meaning"} == declared["inputs"][0].keys()
    assert "no pass type 'Nothing'; pass types: Accumulate" in refusal(restirpg.describe_pass, "Nothing")
    assert refusal(restirpg.describe_pass, "GBufer").endswith("; did you mean 'GBuffer'?")


def test_numbers_have_a_point_in_every_locale(scene_file, tmp_path, monkeypatch):
    german = "de_DE.UTF-8"  # which writes 0,5
    command = ["localedef", "-i", "de_DE", "-f", "UTF-8", tmp_path / german]
    if not shutil.which("localedef") or subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("localedef and the sources of locales are not here: no number is read in another locale")
    (tmp_path / "sky.hdr").write_bytes(b"#?RADIANCE\nEXPOSURE=0.5\n\n-Y 1 +X 1\n\x80\x80\x80\x80")
    monkeypatch.setenv("LOCPATH", str(tmp_path))
    before = locale.setlocale(locale.LC_NUMERIC)
    locale.setlocale(locale.LC_NUMERIC, german)
    try:
        knobs = {knob["name"]: knob for knob in restirpg.describe_pass("PathTracerGuided")["knobs"]}
        restirpg.load_scene(scene_file, environment=str(tmp_path / "sky.hdr"))
    finally:
        locale.setlocale(locale.LC_NUMERIC, before)
    assert knobs["alpha"]["default"] == 0.5


def test_a_knob_that_several_passes_have_takes_one_kind_of_value():
    """Else set_everywhere has no value for all of them."""
    numbers = {"int": "number", "uint": "number", "float": "number"}
    types = {}
    for name in sorted(folder.name for folder in (GRAPH.parents[1] / "passes").iterdir() if folder.is_dir()):
        for knob in restirpg.describe_pass(name)["knobs"]:
            types.setdefault(knob["name"], {})[name] = numbers.get(knob["type"], knob["type"])
    assert len(types) > 50
    assert [knob for knob, of in types.items() if len(set(of.values())) > 1] == []


def test_a_knob_turns_the_picture(renderer):
    assert np.median(image_after(renderer, 4)) > 0.05
    renderer.cut()
    renderer.set("paths.bounces", 0)  # no indirect light
    renderer.set("paths.direct", False)
    dark = image_after(renderer, 4)
    assert np.median(dark) == 0 and dark.max() > 1  # but for the light itself


def test_other_threads_run_while_frames_are_rendered(renderer):
    thread = threading.Thread(target=renderer.render, args=(60,))
    thread.start()
    turns = 0
    while thread.is_alive():
        turns += 1
        time.sleep(0.001)
    # With the interpreter locked, this thread would get a turn before the frames and one after them.
    assert turns > 10 and renderer.frame == 60


def test_an_interrupt_ends_rendering_between_two_frames(renderer):
    # Not after a time: on a machine that stood still meanwhile, the signal would come before the frames, to pytest.
    def interrupt():
        while renderer.frame < 3:
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        threading.Thread(target=interrupt, daemon=True).start()
        renderer.render(3000)
    assert 3 <= renderer.frame < 3000
    check_samples(renderer)
    assert renderer.output("image").mean() > 0.05


def test_a_graph_is_taken_as_a_file_an_object_or_a_dictionary(scene):
    graph = frame_graph()
    one = image_after(make_renderer(scene, graph), 1, "mean")
    two = image_after(make_renderer(scene, graph.description()), 1, "mean")
    assert one.tobytes() == two.tobytes()
    assert "is not a graph" in refusal(make_renderer, scene, 7)


def test_the_scene_tells_what_it_holds(scene, scene_file):
    assert "Tower" in scene.nodes and scene.cameras == 1 and scene.triangles > 20 and len(scene.hash) == 16
    bright = restirpg.load_scene(scene_file, environment="3,3,3")
    assert image_after(make_renderer(bright), 2).mean() > image_after(make_renderer(scene), 2).mean()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"device": "no such device"}, "no such device"),
        ({"backend": "magic"}, "magic"),
    ],
)
def test_an_impossible_device_is_one_clear_error(scene, options, words):
    text = refusal(make_renderer, scene, **options)
    assert words in text and "\n" not in text


def test_bad_files_and_sizes_are_one_clear_error(scene, scene_file, tmp_path):
    assert str(tmp_path / "none.glb") in refusal(restirpg.load_scene, tmp_path / "none.glb")
    assert "there is no camera 3" in refusal(restirpg.load_scene, scene_file, camera=3)
    assert "none.py" in refusal(restirpg.load_graph, tmp_path / "none.py")
    assert "0x5" in refusal(restirpg.Renderer, scene, frame_graph(), size=(0, 5))
    graph = restirpg.Graph("Wrong")
    gbuffer = graph.add("gbuffer", "GBuffer")
    graph.output("image", gbuffer.norml)
    text = refusal(make_renderer, scene, graph)
    assert "test_renderer.py" in text and "norml" in text


def test_every_public_name_is_documented():
    for name in (
        "load_scene",
        "load_graph",
        "devices",
        "read_exr",
        "write_exr",
        "write_png",
        "measure_errors",
        "Error",
        "Renderer",
        "Scene",
    ):
        assert getattr(restirpg, name).__doc__.strip()
    for name, member in vars(restirpg.Renderer).items():
        assert name.startswith("_") or member.__doc__.strip(), name
