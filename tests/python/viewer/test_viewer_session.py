"""The viewer's session without a network: what its commands do to the pictures, and what they refuse."""

import numpy as np
import pytest
from renderer_scenes import GRAPH, make_renderer, restirpg
from viewer_sessions import SIZE, depth_graph, images

from restirpg.colour import relative_error
from restirpg.harness import UserError
from restirpg.viewer import capture, pictures
from restirpg.viewer import reference as reference_module
from restirpg.viewer.pane import Mean
from restirpg.viewer.session import Session


def test_graphs_in_step_have_the_same_camera_and_random_numbers(session):
    session.apply({"do": "orbit", "x": 0.2, "y": 0.1})
    session.render()
    first, second = images(session)
    assert first.tobytes() == second.tobytes()
    session.apply({"do": "seed", "value": 5})
    session.render()
    assert images(session)[0].tobytes() == images(session)[1].tobytes() != first.tobytes()


def test_a_move_begins_the_mean_anew_and_rest_goes_on_with_it(session, scene):
    session.render()
    assert [pane.frames for pane in session.panes] == [2, 2]
    session.apply({"do": "pan", "x": 0.1, "y": 0.0})
    session.render()
    assert [pane.frames for pane in session.panes] == [1, 1]
    session.render()
    alone = make_renderer(scene, size=SIZE)
    alone.move_camera(**session.camera)
    alone.render(2)
    np.testing.assert_array_equal(images(session)[0], alone.output("image"))


def test_kept_history_averages_the_frames_since_the_last_move(session):
    session.apply({"do": "keep", "on": True})
    session.render()
    session.apply({"do": "pan", "x": 0.1, "y": 0.0})
    frames = []
    for _ in range(3):
        session.render()
        pane = session.panes[0]
        frames.append(sum(pane.read(port) for port in ("paths.radiance", "gbuffer.emission")))
    assert session.panes[0].renderer.frame == 4 and session.panes[0].frames == 3
    np.testing.assert_allclose(images(session)[0], np.mean(frames, 0), rtol=1e-5, atol=1e-6)


def test_a_frame_that_is_no_number_leaves_the_other_frames_in_the_mean():
    mean, hole = Mean(), np.full((1, 2, 3), 4, np.float32)
    hole[0, 0, 1] = np.nan
    for frame in (np.full_like(hole, 1), hole, np.full_like(hole, 2)):
        mean.add(frame)
    np.testing.assert_allclose(mean.image()[0, :, 0], [3 / 2, 7 / 3])
    assert mean.frames == 3


def test_a_knob_changes_its_own_graph_alone_and_can_be_reset(session):
    before = images(session)
    session.apply({"do": "set", "pane": 1, "knob": "paths.bounces", "value": 0})
    session.render()
    session.apply({"do": "restart"})
    session.render()
    after = images(session)
    assert after[0].tobytes() == before[0].tobytes() and after[1].mean() < 0.99 * after[0].mean()
    state = session.state()["panes"][1]
    knob = next(
        knob
        for entry in state["passes"]
        if entry["name"] == "paths"
        for knob in entry["knobs"]
        if knob["name"] == "bounces"
    )
    assert (knob["value"], knob["type"], knob["minimum"]) == (0, "uint", 0) and knob["meaning"] and knob["initial"] != 0
    assert state["arguments"] == "--set paths.bounces=0"
    session.apply({"do": "reset", "pane": 1})
    session.apply({"do": "restart"})
    session.render()
    assert images(session)[1].tobytes() == before[1].tobytes() and session.state()["panes"][1]["arguments"] == ""


def test_pause_holds_and_a_step_is_one_frame(session):
    session.apply({"do": "play", "on": False})
    assert not session.wants_frame()
    session.apply({"do": "step"})
    assert session.wants_frame()
    session.render()
    assert not session.wants_frame() and session.panes[0].frames == 2
    session.apply({"do": "dolly", "amount": 0.1})
    assert session.wants_frame()  # a paused picture follows the camera


@pytest.mark.parametrize(
    "change",
    [
        {"do": "set", "pane": 0, "knob": "paths.bounces", "value": 1},
        {"do": "reset", "pane": 1},
        {"do": "restart"},
        {"do": "keep", "on": True},
        {"do": "seed", "value": 7},
        {"do": "show", "pane": 0, "port": "gbuffer.normal"},
        {"do": "reload"},
    ],
)
def test_a_pause_right_after_a_change_shows_the_change(session, change):
    """Both commands may come between two frames."""
    session.apply(change)
    session.apply({"do": "play", "on": False})
    assert session.wants_frame()
    session.render()
    assert not session.wants_frame()


def test_a_frame_that_fails_is_tried_again_after_a_change_alone(session, monkeypatch):
    def broken(kept):
        raise ZeroDivisionError("a fault in a test")

    monkeypatch.setattr(session.panes[1], "render", broken)
    session.apply({"do": "restart"})
    with pytest.raises(ZeroDivisionError):
        session.render()
    assert not session.wants_frame()
    monkeypatch.undo()
    session.apply({"do": "exposure", "stops": 1})
    assert session.wants_frame()


def test_errors_are_those_against_the_reference_while_the_camera_is_at_home(session, reference):
    expected = restirpg.measure_errors(images(session)[0], reference)["mape"]
    assert session.errors() == [pytest.approx(expected)] * 2
    relative = relative_error(images(session)[0], reference, np.float32)
    assert relative.mean() == pytest.approx(expected, rel=1e-4)
    session.apply({"do": "orbit", "x": 0.1, "y": 0.0})
    session.render()
    assert session.errors() == [None, None]


def test_the_difference_of_equal_pictures_is_black(session):
    session.apply({"do": "view", "name": "difference"})
    ((label, black),) = session._shown()
    assert not black.any() and label == "difference of 2 Path tracer from 1 Path tracer"
    session.apply({"do": "set", "pane": 1, "knob": "paths.bounces", "value": 0})
    session.render()
    assert session._shown()[0][1].any()


def test_a_difference_is_of_the_graphs_that_are_chosen(scene):
    session = Session(scene, [GRAPH, GRAPH, GRAPH.with_name("restir_pt.py")], SIZE, validation=True)
    session.apply({"do": "view", "name": "difference", "left": 2, "right": 1})
    session.render()
    pictures_now = images(session)
    header = session.frame().header
    assert header["labels"] == ["difference of 2 Path tracer from 3 ReSTIR PT"] and len(header["sizes"]) == 1
    expected = pictures.heat(relative_error(pictures_now[1], pictures_now[2], np.float32), 1.0)
    np.testing.assert_array_equal(session._shown()[0][1], expected)
    with pytest.raises(UserError, match="no graph 3"):
        session.apply({"do": "view", "name": "difference", "left": 0, "right": 3})


def test_the_label_says_what_the_error_view_shows(session):
    """The number and the map are refused together."""
    session.apply({"do": "show", "pane": 1, "port": "gbuffer.normal"})
    session.apply({"do": "view", "name": "error"})
    header = session.frame().header
    assert header["labels"] == ["Path tracer: error"] * 2 and header["reference"] == "file"
    assert [pane["no_error"] for pane in header["panes"]] == [None, None]
    session.apply({"do": "orbit", "x": 0.1, "y": 0.0})
    header, why = session.frame().header, "the reference shows the scene's own camera at 0 s"
    assert header["labels"] == [f"Path tracer, no error: {why}", f"Path tracer: gbuffer.normal, no error: {why}"]
    assert [(pane["mape"], pane["no_error"]) for pane in header["panes"]] == [(None, why)] * 2
    session.apply({"do": "view", "name": "image"})
    assert session.frame().header["labels"] == ["Path tracer", "Path tracer: gbuffer.normal"]


def test_a_traced_reference_that_has_all_its_frames_begins_anew_elsewhere(scene, monkeypatch):
    monkeypatch.setattr(reference_module, "MOST_FRAMES", 2)
    session = Session(scene, [GRAPH], SIZE, validation=True)
    session.apply({"do": "reference", "source": "traced"})
    view, other = ((pose, 0.0, {}) for pose in (session.camera, {**session.camera, "yfov": 0.5}))
    assert [session.reference.trace(*view) for _ in range(3)] == [True, True, False]
    assert session.reference.trace(*other) and session.reference.frames == 1


def test_a_graph_of_another_bounce_cap_than_the_references_has_no_error_map(session):
    session.apply({"do": "reference", "source": "traced"})
    session.apply({"do": "set", "pane": 1, "knob": "paths.bounces", "value": 1})
    session.render()
    session.trace_reference()
    session.apply({"do": "view", "name": "error"})
    assert (
        session.frame().header["labels"][1] == "Path tracer, no error: its bounce cap is 1, that of the reference is 8"
    )
    np.testing.assert_array_equal(session._shown()[1][1], session.pixels(session.panes[1]))


@pytest.mark.parametrize(
    "known, whys",
    [
        ({"bounces": 8, "jitter": True}, [None, None]),
        ({"bounces": 3}, ["its bounce cap is 8, that of the reference is 3", None]),
        ({"jitter": False}, ["its pixel filter (jitter) is true, that of the reference is false"] * 2),
        ({}, [None, None]),
    ],
)
def test_a_file_of_another_bounce_cap_or_pixel_filter_measures_nothing(scene, reference, known, whys):
    session = Session(scene, [GRAPH, GRAPH], SIZE, reference, reference_mean_of=known, validation=True)
    session.apply({"do": "set", "pane": 1, "knob": "paths.bounces", "value": known.get("bounces", 8)})
    panes = session.frame().header["panes"]
    assert [pane["no_error"] for pane in panes] == whys
    assert [pane["mape"] is None for pane in panes] == [why is not None for why in whys]


def test_any_image_port_is_shown_also_one_that_nobody_reads(session):
    session.apply({"do": "show", "pane": 0, "port": "gbuffer.normal"})
    session.render()
    normal = session.panes[0].read("gbuffer.normal")
    np.testing.assert_allclose(np.linalg.norm(normal, axis=-1).max(), 1, rtol=1e-3)
    assert session.frame().images[0] != session.frame().images[1]
    with pytest.raises(restirpg.Error, match="no image port 'gbuffer.surface'"):
        session.apply({"do": "show", "pane": 0, "port": "gbuffer.surface"})


def test_a_pixel_tells_what_it_sees(session):
    session.apply({"do": "restart"})  # which leaves no picture: one is rendered
    pixel = session.inspector.pixel(8, 8)
    assert pixel["geometry"]["depth"] > 1
    np.testing.assert_allclose(pixel["panes"][0]["picture"], images(session)[0][8, 8])
    session.apply({"do": "focus", "x": 8, "y": 8})
    distance = np.linalg.norm(np.subtract(session.camera["target"], session.camera["position"]))
    assert distance == pytest.approx(pixel["geometry"]["depth"], rel=1e-5)


@pytest.mark.parametrize("ask", [lambda session: session.inspector.pixel(8, 8), lambda session: session.frame(),
                                 lambda session: capture.make(session, "picture.png", "0")])  # fmt: skip
def test_what_is_asked_for_right_after_a_move_is_of_the_new_view(session, scene, ask):
    """Both commands may come between two frames."""
    session.apply({"do": "orbit", "x": 0.2, "y": 0.1})
    ask(session)
    alone = make_renderer(scene, size=SIZE)
    alone.move_camera(**session.camera)
    alone.render(1)
    np.testing.assert_array_equal(images(session)[0], alone.output("image"))


def test_a_pixel_is_told_whatever_the_renderers_are_made_with(scene):
    options = {"outputs": ["frame"], "bounces": 1, "seed": 3, "energy_compensation": True}
    session = Session(scene, [GRAPH], SIZE, validation=True, **options)
    assert session.inspector.pixel(8, 8)["geometry"]["depth"] > 1


def test_a_pixel_that_misses_has_no_geometry(flying):
    """A G-buffer has material -1 and normal 0 0 0 there."""
    session = Session(flying, [GRAPH], SIZE, validation=True)
    assert session.inspector.pixel(8, 8)["geometry"]["material"] == 0
    session.apply({"do": "time", "seconds": 1})
    session.render()
    assert session.inspector.pixel(8, 8)["geometry"] is None


@pytest.mark.parametrize(
    "message, words",
    [
        ({"do": "vanish"}, "no command 'vanish'"),
        ({"do": ["show"]}, r"no command \['show'\]"),
        ({"do": "show", "pane": 0, "port": ["image"]}, "no image port"),
        ({"do": "show", "pane": 0, "port": {}}, "no image port"),
        ({"do": "orbit", "x": 1}, "missing a required argument: 'y'"),
        ({"do": "orbit", "x": float("nan"), "y": 0}, "no number"),
        ({"do": "pan", "x": "1", "y": 0}, "no number"),
        ({"do": "set", "pane": 2, "knob": "a.b", "value": 1}, "no graph 2"),
        ({"do": "view", "name": "../x"}, "no view"),
        ({"do": "set", "pane": 0, "knob": "paths.bounces", "value": "many"}, "bounces"),
        ({"do": "pose", "position": [0, 0, 0], "target": [0, 1, 0], "up": [0, 1, 0], "yfov": 1}, "not span a view"),
        ({"do": "pose", "position": [1e30, 0, 0], "target": [0, 1, 0], "up": [0, 1, 0], "yfov": 1}, "nearer to 0"),
        (
            {"do": "pose", "position": [0, 0, 0], "target": [0, 0, 1], "up": [0, 1, 0], "yfov": 3.2},
            "a pinhole camera cannot",
        ),
        ({"do": "pose", "position": [0, 0, 0], "target": [0, 0, 1], "up": [0, 1, 0], "yfov": 10**400}, "no number"),
        ({"do": "pose", "position": "123", "target": [0, 0, 1], "up": [0, 1, 0], "yfov": 1}, "no number"),
        ({"do": "pose", "position": [0, 0], "target": [0, 0, 1], "up": [0, 1, 0], "yfov": 1}, "not three numbers"),
        ({"do": "fov", "yfov": None}, "no number"),
        ({"do": "camera", "number": 1}, "the scene has 1"),
        ({"do": "reference", "source": "../x"}, "no reference"),
        ({"do": "film", "frames": 3, "kind": "png"}, "--captures"),
        ({"do": "__init__"}, "no command"),
        ({}, "no command None"),
    ],
)
def test_what_cannot_be_done_is_refused_and_changes_nothing(session, message, words):
    before, revision = session.camera, session.revision
    with pytest.raises((UserError, restirpg.Error), match=words):
        session.apply(message)
    assert session.camera == before and session.revision == revision
    session.render()


def test_a_reference_is_traced_while_the_view_rests(session):
    session.apply({"do": "reference", "source": "traced"})
    session.apply({"do": "orbit", "x": 0.1, "y": 0.0})
    assert session.errors() == [None, None] and not session.trace_reference()  # the move is not rendered yet
    session.render()
    for _ in range(3):
        assert session.trace_reference()
    truth = session.truth()
    np.testing.assert_allclose(
        session.errors(), [restirpg.measure_errors(picture, truth)["mape"] for picture in images(session)]
    )
    assert session.frame().header["reference_frames"] == 3 and truth.tobytes() != images(session)[0].tobytes()
    session.apply({"do": "set", "pane": 0, "knob": "paths.bounces", "value": 1})  # the reference's bounce cap follows
    assert session.errors() == [None, None]
    session.render()
    session.trace_reference()
    assert session.frame().header["reference_frames"] == 1 and session.truth().mean() < truth.mean()
    assert session.errors()[0] is not None and session.errors()[1] is None  # whose cap is another
    session.apply({"do": "view", "name": "error"})
    assert session._shown()[0][1].any()
    session.apply({"do": "reference", "source": "none"})
    assert session.view == "image" and session.errors() == [None, None] and not session.trace_reference()


def test_a_port_that_nobody_reads_is_shown_at_the_time_of_the_scene(flying):
    session = Session(flying, [GRAPH], SIZE, validation=True)
    session.apply({"do": "time", "seconds": 1})
    session.render()
    assert not images(session)[0].any()
    old = session.panes[0].renderer
    session.apply({"do": "show", "pane": 0, "port": "gbuffer.normal"})
    session.render()
    assert session.panes[0].renderer is not old
    assert not session.panes[0].read("gbuffer.normal").any() and not images(session)[0].any()


def test_the_traced_reference_has_the_pixel_filter_of_the_graphs(scene):
    """At the centres of pixels a picture's mean is another than over their area."""
    session = Session(scene, [GRAPH.with_name("restir_pt.py"), GRAPH], SIZE, validation=True)
    session.apply({"do": "reference", "source": "traced"})
    session.render()
    session.trace_reference()
    centres = session.truth()
    assert [error is None for error in session.errors()] == [False, True]
    session.apply({"do": "set", "pane": 0, "knob": "gbuffer.jitter", "value": True})
    session.render()
    session.trace_reference()
    assert None not in session.errors() and session.truth().tobytes() != centres.tobytes()


def test_a_picture_of_one_channel_has_no_error_and_is_shown(scene):
    session = Session(scene, [depth_graph(), GRAPH, depth_graph()], SIZE, validation=True)
    session.apply({"do": "reference", "source": "traced"})
    session.render()
    assert session.trace_reference()
    session.apply({"do": "view", "name": "error"})
    assert [error is None for error in session.errors()] == [True, False, True]
    assert len(session.frame().images) == 3
    np.testing.assert_array_equal(session._shown()[0][1], session.pixels(session.panes[0]))


def test_depths_have_a_difference(scene):
    session = Session(scene, [depth_graph(), depth_graph()], SIZE, validation=True)
    session.apply({"do": "view", "name": "difference"})
    session.render()
    assert len(session.frame().images) == 1 and not session._shown()[0][1].any()
