"""What users and programs do wrong with the module: an exception that says what, never a crash, nothing changed and
nothing leaked."""

import json
import math
import os
import re
import signal
import threading

import numpy as np
import pytest
from renderer_scenes import GRAPH, check_samples, make_renderer, restirpg, write_flying_panel
from renderer_scenes import one_line_refusal as refusal
from renderer_scenes import refusal as refusal_of_lines


@pytest.fixture(scope="module")
def renderer(scene):
    """One for all: what is refused leaves it as it was."""
    renderer = make_renderer(scene, size=(16, 16))
    renderer.render(1)
    return renderer


def test_a_renderer_needs_a_scene_and_a_graph(scene):
    graph = restirpg.load_graph(GRAPH)
    with pytest.raises(TypeError):
        restirpg.Renderer(None, graph, size=(16, 16))
    assert "None is not a graph" in refusal(restirpg.Renderer, scene, None, size=(16, 16))
    with pytest.raises(TypeError):
        restirpg.Renderer(scene, graph, size=None)


@pytest.mark.parametrize(
    "options",
    [
        {"time": math.nan},
        {"time": math.inf},
        {"time": -1},
        {"fps": math.nan},
        {"fps": math.inf},
        {"fps": -1},
        {"fps": 1e-45},
        {"time": 1e300},
    ],
)
def test_times_are_finite_and_not_negative(scene, options):
    assert "must be" in refusal(make_renderer, scene, **options)


def test_a_time_is_set_to_what_is_one(renderer):
    for seconds in (math.nan, math.inf, -1):
        assert "must be finite and at least 0" in refusal(renderer.set_time, seconds)


def test_threads_take_turns(renderer):
    renderer.cut()
    seen, failed = [], []

    def work(action):
        try:
            for _ in range(10):
                seen.append(action())
        except Exception as error:
            failed.append(error)

    actions = [
        lambda: renderer.render(1),
        lambda: renderer.render(1),
        renderer.knobs,
        lambda: renderer.set("paths.nee", True),
        lambda: renderer.set("paths.bounces", 8),
        lambda: renderer.memory()["scene"],
        lambda: check_samples(renderer) if renderer.frame else None,
    ]
    threads = [threading.Thread(target=work, args=(action,)) for action in actions]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    # Between the question for the frame and the output another thread may have set `bounces`, which is a cut.
    assert all("render at least one frame" in str(error) for error in failed)
    assert len(seen) >= 60
    renderer.cut()
    renderer.render(2)
    assert renderer.frame == 2
    check_samples(renderer)


def test_a_forked_process_is_told_that_it_cannot_render(scene, renderer):
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        said = []
        for action in (renderer.render, lambda: renderer.frame, lambda: make_renderer(scene), restirpg.devices):
            try:
                action()
                said.append("it worked")
            except restirpg.Error as error:
                said.append(str(error))
        os.write(writing, json.dumps(said).encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as stream:
        said = json.loads(stream.read())
    assert os.waitpid(child, 0)[1] == 0
    assert len(said) == 4 and all("spawn" in text for text in said)
    renderer.render(1)


def test_a_forked_process_closes_nothing(renderer):
    """Not even while the other process renders."""
    rendering = threading.Thread(target=renderer.render, args=(100,))
    rendering.start()
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(20)
        renderer.__exit__(None, None, None)
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    rendering.join()
    renderer.render(1)


def test_a_camera_farther_away_than_rendering_reaches_is_refused(renderer):
    pose = renderer.camera
    for part in ("position", "target", "up"):
        for far in (1e15, 1e20, -1e30, math.inf, math.nan):
            text = refusal(renderer.move_camera, **{part: (0, far, 1)})
            assert text.startswith(f"the camera's {part} (") and "bring it nearer" in text
    said = refusal(renderer.move_camera, position=(9e14, 0, 9e14), up=(0, 1e10, 0))
    assert said == "the camera's up direction (0, 10000000000, 0) is too long; give it a length of 1"
    assert renderer.camera == pose
    renderer.move_camera(position=(9e14, 0, 9e14), target=(0, 0, 0))
    renderer.render(1)
    check_samples(renderer)
    renderer.move_camera(**pose)


def test_a_field_of_view_that_a_file_may_have_is_one_that_a_camera_is_moved_with(tmp_path):
    file = write_flying_panel(tmp_path / "panel.gltf")
    description = json.loads(file.read_text())
    description["cameras"][0]["perspective"]["yfov"] = 3.1415
    file.write_text(json.dumps(description))
    renderer = make_renderer(restirpg.load_scene(file), size=(16, 16))
    renderer.move_camera(**renderer.camera)
    assert renderer.camera["yfov"] == pytest.approx(3.1415)
    assert "give one between 0 and 3.14159" in refusal(renderer.move_camera, yfov=3.14159)


def test_a_matrix_that_rendering_refuses_moves_no_node(renderer, scene):
    for entry in (1e15, -1e16, math.inf, math.nan):
        matrix = np.eye(4)
        matrix[1, 3] = entry
        text = refusal(renderer.move_node, "Tower", matrix)
        assert text.startswith(f"{scene.file}: node ") and "'Tower' cannot be moved by a matrix with" in text
        assert text.endswith("its entries are numbers below 1000000000000000")
    renderer.render(1)


def test_a_node_is_moved_by_a_name_that_is_its_own(tmp_path):
    file = write_flying_panel(tmp_path / "panel.gltf")
    description = json.loads(file.read_text())
    description["nodes"][0]["name"] = description["nodes"][1]["name"] = "Twin"
    description["nodes"] += [{}, {"name": "Own"}]
    description["scenes"][0]["nodes"] = [0, 1, 2, 3]
    file.write_text(json.dumps(description))
    scene = restirpg.load_scene(file)
    renderer = make_renderer(scene, size=(16, 16))
    twins = [i for i, name in enumerate(scene.nodes) if name == "Twin"]
    text = refusal(renderer.move_node, "Twin", np.eye(4))
    assert "2 nodes are named 'Twin'" in text and text.endswith(f"{twins[0]}, {twins[1]}")
    renderer.move_node("Own", np.eye(4))
    away = np.eye(4)
    away[:3, 3] = (1000, 0, 0)
    panel = next(node for node in twins if node == scene.nodes.index("Twin"))
    renderer.render(1)
    before = renderer.output("image").mean()
    renderer.move_node(panel, away)
    renderer.cut()
    renderer.render(1)
    assert renderer.output("image").mean() != before
    assert "there is no node 99; the scene has 4" in refusal(renderer.move_node, 99, away)
    with pytest.raises(TypeError):
        renderer.move_node(-1, away)
    assert "matrix (4, 4)" in refusal(renderer.move_node, 0, np.eye(3))


def test_a_picture_is_written_by_the_name_that_it_has(renderer, scene_file, tmp_path):
    assert refusal(renderer.save, tmp_path / "a.png").endswith("a.png: the name must end in .exr")
    image = np.zeros((4, 4, 3), np.float32)
    assert "must end in .png" in refusal(restirpg.write_png, tmp_path / "a.exr", image)
    assert "must end in .exr" in refusal(restirpg.write_exr, tmp_path / "a.png", {"": image})
    assert "must be finite" in refusal(restirpg.write_png, tmp_path / "a.png", image, exposure=math.nan)
    link = tmp_path / "link.exr"
    link.symlink_to(scene_file)
    assert "which was read" in refusal(renderer.save, link)
    assert os.listdir(tmp_path) == ["link.exr"]


def test_the_environment_that_was_read_is_not_written_over(scene_file, tmp_path):
    sky = tmp_path / "sky.exr"
    restirpg.write_exr(sky, {"": np.ones((2, 4, 3))})
    before = sky.read_bytes()
    renderer = make_renderer(restirpg.load_scene(scene_file, environment=str(sky)), size=(16, 16))
    renderer.render(1)
    assert refusal(renderer.save, sky).endswith(f"it is the file {sky}, which was read; choose another name")
    assert sky.read_bytes() == before


def write_capped(file, bounces):
    """A scene that asks for so many bounces."""
    description = json.loads(write_flying_panel(file).read_text())
    description["asset"]["extras"] = {"restirpg": {"bounces": bounces}}
    file.write_text(json.dumps(description))
    return file


@pytest.mark.parametrize(
    ("graph", "cap", "words"),
    [("restir_pg", 20, "'bounces' is at most 15, not 20"), ("path_tracer", 100, "from 0 to 64, not 100")],
)
def test_a_scenes_own_bounce_cap_is_named_where_a_graph_refuses_it_and_can_be_replaced(tmp_path, graph, cap, words):
    scene = restirpg.load_scene(write_capped(tmp_path / "capped.gltf", cap))
    graph = restirpg.load_graph(GRAPH.with_name(f"{graph}.py"))
    text = refusal_of_lines(make_renderer, scene, graph, size=(16, 16))
    refused, own = text.split("\n")
    assert words in refused
    assert own == f"    bounce cap {cap} is the scene's; --bounces replaces it (bounces= in Python)"
    renderer = make_renderer(scene, graph, size=(16, 16), bounces=2)
    assert renderer.get("paths.bounces") == 2
    renderer.reload()
    assert renderer.get("paths.bounces") == 2
    text = refusal(make_renderer, scene, graph, size=(16, 16), bounces=cap)
    assert words in text and "the scene's" not in text


def test_a_bounce_cap_is_that_of_every_pass_that_has_one(scene):
    graph = restirpg.Graph("No paths")
    graph.output("image", graph.add("gbuffer", "GBuffer").albedo)
    make_renderer(scene, graph, size=(16, 16), bounces=2).render(1)
    assert make_renderer(scene, size=(16, 16)).get("paths.bounces") == scene.bounce_cap != 1
    assert make_renderer(scene, size=(16, 16), bounces=1).get("paths.bounces") == 1


def test_names_of_any_bytes_are_read_where_python_shows_them(scene_file, tmp_path):
    file = tmp_path / os.fsdecode(b"caf\xe9.glb")
    file.write_bytes(scene_file.read_bytes())
    sky = tmp_path / os.fsdecode(b"\xe9.exr")
    restirpg.write_exr(sky, {"": np.ones((2, 4, 3))})
    scene = restirpg.load_scene(file, environment=os.fsencode(sky))
    assert "caf\\xe9.glb" in repr(scene)
    renderer = make_renderer(scene, size=(16, 16))
    renderer.render(1)
    renderer.save(tmp_path / "a.exr")
    header = restirpg.read_exr_attributes(tmp_path / "a.exr")
    assert header["restirpg.scene"] == "caf\\xe9.glb" and header["restirpg.environment"] == "\\xe9.exr"


def test_a_refused_renderer_leaves_nothing_open(scene):
    refused = [{"device": "none such"}, {"backend": "magic"}, {"size": (0, 0)}]
    for options in refused:
        refusal(make_renderer, scene, **options)
    before = len(os.listdir("/proc/self/fd"))
    for options in refused * 3:
        refusal(make_renderer, scene, **options)
    assert len(os.listdir("/proc/self/fd")) == before


def test_a_knob_whose_kernel_cannot_be_built_stays_as_it_was(scene, tmp_path, monkeypatch):
    renderer = make_renderer(scene, size=(16, 16))
    renderer.set_everywhere("bounces", 2)
    renderer.render(1)
    before = renderer.output("image")
    with monkeypatch.context() as patch:
        patch.setenv("RESTIRPG_SHADERS", str(tmp_path))  # a library that lacks everything
        for change in (lambda: renderer.set("paths.bounces", 3), lambda: renderer.set_everywhere("bounces", 3)):
            assert re.search(
                r": pass 'paths' \(PathTracerGuided\): /.*\.comp:\d+: '#include' : Could not process", refusal(change)
            )
    assert renderer.get("paths.bounces") == 2 and renderer.frame == 1
    assert renderer.output("image").tobytes() == before.tobytes()
    renderer.cut()
    renderer.render(1)
    assert renderer.output("image").tobytes() == before.tobytes()


def test_ports_are_read_after_a_frame_and_are_those_of_the_last_one(scene):
    graph = restirpg.load_graph(GRAPH.with_name("restir_pt.py"))
    renderer = make_renderer(scene, graph, size=(16, 16))
    assert "render at least one frame" in refusal(renderer.read_port, "gbuffer.surface")
    assert "is read by nobody" in refusal(renderer.read_port, "gbuffer.depth")
    unknown = refusal(renderer.read_port, "gbuffer.dept")
    assert "has no port 'gbuffer.dept'; ports: " in unknown and unknown.endswith("; did you mean 'gbuffer.depth'?")
    assert "has no port" in refusal(renderer.read_port, "gbuffer")
    renderer.render(1)
    # A port within the frame, read by the pass after it alone: direct.radiance, which the mean of one frame contains.
    parts = [
        renderer.read_port(port).view(np.float32) for port in ("direct.radiance", "reuse.radiance", "gbuffer.emission")
    ]
    np.testing.assert_allclose(sum(parts), renderer.output("image").ravel(), rtol=1e-6)


NONSENSE = [None, math.nan, -1, 10**30, "", "\x1b\0\ud800", b"\xff", (), [], {}, object(), np.full((2, 0), np.nan)]


def test_nonsense_is_an_exception_and_no_crash(renderer, scene, tmp_path):
    calls = {
        "load_scene": lambda x: restirpg.load_scene(x),
        "camera": lambda x: restirpg.load_scene(scene.file, camera=x),
        "load_graph": lambda x: restirpg.load_graph(x),
        "read_exr": lambda x: restirpg.read_exr(x),
        "attributes": lambda x: restirpg.read_exr_attributes(x),
        "write_exr": lambda x: restirpg.write_exr(tmp_path / "a.exr", x),
        "layer": lambda x: restirpg.write_exr(tmp_path / "a.exr", {"": x}),
        "write_png": lambda x: restirpg.write_png(tmp_path / "a.png", x),
        "measure_errors": lambda x: restirpg.measure_errors(x, x),
        "size": lambda x: restirpg.Renderer(scene, restirpg.load_graph(GRAPH), size=(x, x)),
        "graph": lambda x: restirpg.Renderer(scene, x, size=(16, 16)),
        "scene": lambda x: restirpg.Renderer(x, restirpg.load_graph(GRAPH), size=(16, 16)),
        "render": lambda x: renderer.render(x),
        "output": lambda x: renderer.output(x),
        "read_port": lambda x: renderer.read_port(x),
        "get": lambda x: renderer.get(x),
        "set": lambda x: renderer.set(x, x),
        "value": lambda x: renderer.set("paths.bounces", x),
        "position": lambda x: renderer.move_camera(position=(x, x, x)),
        "yfov": lambda x: renderer.move_camera(yfov=x if x is not None else -1),
        "move_node": lambda x: renderer.move_node(x, np.eye(4)),
        "matrix": lambda x: renderer.move_node("Tower", x),
        "set_time": lambda x: renderer.set_time(x),
        "seed": lambda x: setattr(renderer, "seed", x),
        "save": lambda x: renderer.save(x),
    }
    accepted = {("position", -1), ("write_exr", "{}"), ("set_time", 10**30)}
    knobs, pose, frame = renderer.knobs(), renderer.camera, renderer.frame
    for name, call in calls.items():
        for value in NONSENSE:
            try:
                call(value)
            except Exception as error:
                assert str(error), (name, value)
            else:
                assert (name, value) in accepted or (name, repr(value)) in accepted, (name, value)
    assert renderer.knobs() == knobs and renderer.frame == frame
    renderer.move_camera(**pose)
    renderer.render(1)
    check_samples(renderer)
