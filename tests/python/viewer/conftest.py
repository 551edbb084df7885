"""Sessions and pages of the viewer that tests use."""

import json
import shutil

import pytest
from renderer_scenes import GRAPH, make_renderer, restirpg, write_flying_panel
from viewer_sessions import PAGE_SIZE, SIZE
from webdriver import Browser

from restirpg.viewer.session import Session


@pytest.fixture(scope="module")
def reference(scene):
    """Some frames of the path tracer, as a reference."""
    renderer = make_renderer(scene, seed=77, size=SIZE)
    renderer.render(8)
    return renderer.output("image")


@pytest.fixture(scope="module")
def shared(scene, reference):
    """A session of two graphs that all tests use."""
    return Session(scene, [GRAPH, GRAPH], SIZE, reference, validation=True)


@pytest.fixture(scope="module")
def flying(tmp_path_factory):
    """A scene that its panel fills at 0 s and has left at 1 s."""
    return restirpg.load_scene(write_flying_panel(tmp_path_factory.mktemp("flying") / "panel.gltf"))


@pytest.fixture(scope="module")
def passing(tmp_path_factory):
    """A scene whose camera sees its panel at 0 s and has left it at 1 s."""
    file = write_flying_panel(tmp_path_factory.mktemp("passing") / "panel.gltf")
    description = json.loads(file.read_text())
    description["nodes"][0]["translation"] = [0, 0, -5]
    description["animations"][0]["channels"][0]["target"]["node"] = 1
    file.write_text(json.dumps(description))
    return restirpg.load_scene(file)


@pytest.fixture
def session(shared):
    """The session, as it was at first."""
    for pane in range(2):
        shared.apply({"do": "reset", "pane": pane})
        shared.apply({"do": "show", "pane": pane, "port": None})
    for message in (
        {"do": "reference", "source": "file"},
        {"do": "home"},
        {"do": "keep", "on": False},
        {"do": "play", "on": True},
        {"do": "view", "name": "image"},
        {"do": "exposure", "stops": 0},
        {"do": "seed", "value": 0},
    ):
        shared.apply(message)
    shared.render()
    return shared


@pytest.fixture(scope="module")
def graph_file(tmp_path_factory):
    """A graph file of one's own to edit."""
    file = tmp_path_factory.mktemp("own") / "own.py"
    file.write_text(GRAPH.read_text())
    return file


@pytest.fixture(scope="module")
def browser(scene, graph_file):
    """A browser that shows two graphs."""
    if not shutil.which("chromedriver"):
        pytest.skip("chromedriver is not installed: no browser has opened the viewer")
    with (
        restirpg.view([graph_file, GRAPH], scene, PAGE_SIZE, captures=graph_file.parent / "films") as viewer,
        Browser() as browser,
    ):
        browser.viewer = viewer
        browser.open(viewer.url)
        browser.wait("window.page && page.frames > 1 && page.state")
        yield browser
