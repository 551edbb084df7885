"""The viewer's page in a headless Chromium: drags, knobs, split, blink, films, keys, and an edited graph."""

import json

import pytest
from renderer_scenes import GRAPH, restirpg, write_flying_panel
from viewer_sessions import PAGE_SIZE

EDITED = "graph.name = 'Edited'\n"


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


def test_an_emptied_number_changes_no_knob(browser):
    before = state(browser, "panes[0].arguments")
    shown = browser.run(
        "const sent = [], send = page.send; page.send = (...message) => sent.push(message);"
        "const knob = page.panel.panes[0].inputs.get('paths.bounces').input; knob.value = '';"
        "knob.dispatchEvent(new Event('change')); page.send = send; return [sent.length, knob.value]"
    )
    assert shown == [0, "8"] and state(browser, "panes[0].arguments") == before


def test_a_refused_number_gives_way_to_the_one_that_holds(browser):
    """Also in the control that has the focus."""
    browser.run(
        "const knob = window.knob = page.panel.panes[0].inputs.get('paths.bounces').input; knob.focus();"
        "knob.value = 99999; knob.dispatchEvent(new Event('input', { bubbles: true }));"
        "knob.dispatchEvent(new Event('change', { bubbles: true }))"
    )
    browser.wait("knob.value === '8' && document.querySelector('#messages').textContent.includes('bounces')")
    assert browser.run("return document.activeElement === knob")


def test_a_clamped_number_is_shown_as_it_holds(browser):
    browser.run(
        "const fov = document.querySelector('#fov'); fov.focus(); fov.value = 400;"
        "for (const name of ['input', 'change']) fov.dispatchEvent(new Event(name, { bubbles: true }))"
    )
    browser.wait("document.querySelector('#fov').value === '150.0' && document.activeElement.id === 'fov'")
    browser.run("page.send('home')")
    browser.wait("document.querySelector('#fov').value !== '150.0'")


def test_what_is_typed_stays_until_the_focus_goes(browser):
    browser.run(
        "const fov = document.querySelector('#fov'); fov.focus(); fov.value = 77;"
        "fov.dispatchEvent(new Event('input', { bubbles: true })); page.send('exposure', { stops: 1 })"
    )
    browser.wait("page.state.exposure === 1")
    assert browser.run("return document.querySelector('#fov').value") == "77"
    browser.run("document.querySelector('#fov').blur(); page.send('exposure', { stops: 0 })")
    browser.wait("document.querySelector('#fov').value !== '77'")


def test_a_value_that_is_under_way_stays(browser):
    shown = browser.run(
        "const knob = page.panel.panes[0].inputs.get('paths.alpha').input, send = page.socket.send; let text;"
        "page.socket.send = sent => { text = sent; }; knob.value = 0.25;"
        "knob.dispatchEvent(new Event('change', { bubbles: true })); page.showState(); const shown = [knob.value];"
        "delete page.socket.send; page.receive({ error: 'not so', refused: JSON.parse(text).id });"
        "return [...shown, knob.value, send === page.socket.send]"
    )
    assert shown == ["0.25", "0.5", True]


def test_a_reference_that_cannot_be_made_is_not_chosen(browser, monkeypatch):
    def refuse(source):
        raise restirpg.WrongValueError("no room for it")

    monkeypatch.setattr(browser.viewer.session.reference, "use", refuse)
    browser.run(
        "const chosen = document.querySelector('#reference'); chosen.focus(); chosen.value = 'traced';"
        "chosen.dispatchEvent(new Event('change', { bubbles: true }))"
    )
    browser.wait("document.querySelector('#messages').textContent.includes('no room for it')")
    assert browser.run("return document.querySelector('#reference').value") == "none"


def test_an_emptied_field_of_view_film_or_speed_goes_back(browser):
    shown = browser.run(
        "const sent = [], send = page.send; page.send = (...message) => sent.push(message);"
        "const shown = ['fov', 'length', 'speed'].map(id => { const field = document.querySelector(`#${id}`), before = field.value;"
        "    field.value = ''; field.dispatchEvent(new Event('change', { bubbles: true }));"
        "    return field.value === before && before !== ''; });"
        "page.send = send; return [shown, sent.length]"
    )
    assert shown == [[True, True, True], 0]


def test_the_field_of_view_moves_nothing_else(browser):
    """Though the page's state is of before a move."""
    before = state(browser, "camera")
    browser.run(
        "page.send('orbit', { x: 0.2, y: 0.1 }); const fov = document.querySelector('#fov'); fov.value = 50;"
        "fov.dispatchEvent(new Event('change', { bubbles: true }))"
    )
    browser.wait("document.querySelector('#fov').value === '50.0' && page.controls.answered >= page.controls.asked")
    assert state(browser, "camera.position") != before["position"]
    browser.run("page.send('home')")
    browser.wait("document.querySelector('#fov').value !== '50.0'")


def test_copying_the_knobs_takes_one_that_was_turned(browser):
    said = browser.run(
        "page.copied = []; page.copy = text => page.copied.push(text);"
        "const panes = page.state.panes.map(pane => pane.arguments);"
        "page.state.panes[0].arguments = ''; page.panel.copyArguments(0);"
        "page.state.panes[0].arguments = '--set a.b=1'; page.panel.copyArguments(0);"
        "page.state.panes[0].arguments = panes[0]; delete page.copy;"
        "return [page.copied, document.querySelector('#messages').textContent]"
    )
    assert said[0] == ["--set a.b=1"] and "no knob has been turned" in said[1]


def test_blink_shows_one_after_the_other(browser):
    browser.run("document.querySelector('[data-mode=blink]').click()")
    browser.wait("page.stage.look.second")
    browser.wait("!page.stage.look.second")
    browser.run("document.querySelector('[data-mode=split]').click()")


def test_a_film_is_recorded(browser, graph_file):
    browser.run("document.querySelector('#length').value = 2; document.querySelector('#film').click()")
    browser.wait("document.querySelector('#messages').textContent.includes('the film is in')")
    assert len(list(graph_file.parent.glob("films/film_*/*/0000[12].png"))) == 4


def test_a_second_click_stops_the_film_and_starts_no_other(browser, graph_file):
    films = graph_file.parent / "films"
    before = len(list(films.glob("*")))
    browser.run(
        "document.querySelector('#length').value = 100000;"
        "document.querySelector('#film').click(); document.querySelector('#film').click()"
    )
    browser.wait("document.querySelector('#film').textContent.startsWith('stop') && page.state.film.done > 1")
    assert "before the next one" not in browser.run("return document.querySelector('#messages').textContent")
    assert len(list(films.glob("*"))) == before + 1
    browser.run("document.querySelector('#film').click()")
    browser.wait("document.querySelector('#film').textContent === 'record' && !page.state.film")
    assert len(list(films.glob("*"))) == before + 1


def test_the_camera_is_copied_as_a_command_line(browser):
    browser.run("page.send('orbit', { x: 0.1, y: 0 })")
    browser.wait("page.header.panes[0].command.includes('--pose=')")
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
    browser.run("page.send('home')")  # the scene's own camera, which no option has to name
    browser.wait("!page.header.panes[0].command.includes('--pose=')")


def test_the_command_line_is_of_the_frames_that_are_shown(browser):
    frames = browser.run("page.send('restart'); return page.frames")
    browser.wait(f"page.frames > {frames} + 5")
    command, summary = browser.run(
        "let command; page.copy = text => { command = text; };"
        "const copy = document.querySelector('#copy'); copy.value = 'command'; copy.dispatchEvent(new Event('change'));"
        "return [command, page.panel.panes[0].summary.textContent]"
    )
    assert f"--frames {summary.split()[0]} " in command and int(summary.split()[0]) > 1
    browser.run("delete page.copy")


def test_with_kept_history_the_page_says_why_there_is_no_command_line(browser):
    browser.run("page.send('keep', { on: true })")
    browser.wait("page.state.keep && page.header.panes[0].command === null")
    browser.run(
        "page.copied = []; page.copy = text => page.copied.push(text);"
        "const copy = document.querySelector('#copy'); copy.value = 'command'; copy.dispatchEvent(new Event('change'));"
    )
    assert browser.run("return page.copied") == []
    assert "With kept history" in browser.run("return document.querySelector('#messages').textContent")
    browser.run("delete page.copy; page.send('keep', { on: false })")
    browser.wait("page.header.panes[0].command")


def test_a_latency_is_that_of_the_newest_message_that_is_shown(browser):
    latencies = browser.run(
        "const page = window.page, now = performance.now(), id = page.id;"
        "page.send('inspect', { x: 1, y: 1 }); page.send('guide', {}); page.send('visible', { on: true });"
        "if (page.sent.size) return page.sent.size;"
        "page.sent.set(id + 10, now - 60000).set(id + 11, now - 50).set(id + 12, now);"
        "page.measure({ ...page.header, seen: { [page.you]: id + 11 } }); const kept = [...page.sent.keys()];"
        "page.sent.clear(); return [page.latencies.pop(), ...kept.map(key => key - id)]"
    )
    assert 50 <= latencies[0] < 10000 and latencies[1:] == [12]


def test_the_space_bar_presses_what_has_the_focus(browser):
    def is_taken(selector):
        return browser.run(
            f"return !document.querySelector({json.dumps(selector)}).dispatchEvent("
            "new KeyboardEvent('keydown', { key: ' ', bubbles: true, cancelable: true }))"
        )

    for selector in ("#keep", "#restart", "summary", "#exposure", "a"):
        assert not is_taken(selector), selector
    playing = state(browser, "playing")
    assert is_taken("body")
    browser.wait(f"page.state.playing === {json.dumps(not playing)}")
    browser.run(f"page.send('play', {{ on: {json.dumps(playing)} }})")


def test_messages_are_announced_and_closed_by_keyboard(browser):
    assert browser.run("return document.querySelector('#messages').getAttribute('role')") == "status"
    browser.run("page.report('a line to close'); document.querySelector('#messages div:last-child button').click()")
    assert "a line to close" not in browser.run("return document.querySelector('#messages').textContent")
    unnamed = browser.run(
        "return [...document.querySelectorAll('select, input')].filter(control => "
        "!control.ariaLabel && !control.title && !control.labels.length).map(control => control.outerHTML)"
    )
    assert unnamed == []


def test_a_canvas_is_used_by_keyboard(browser):
    def press(key):
        browser.run(
            "document.querySelector('.pane canvas').dispatchEvent("
            f"new KeyboardEvent('keydown', {{ key: {json.dumps(key)}, bubbles: true, cancelable: true }}))"
        )

    browser.run("document.querySelector('.pane canvas').focus(); page.navigation.inspected = undefined")
    assert browser.run("return [document.activeElement.tagName, document.activeElement.ariaLabel]")[0] == "CANVAS"
    before, target = state(browser, "camera.position"), state(browser, "camera.target")
    press("ArrowRight")
    browser.wait(
        f"JSON.stringify(page.state.camera.position) !== {json.dumps(json.dumps(before, separators=(',', ':')))}"
    )
    assert state(browser, "camera.target") == target
    press("Enter")
    browser.wait("document.querySelector('.values h2').textContent === 'pixel 16, 9'")
    browser.run("page.send('home')")


def test_what_is_seen_is_also_said(browser):
    pressed = browser.run(
        "document.querySelector('[data-mode=tiles]').click();"
        "const told = Object.fromEntries([...document.querySelectorAll('[data-mode]')].map("
        "    button => [button.dataset.mode, button.getAttribute('aria-pressed')]));"
        "document.querySelector('[data-mode=split]').click(); return told"
    )
    assert pressed == {"split": "false", "blink": "false", "tiles": "true"}
    label = browser.run(
        "const panel = page.panel, kept = panel.errors; panel.errors = [[[1, 0.5], [4, 0.25]], []];"
        "panel.drawErrors(); panel.errors = kept; return [panel.chart.getAttribute('aria-label'), page.state.panes[0].name]"
    )
    assert label[0] == f"MAPE 25.00 to 50.00%, 1 to 4 frames; {label[1]}: 25.00%"


@pytest.mark.parametrize("width", [1400, 400])
def test_the_picture_is_wide_and_nothing_is_wider_than_the_window(browser, width):
    assert (
        browser.run("return document.querySelector('meta[name=viewport]').content")
        == "width=device-width, initial-scale=1"
    )
    browser.resize(width, 900)
    try:
        assert browser.run("return document.documentElement.scrollWidth <= window.innerWidth")
        assert browser.run("return document.querySelector('.pane canvas').clientWidth") > 0.6 * width
    finally:
        browser.resize(1280, 1600)


def test_an_edited_graph_is_shown_and_a_broken_one_is_told(browser, graph_file):
    graph_file.write_text(GRAPH.read_text() + EDITED)
    browser.wait("page.state.panes[0].name === 'Edited'")
    graph_file.write_text("from restirpg import Graph\ngraph = Graph('broken')\ngraph.add('x', 'NoSuchPass')\n")
    browser.wait("document.querySelector('#messages').textContent.includes('own.py:3')")
    assert state(browser, "panes[0].name") == "Edited"
    frames = browser.run("return page.frames")
    browser.wait(f"page.frames > {frames} + 1")
    graph_file.write_text(GRAPH.read_text() + EDITED)


def test_the_slider_follows_the_animation(browser, tmp_path):
    flying = restirpg.load_scene(write_flying_panel(tmp_path / "panel.gltf", times=(0, 1000)))
    with restirpg.view(GRAPH, flying, PAGE_SIZE) as viewer:
        browser.open(viewer.url)
        browser.wait("window.page && page.frames > 1 && page.state")
        browser.run("document.querySelector('#time').focus(); page.send('speed', { factor: 10 })")
        browser.wait("Number(document.querySelector('#time').value) > 1")
        shown, value, command = browser.run(
            "const slider = document.querySelector('#time');"
            "return [slider.nextElementSibling.textContent, slider.value, page.command()]"
        )
        assert float(shown.removesuffix(" s")) == pytest.approx(float(value), abs=0.02)
        assert float(command.partition("--time ")[2].split()[0]) == pytest.approx(float(value), abs=0.02)


def test_no_script_has_failed(browser):
    assert browser.log() == []
