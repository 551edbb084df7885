"""Graphs and shaders that are edited while the viewer shows them."""

import shutil

import numpy as np
import pytest
from renderer_scenes import GRAPH
from viewer_sessions import SIZE, images

from restirpg.harness import UserError
from restirpg.viewer.session import Session
from restirpg.viewer.watch import Watch


def test_a_reload_takes_edits_and_keeps_the_old_graph_when_they_are_wrong(scene, tmp_path):
    file = tmp_path / "own.py"
    file.write_text(GRAPH.read_text().replace("graph = ", "graph = ", 1))
    session = Session(scene, [file], SIZE, validation=True)
    session.apply({"do": "orbit", "x": 0.1, "y": 0.0})
    session.render()
    old = session.panes[0].renderer
    file.write_text("from restirpg import Graph\ngraph = Graph('broken')\ngraph.add('x', 'NoSuchPass')\n")
    with pytest.raises(UserError, match=r"own.py:3: .*NoSuchPass"):
        session.apply({"do": "reload"})
    assert session.panes[0].renderer is old
    file.write_text(GRAPH.read_text() + "\ngraph.name = 'Edited'\n")
    session.apply({"do": "reload"})
    assert session.panes[0].renderer is not old and session.panes[0].name == "Edited"
    session.render()
    assert session.panes[0].frames == 1


def test_a_port_that_an_edit_takes_away_gives_way_to_the_picture(scene, tmp_path):
    file, text = tmp_path / "own.py", GRAPH.read_text()
    file.write_text(text)
    session = Session(scene, [file], SIZE, validation=True)
    session.apply({"do": "show", "pane": 0, "port": "paths.radiance"})
    file.write_text(text + "\ngraph.name = 'Edited'\n")
    session.apply({"do": "reload"})
    assert session.panes[0].name == "Edited" and session.panes[0].port == "paths.radiance"
    file.write_text("from restirpg import Graph\ngraph = Graph('broken')\ngraph.add('x', 'NoSuchPass')\n")
    with pytest.raises(UserError, match=r"own.py:3: .*NoSuchPass"):
        session.apply({"do": "reload"})
    assert session.panes[0].port == "paths.radiance"
    file.write_text(text.replace('"paths"', '"tracer"'))
    session.apply({"do": "reload"})
    session.render()
    assert "tracer.radiance" in session.panes[0].ports and session.panes[0].port is None
    assert len(session.frame().images) == 1


@pytest.fixture
def shaders(tmp_path, monkeypatch):
    """A copy of the GLSL library, which renderers take from here on."""
    folder = tmp_path / "shaders"
    shutil.copytree(GRAPH.parents[1] / "framework" / "shaders", folder)
    monkeypatch.setenv("RESTIRPG_SHADERS", str(folder))
    return folder


def test_the_reference_and_the_probe_are_of_the_edited_shaders_too(scene, shaders):
    def looked_at(session):
        session.render()
        session.trace_reference()
        assert session.frame().header["reference_frames"] == 1
        return images(session)[0], session.truth(), session.inspector.geometry(2, 5)

    session, fresh = (Session(scene, [GRAPH], SIZE, validation=True) for _ in range(2))
    session.apply({"do": "reference", "source": "traced"})
    before = looked_at(session)
    camera_file = shaders / "scene/camera.glsl"
    left_to_right = camera_file.read_text()
    mirrored = left_to_right.replace("2.0 * point.x / size.x - 1.0", "1.0 - 2.0 * point.x / size.x")
    assert mirrored != left_to_right
    camera_file.write_text(mirrored + "\nthis is no GLSL\n")
    with pytest.raises(UserError, match="camera.glsl"):
        session.apply({"do": "reload"})
    np.testing.assert_equal((session.truth(), session.inspector.geometry(2, 5)), before[1:])
    camera_file.write_text(mirrored)
    session.apply({"do": "reload"})
    fresh.apply({"do": "reload"})
    fresh.apply({"do": "reference", "source": "traced"})
    after = looked_at(session)
    np.testing.assert_equal(after, looked_at(fresh))
    assert after[2] != before[2]


def test_a_shader_that_does_not_compile_is_located_and_the_old_one_goes_on(scene, shaders, monkeypatch):
    session = Session(scene, [GRAPH], SIZE, validation=True)
    watch = Watch([GRAPH])
    edited, good = shaders / "math/random.glsl", (shaders / "math/random.glsl").read_text()
    edited.write_text(good + "\nthis is no GLSL\n")
    monkeypatch.setattr("restirpg.viewer.watch._SECONDS", 0.0)
    assert watch.changed() == [str(edited)] and watch.changed() == []
    with pytest.raises(UserError, match=rf"random.glsl:{good.count(chr(10)) + 2}"):
        session.apply({"do": "reload"})
    session.render()
    assert session.panes[0].frames == 1
    edited.write_text(good)
    session.apply({"do": "reload"})
    session.render()
