"""The report in a headless Chromium: it opens without errors or network, and its viewer does what its
controls say."""

import base64
import re
import shutil
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from harness_runs import SCRIPT, compare
from webdriver import Browser

import restirpg
from restirpg.harness import plots, render
from restirpg.harness.report import commit, side_by_side

CENTRE = (
    "const c = document.querySelector('.pane canvas');"
    "const p = c.getContext('2d').getImageData({x} * c.width, c.height / 2, 1, 1);"
    "return Array.from(p.data)"
)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """A report of two methods, one of them with a label that must be escaped."""
    folder = tmp_path_factory.mktemp("report")
    methods = ("plain.json", "plain.json@gain=4,noise=0.1,label=four</script> times")
    run = compare(folder, *methods, program=SCRIPT, size="64x32", frames=4)
    assert run.returncode == 0, run.stderr
    return folder / "out/report.html"


@pytest.fixture(scope="module")
def shared_browser():
    """One browser for all tests of this file."""
    if not shutil.which("chromedriver"):
        pytest.skip("chromedriver is not installed: no browser has opened the report")
    with Browser() as opened:
        yield opened


@pytest.fixture
def browser(shared_browser, report):
    """The browser with the report freshly loaded."""
    shared_browser.open(report)
    yield shared_browser
    assert shared_browser.log() == []


def state(browser):
    """The viewer's state."""
    return browser.run("return viewers[0].state")


def pixel(browser, x):
    """RGBA of the pane at a fraction of its width, half way down."""
    return browser.run(CENTRE.format(x=x))


def test_no_two_of_twenty_curves_look_alike():
    methods = [
        SimpleNamespace(label=str(number), frames=np.array([1, 2]), curves={"bias": np.ones((2, 2))})
        for number in range(20)
    ]
    svg = plots.bias_curves(SimpleNamespace(methods=methods, noise={"relative_se": 0.01}, at=()))
    looks = re.findall(
        r"style=\"fill: none; ((?:stroke-dasharray: [^;]*;)?)[^\"]*?stroke: (#\w+); stroke-width: 1.4", svg
    )
    assert len(set(looks)) == 20, looks


def test_the_report_names_no_address_to_load_from(report):
    text = report.read_text()
    linked = re.findall(r'(?:src|href)="(?!data:)([^"]*)', text)
    assert linked == [f"images/scene.{name}.exr" for name in ("reference", "plain", "four__script__times")]
    assert all((report.parent / name).is_file() for name in linked)
    assert not re.findall(r"\bfetch\(|XMLHttpRequest|@import|url\((?!#)", re.sub(r"base64,[^\"]*", "", text))


def test_it_opens_with_its_verdict_and_the_first_and_the_last_method_side_by_side(browser):
    top = browser.run(
        "return ['.verdict', '.viewer', '.crops', 'table', '.charts'].map("
        "s => document.querySelector(s).getBoundingClientRect().top)"
    )
    assert top == sorted(top)
    assert re.match(
        r"In single frames, .* has [\d.]+% more error than plain; ",
        browser.run("return document.querySelector('.verdict').textContent"),
    )
    shown = browser.run(
        "const s = viewers[0].state; return [viewers[0].pictures[s.a].label, viewers[0].pictures[s.b].label, s.view]"
    )
    assert shown == ["plain", "four</script> times", "frame"]
    assert browser.run("return document.querySelectorAll('details[open]').length") == 0


@pytest.mark.parametrize("width", [1400, 420])
def test_nothing_is_wider_than_the_window(browser, width):
    browser.resize(width, 900)
    assert browser.run("return document.documentElement.scrollWidth <= window.innerWidth")
    browser.resize(1280, 1600)


def test_ticks_of_logarithmic_axes_are_plain_numbers(report):
    svgs = [base64.b64decode(data).decode() for data in re.findall(r"svg\+xml;base64,([^\"]*)", report.read_text())]
    ticks = [text for svg in svgs for text in re.findall(r">([^<>]*10\^|[^<>]*mathdefault[^<>]*)<", svg)]
    assert len(svgs) == 8 and not ticks


def test_the_pictures_on_both_sides_of_the_split_are_the_chosen_ones(browser):
    assert browser.run("return viewers.length") == 1
    browser.run("viewers[0].set({a: 0, b: 2, exposure: 0, view: 'image'})")
    assert max(pixel(browser, 0.25)[:3]) < 200 < pixel(browser, 0.75)[0]
    browser.run("viewers[0].set({a: 2, b: 0})")
    assert pixel(browser, 0.25)[0] > 200 > max(pixel(browser, 0.75)[:3])


def test_a_value_of_one_is_white_at_exposure_0_and_half_as_much_at_minus_1(browser):
    # sRGB of 0.5 is 188.
    shown = browser.run(
        "const v = viewers[0], out = new Uint8ClampedArray(8), p = new Float32Array([1, 1, 1, .5, .5, .5]);"
        "v.paintImage(p, 4096, out); const whole = Array.from(out); v.paintImage(p, 2048, out);"
        "return [whole, Array.from(out)]"
    )
    assert shown == [[255, 255, 255, 255, 188, 188, 188, 255], [188, 188, 188, 255, 137, 137, 137, 255]]


def test_half_floats_are_decoded_exactly(browser):
    # 1.0, -2.5, 65504, 2^-24 (the smallest), 1/3 rounded to half.
    values = browser.run("return Array.from(decode('ADwAwf97AQBVNQ=='))")
    assert values == [1.0, -2.5, 65504.0, 2**-24, 0.333251953125]


def test_dragging_the_line_moves_the_split_and_dragging_elsewhere_pans(browser):
    width = browser.run("return document.querySelector('.pane canvas').getBoundingClientRect().width")
    browser.point(".pane canvas", ("move", 0, 0), ("down",), ("move", round(width / 4), 0), ("up",))
    assert state(browser)["split"] == pytest.approx(0.75, abs=0.01)
    browser.run("viewers[0].set({zoom: 4, x: 0.25, y: 0.25})")
    browser.point(".pane canvas", ("move", -100, 0), ("down",), ("move", -100 + round(width / 4), 0), ("up",))
    after = state(browser)
    assert after["split"] == pytest.approx(0.75, abs=0.01)
    assert after["x"] == pytest.approx(0.25 - 1 / 16, abs=0.005)


def test_the_wheel_zooms_about_the_pointer_in_all_panes_in_step(browser):
    browser.run("document.querySelector('[data-mode=tiles]').click()")
    widths = browser.run("return Array.from(document.querySelectorAll('.pane canvas'), c => c.width)")
    assert len(widths) == 3 and len(set(widths)) == 1
    browser.point(".pane canvas", ("wheel", -300))
    after = state(browser)
    assert after["zoom"] == pytest.approx(2)
    assert (after["x"], after["y"]) == (pytest.approx(0.25, abs=0.01), pytest.approx(0.25, abs=0.01))
    browser.run("document.querySelector('.reset').click()")
    assert state(browser)["zoom"] == 1


def test_blinking_shows_a_and_b_in_turn(browser):
    browser.run(
        "document.querySelector('[data-mode=blink]').click();"
        "viewers[0].set({a: 0, b: 2, shown: 'a', exposure: 0, view: 'image'});"
        "clearInterval(viewers[0].timer)"
    )
    first = pixel(browser, 0.5)
    browser.run("viewers[0].set({shown: 'b'})")
    assert pixel(browser, 0.5) != first
    browser.run(
        "document.querySelector('[data-mode=blink]').click(); window.seen = new Set();"
        "setInterval(() => window.seen.add(viewers[0].state.shown), 50)"
    )
    browser.wait("window.seen.size === 2")


def test_error_maps_share_one_scale_and_are_black_for_the_reference(browser):
    browser.run(
        "document.querySelector('.view').value = 'error';"
        "document.querySelector('.view').dispatchEvent(new Event('change')); viewers[0].set({a: 0, b: 2})"
    )
    black, bright = browser.run("return [COLOUR_MAPS.error.slice(0, 3), COLOUR_MAPS.error.slice(-3)]")
    assert pixel(browser, 0.25)[:3] == black
    assert browser.run("return document.querySelector('.legend-text').textContent").startswith("0 … ")
    # Four times the truth: an error of 300%; on a scale that ends at 150% it is past the end.
    browser.run("viewers[0].data.scale = 1.5; viewers[0].set({scale: 0.001})")
    assert pixel(browser, 0.75)[:3] == bright
    browser.run("viewers[0].set({view: 'signed'})")
    assert pixel(browser, 0.75)[:3] == browser.run("return COLOUR_MAPS.signed.slice(-3)")


def test_the_pixel_under_the_pointer_is_read_out(browser):
    browser.point(".pane canvas", ("move", 3, 3))
    assert re.match(
        r"32, 16   A -?[\d.]+ -?[\d.]+ -?[\d.]+   B ", browser.run("return document.querySelector('.pixel').value")
    )


def test_tables_charts_graphs_and_provenance_are_there(browser, report, tmp_path):
    text = browser.run("return document.body.innerText")
    for words in (
        "Equal frames",
        "Single frames",
        "Equal time",
        "Bias and correlation",
        "four</script> times",
        "Provenance",
        "code hash",
    ):
        assert words in text
    assert browser.run("return Array.from(document.querySelectorAll('.charts img')).every(i => i.naturalWidth > 0)")
    browser.run("document.querySelectorAll('details').forEach(each => each.open = true)")
    assert browser.run("return Array.from(document.querySelectorAll('.differs td'), e => e.textContent.trim())") == [
        "gain = 1.0",
        "gain = 4",
        "noise = 1.0",
        "noise = 0.1",
    ]
    browser.screenshot(tmp_path / "report.png")
    assert (tmp_path / "report.png").stat().st_size > 10000


def test_lines_side_by_side_mark_changes_additions_and_omissions():
    rows = side_by_side(["a", "b", "c"], ["a", "B", "c", "d"])
    assert rows == [("a", "a", False), ("b", "B", True), ("c", "c", False), ("", "d", True)]


def test_the_commit_is_the_clones_and_an_installed_packages_is_that_of_its_build(tmp_path, monkeypatch):
    def git(*arguments):
        command = ["git", "-C", tmp_path, "-c", "user.name=a", "-c", "user.email=a@example.org", *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    git("init", "-q")
    (tmp_path / "file").touch()
    git("add", "file")
    git("commit", "-qm", "first")
    monkeypatch.setattr(render, "ROOT", tmp_path)
    assert commit() == git("rev-parse", "--short=12", "HEAD")
    (tmp_path / "file").write_text("changed")
    assert commit() == git("rev-parse", "--short=12", "HEAD") + " + changes"
    installed = tmp_path / "venv/lib/python3"
    installed.mkdir(parents=True)
    monkeypatch.setattr(render, "ROOT", installed)
    assert commit() == restirpg.COMMIT
