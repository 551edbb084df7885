"""What the viewer's page shows of pixels, in a headless Chromium: an inspected one, its guide and path, errors."""

import json

from restirpg.viewer import reservoirs


def test_a_click_inspects_a_pixel(browser):
    browser.point(".pane canvas", ("move", -100, 10), ("down",), ("up",))
    browser.wait("document.querySelector('.values h2')")
    assert "depth" in browser.run("return document.querySelector('.values').textContent")


def test_a_pixel_is_of_the_view_in_which_it_was_asked_for(browser, monkeypatch):
    path = {"points": [[0.2, 0.2], [0.4, 0.4]], "bounces": [1, 2], "light": None}
    monkeypatch.setattr(reservoirs, "path_at_pixel", lambda *_: path)
    before = browser.run("return page.view")
    browser.run("page.send('orbit', { x: 0.1, y: 0 }); page.send('inspect', { x: 9, y: 7 })")
    browser.wait("document.querySelector('.values h2').textContent === 'pixel 9, 7'")
    browser.wait(f"page.state.view_number > {before} && page.controls.answered >= page.controls.asked")
    frames = browser.run("return page.frames")
    browser.wait(f"page.frames > {frames} + 1")
    marked = "document.querySelector('.values').classList.contains('passed')"
    assert browser.run(f"return [page.stage.hasPaths(), {marked}]") == [True, False]
    browser.run("page.send('home')")
    browser.wait(f"{marked} && !page.stage.hasPaths()")


def test_a_guide_is_shown_with_its_graph_beside_its_own_pixel_alone(browser):
    shown = browser.run(
        "const panel = page.panel, told = { x: 9, y: 7, view_number: page.view, geometry: null, panes: [{}, {}],"
        "    reservoirs: [{}, {}], paths: [null, null] };"
        "page.state.panes.forEach(pane => { pane.guided = true; }); page.receive({ pixel: told });"
        "const guide = { pane: 1, x: 9, y: 7, view_number: page.view, side: 0.1, maps: {} };"
        "page.receive({ guide }); const text = panel.guide.textContent, names = page.state.panes.map(pane => pane.name);"
        "const enabled = () => [...panel.pixel.querySelectorAll('button')].map(button => !button.disabled), before = enabled();"
        "page.know(page.view + 1); const after = enabled();"
        "panel.guide.replaceChildren(); page.receive({ guide: { ...guide, view_number: page.view } });"
        "const result = [text, names[1], before, after, panel.guide.textContent, document.querySelector('#messages').textContent];"
        "page.view -= 1; page.state.panes.forEach(pane => { pane.guided = false; }); return result"
    )
    assert shown[0].startswith(f"guide of {shown[1]}cell of 10.0 cm")
    assert shown[2:5] == [[True] * 4, [False] * 4, ""]
    assert "The view has changed since the guide at pixel 9, 7" in shown[5]


def test_a_pixel_without_a_surface_says_so(browser):
    browser.run(
        "const { position, target, up, yfov } = page.state.camera;"
        "page.send('pose', { position, target: position.map((x, i) => 2 * x - target[i]), up, yfov });"
        "page.send('inspect', { x: 8, y: 8 })"
    )
    browser.wait("document.querySelector('.values').textContent.includes('it shows no surface')")
    browser.run("page.send('home')")


def test_a_reference_is_traced_and_errors_are_plotted(browser):
    browser.run(
        "const chosen = document.querySelector('#reference'); chosen.value = 'traced'; chosen.dispatchEvent(new Event('change'))"
    )
    # The other graph may have another bounce cap by now, and has no error then.
    browser.wait("page.panel.errors[0].length > 1 && !page.panel.chart.hidden")
    assert "reference of" in browser.run("return document.querySelector('#status').textContent")
    browser.run("page.send('reference', { source: 'none' })")
    browser.wait("page.state.reference === 'none' && page.panel.chart.hidden")


def test_the_lines_of_errors_begin_anew_with_another_reference(browser):
    lengths = browser.run(
        "const panel = page.panel, panes = page.header.panes.map(pane => ({ ...pane, frames: 7, mape: 0.5 }));"
        "const lengths = ['traced', 'traced', 'file'].map((reference, i) => {"
        "    panes.forEach(pane => { pane.frames += 1; });"
        "    panel.showFrame({ ...page.header, panes, reference });"
        "    return panel.errors[0].length; });"
        "panel.showFrame({ ...page.header, reference: 'none' }); return lengths"
    )
    assert lengths == [1, 2, 1]


def test_the_label_and_the_summary_say_why_there_is_no_error(browser):
    browser.run(
        "page.send('set', { pane: 1, knob: 'paths.bounces', value: 0 });"
        "page.send('reference', { source: 'traced' }); page.send('view', { name: 'error' })"
    )
    browser.wait("page.header.labels[0].endsWith(': error')")
    browser.wait("document.querySelector('.pane .left').textContent.endsWith(': error')")
    why = "no error: its bounce cap is 0, that of the reference is 8"
    browser.wait(f"page.panel.panes[1].summary.textContent.includes({json.dumps(why)})")
    browser.wait(f"document.querySelector('.pane .right').textContent.includes({json.dumps(why)})")
    browser.run("page.send('reference', { source: 'none' })")
    browser.wait("page.header.reference === 'none' && !page.panel.panes[1].summary.textContent.includes('no error')")


def test_a_difference_is_of_the_graphs_that_are_chosen(browser):
    sent = browser.run(
        "const sent = [], send = page.send, look = { ...page.stage.look }; page.send = (...message) => sent.push(message);"
        "const choose = (id, value) => { const chosen = document.querySelector(id);"
        "    chosen.value = value; chosen.dispatchEvent(new Event('change')); };"
        "choose('#a', 1); choose('#view', 'difference'); page.state.view = 'difference'; choose('#b', 0);"
        "page.send = send; page.state.view = 'image'; page.stage.set(look); choose('#view', 'image'); return sent"
    )
    assert sent == [
        ["view", {"name": "difference", "left": 1, "right": 1}],
        ["view", {"name": "difference", "left": 1, "right": 0}],
    ]


def test_numbers_that_are_not_finite_are_shown(browser, monkeypatch):
    session = browser.viewer.session
    monkeypatch.setattr(session.panes[0], "pixel", lambda x, y: {"picture": [float("nan"), -float("inf"), 0.5]})
    monkeypatch.setattr(session, "errors", lambda: [float("nan"), float("inf")])
    browser.run("page.send('inspect', { x: 8, y: 8 })")
    browser.wait("document.querySelector('.values').textContent.includes('NaN -Infinity 0.5000')")
    browser.wait("page.panel.panes[0].summary.textContent.includes('MAPE NaN%')")
    frames = browser.run("return page.frames")
    browser.wait(f"page.frames > {frames} + 2")
    assert browser.run("return page.panel.errors.flat().length") == 0


def test_a_long_line_of_errors_is_thinned(browser):
    lengths, first, last = browser.run(
        "const panel = page.panel; panel.drawErrors = () => {};"
        "for (let frames = 1; frames <= 70000; ++frames) panel.addErrors([0, 1].map(i => ({ frames, mape: 0.5 / (i + frames) })));"
        "delete panel.drawErrors; panel.drawErrors(); const line = panel.errors[0];"
        "return [panel.errors.map(line => line.length), line.slice(0, 20).map(point => point[0]), line.at(-1)]"
    )
    assert all(100 < length < 1000 for length in lengths)
    assert first == list(range(1, 21)) and last == [70000, 0.5 / 70000]


def test_a_path_is_drawn_in_the_pixels_of_the_display(browser):
    drawn = browser.run(
        "const drawn = [], own = CanvasRenderingContext2D.prototype, stroke = own.stroke, text = own.fillText;"
        "own.stroke = function () { drawn.push(this.lineWidth); stroke.call(this); };"
        "own.fillText = function (...what) { drawn.push(this.font); text.apply(this, what); };"
        "window.devicePixelRatio = 2;"
        "const paths = [0, 1].map(() => ({ points: [[0.2, 0.2], [0.4, 0.4]], bounces: [1, 2], light: null }));"
        "page.stage.showPaths({ x: 8, y: 8, paths, view_number: page.view });"
        "window.devicePixelRatio = 1; Object.assign(own, { stroke, fillText: text });"
        "page.stage.paths = undefined; page.stage.draw(); return drawn"
    )
    assert set(drawn) == {4, "24px sans-serif"}


def test_no_script_has_failed(browser):
    assert browser.log() == []
