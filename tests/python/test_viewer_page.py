"""The viewer's page in a headless Chromium: drags, knobs, split, blink, an inspected pixel, and an edited shader."""

import json
import shutil

import pytest
from renderer_scenes import GRAPH, restirpg, scene, scene_file  # noqa: F401
from webdriver import Browser

SIZE = (32, 18)
EDITED = "graph.name = 'Edited'\n"


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
        restirpg.view([graph_file, GRAPH], scene, SIZE, captures=graph_file.parent / "films") as viewer,
        Browser() as browser,
    ):
        browser.open(viewer.url)
        browser.wait("window.page && page.frames > 1 && page.state")
        yield browser


def state(browser, path):
    return browser.run(f"return page.state.{path}")


def test_drag_wheel_and_keys_move_the_camera(browser):
    poses = [state(browser, "camera")]

    def moved():
        browser.wait(
            f"JSON.stringify(page.state.camera) !== {json.dumps(json.dumps(poses[-1], separators=(',', ':')))}"
        )
        poses.append(state(browser, "camera"))

    browser.point(".pane canvas", ("move", -200, 20), ("down",), ("move", -100, 40), ("up",))
    moved()
    browser.point(".pane canvas", ("move", -200, 20), ("wheel", 200))
    moved()
    assert poses[1]["target"] == poses[0]["target"] and poses[2]["position"] != poses[1]["position"]
    browser.run("document.body.dispatchEvent(new KeyboardEvent('keydown', {key: 'h', bubbles: true}))")
    browser.wait(
        f"JSON.stringify(page.state.camera.position) === {json.dumps(json.dumps(poses[0]['position'], separators=(',', ':')))}"
    )
    assert browser.run("return page.latencies.length") > 0


def test_a_knob_changes_its_side_of_the_split(browser):
    browser.run("page.stage.set({ mode: 'split', split: 0.5 })")
    browser.run(
        "const knob = page.panel.panes[1].inputs.get('paths.bounces').input; knob.value = 0; knob.dispatchEvent(new Event('change'))"
    )
    browser.wait("page.state.panes[1].arguments === '--set paths.bounces=0'")
    browser.run("page.send('view', { name: 'difference' })")
    browser.wait("page.state.view === 'difference' && page.stage.images.length === 1")
    browser.run("page.send('view', { name: 'image' })")
    browser.wait("page.state.view === 'image' && page.stage.images.length === 2")
    browser.point(".pane canvas", ("move", 0, 0), ("down",), ("move", 150, 0), ("up",))
    assert browser.run("return page.stage.look.split") > 0.55
    assert browser.run("return document.querySelectorAll('.knob.changed').length") == 1


def test_blink_shows_one_after_the_other(browser):
    browser.run("document.querySelector('[data-mode=blink]').click()")
    browser.wait("page.stage.look.second")
    browser.wait("!page.stage.look.second")
    browser.run("document.querySelector('[data-mode=split]').click()")


def test_a_click_inspects_a_pixel(browser):
    browser.point(".pane canvas", ("move", -100, 10), ("down",), ("up",))
    browser.wait("document.querySelector('.values h2')")
    assert "depth" in browser.run("return document.querySelector('.values').textContent")


def test_a_reference_is_traced_and_errors_are_plotted(browser):
    browser.run(
        "const chosen = document.querySelector('#reference'); chosen.value = 'traced'; chosen.dispatchEvent(new Event('change'))"
    )
    browser.wait("page.panel.errors.every(line => line.length > 1) && !page.panel.chart.hidden")
    assert "reference of" in browser.run("return document.querySelector('#status').textContent")
    browser.run("page.send('reference', { source: 'none' })")
    browser.wait("page.state.reference === 'none' && page.panel.chart.hidden")


def test_a_film_is_recorded(browser, graph_file):
    browser.run("document.querySelector('#length').value = 2; document.querySelector('#film').click()")
    browser.wait("document.querySelector('#messages').textContent.includes('the film is in')")
    assert len(list(graph_file.parent.glob("films/film_*/*/0000[12].png"))) == 4


def test_the_camera_is_copied_as_a_command_line(browser):
    browser.run("page.copied = []; page.copy = text => page.copied.push(text)")
    browser.run(
        "const copy = document.querySelector('#copy'); for (const kind of ['call', 'json', 'command']) "
        "{ copy.value = kind; copy.dispatchEvent(new Event('change')); }"
    )
    call, data, command = browser.run("return page.copied")
    assert (
        call.startswith("renderer.move_camera(position=[")
        and json.loads(data)["up"]
        and "--pose=" in command
        and "own.py" in command
    )


def test_an_edited_graph_is_shown_and_a_broken_one_is_told(browser, graph_file):
    graph_file.write_text(GRAPH.read_text() + EDITED)
    browser.wait("page.state.panes[0].name === 'Edited'")
    graph_file.write_text("from restirpg import Graph\ngraph = Graph('broken')\ngraph.add('x', 'NoSuchPass')\n")
    browser.wait("document.querySelector('#messages').textContent.includes('own.py:3')")
    assert state(browser, "panes[0].name") == "Edited"
    frames = browser.run("return page.frames")
    browser.wait(f"page.frames > {frames} + 1")
    graph_file.write_text(GRAPH.read_text() + EDITED)


def test_no_script_has_failed(browser):
    assert browser.log() == []
