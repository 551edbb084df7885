"""The viewer over the network: the token, pictures, commands, a slow tab, a closed one, and exceptions in rendering."""

import asyncio
import io
import json
import logging
import random
import struct
import threading
import time

import numpy as np
import pytest
from renderer_scenes import GRAPH, restirpg

aiohttp = pytest.importorskip("aiohttp", reason="aiohttp is not installed: the viewer's server is not tested")
Image = pytest.importorskip("PIL.Image", reason="Pillow is not installed: the viewer's server is not tested")

import viewer_monkey  # noqa: E402

from restirpg.viewer import capture  # noqa: E402
from restirpg.viewer.values import as_json  # noqa: E402

SIZE = (16, 16)
SECONDS = 60  # until a test gives up


@pytest.fixture(scope="module")
def viewer(scene):
    """A running viewer that all tests use."""
    with restirpg.view(GRAPH, scene, SIZE, validation=True) as running:
        yield running


def strict(text):
    """JSON as a browser reads it, without NaN and Infinity."""

    def refuse(name):
        raise AssertionError(f"{name} is no JSON")

    return json.loads(text, parse_constant=refuse)


class Tab:
    """What a page does, without a browser."""

    def __init__(self, socket):
        self.socket, self.states, self.notes, self.frames = socket, [], [], 0

    async def send(self, **message):
        await self.socket.send_json(message)

    async def receive(self):
        """The next message: ("frame", header, JPEG) or ("text", dictionary)."""
        message = await asyncio.wait_for(self.socket.receive(), SECONDS)
        if message.type == aiohttp.WSMsgType.BINARY:
            (length,) = struct.unpack("<I", message.data[:4])
            self.frames += 1
            return "frame", strict(message.data[4 : 4 + length]), message.data[4 + length :]
        assert message.type == aiohttp.WSMsgType.TEXT, message
        return "text", strict(message.data), b""

    async def until(self, wanted, shows=True):
        """The first message, or frame header, for which `wanted` holds; frames are shown on the way."""
        deadline = time.monotonic() + SECONDS
        while True:
            assert time.monotonic() < deadline
            kind, content, data = await self.receive()
            if kind == "frame" and shows:
                await self.send(do="shown")
            if wanted(kind, content):
                return content, data


def with_tab(viewer, *bodies):
    """Run body(tab) of each, at the same time, each on a socket of its own."""

    async def one(session, body):
        async with session.ws_connect(viewer.url + "live", max_msg_size=0) as socket:
            return await body(Tab(socket))

    async def all_of_them():
        async with aiohttp.ClientSession() as session:
            return await asyncio.gather(*(one(session, body) for body in bodies))

    return asyncio.run(all_of_them())


def fetch(url):
    async def get():
        async with aiohttp.ClientSession() as session, session.get(url) as answer:
            return answer.status, answer.content_type, await answer.read()

    return asyncio.run(get())


def is_frame(kind, _):
    return kind == "frame"


def test_a_tab_gets_the_state_and_pictures_of_the_size(viewer):
    async def body(tab):
        state, _ = await tab.until(lambda kind, content: "state" in content)
        header, data = await tab.until(lambda kind, content: kind == "frame" and content["sizes"])
        return state, header, data

    state, header, data = with_tab(viewer, body)[0]
    assert state["state"]["size"] == list(SIZE) and state["state"]["panes"][0]["passes"]
    assert header["sizes"] == [len(data)] and Image.open(io.BytesIO(data)).size == SIZE
    assert set(header["panes"][0]["passes"]) == {"gbuffer", "paths", "accumulate"}


def test_only_the_token_opens_anything_and_no_path_leaves_the_page(viewer):
    base, token = viewer.url[:-1].rsplit("/", 1)
    assert fetch(viewer.url)[0] == 200 and fetch(viewer.url + "viewer.js")[1] == "text/javascript"
    for path in ("", "wrong/", f"{token}x/", "viewer.js", "wrong/live", f"wrong/{token}/", f"wrong/../{token[:-1]}/"):
        assert fetch(f"{base}/{path}")[0] == 403, path
    for path in ("../viewer.js", "..%2fserver.py", "server.py", "capture/..%2f..%2fetc%2fpasswd", "%2fetc%2fpasswd"):
        assert fetch(viewer.url + path)[0] in (400, 403, 404), path
    assert base.startswith("http://127.0.0.1:")


def test_a_knob_and_a_move_reach_the_picture(viewer):
    async def body(tab):
        await tab.send(do="orbit", x=0.1, y=0.0, id=7)
        await tab.send(do="set", pane=0, knob="paths.bounces", value=2, id=8)
        header, _ = await tab.until(lambda kind, content: kind == "frame" and 8 in content["seen"].values())
        await tab.send(do="reset", pane=0)
        await tab.send(do="inspect", x=8, y=8)
        pixel, _ = await tab.until(lambda kind, content: "pixel" in content)
        return header, pixel

    header, pixel = with_tab(viewer, body)[0]
    assert header["panes"][0]["frames"] <= 2 and pixel["pixel"]["geometry"]["depth"] > 0


def test_a_mistake_is_told_and_the_viewer_goes_on(viewer):
    async def body(tab):
        for message, words in (
            ({"do": "set", "pane": 0, "knob": "paths.nothing", "value": 1}, "nothing"),
            ({"do": "x"}, "no command"),
        ):
            await tab.send(**message)
            error, _ = await tab.until(lambda kind, content: "error" in content)
            assert words in error["error"]
        for text in ("{", "[]", "nonsense"):
            await tab.socket.send_str(text)
            assert "not a message" in (await tab.until(lambda kind, content: "error" in content))[0]["error"]
        await tab.until(is_frame)

    with_tab(viewer, body)


def test_a_tab_that_shows_nothing_is_sent_no_more_and_another_sees_on(viewer):
    async def slow(tab):
        await tab.until(is_frame, shows=False)
        with pytest.raises(asyncio.TimeoutError):
            while True:
                kind, *_ = await asyncio.wait_for(tab.receive(), 3)
                assert kind != "frame"

    async def quick(tab):
        first, _ = await tab.until(is_frame)
        await tab.until(
            lambda kind, content: kind == "frame" and content["panes"][0]["frames"] > first["panes"][0]["frames"] + 5
        )

    with_tab(viewer, slow, quick)


def test_nothing_is_rendered_without_a_tab_that_is_seen(viewer):
    async def hidden(tab):
        await tab.until(is_frame)
        await tab.send(do="visible", on=False)
        await tab.send(do="inspect", x=1, y=1)
        await tab.until(lambda kind, content: "pixel" in content)
        frames = [viewer.session.panes[0].renderer.frame]
        await asyncio.sleep(0.5)
        return frames + [viewer.session.panes[0].renderer.frame]

    before, after = with_tab(viewer, hidden)[0]
    assert after - before <= 1
    deadline = time.monotonic() + SECONDS
    while viewer.rendering.watched and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not viewer.rendering.watched


def test_a_film_goes_on_without_a_tab(viewer, tmp_path, monkeypatch):
    async def body(tab):
        await tab.until(is_frame)
        await tab.send(do="visible", on=False)
        await tab.send(do="film", frames=40, kind="png")
        state, _ = await tab.until(lambda kind, content: content.get("state", {}).get("film"))
        return state["state"]["film"]

    monkeypatch.setattr(viewer.session, "captures", tmp_path)
    film = with_tab(viewer, body)[0]
    assert film["count"] == 40 and film["done"] < 40
    deadline = time.monotonic() + SECONDS
    while viewer.session.film and time.monotonic() < deadline:
        time.sleep(0.05)
    assert len(list(tmp_path.glob("*/*/*.png"))) == 40


def test_an_exception_in_rendering_is_shown_and_the_viewer_lives(viewer, monkeypatch, capsys):
    def broken(kept):
        raise ZeroDivisionError("a fault in a test")

    async def body(tab):
        await tab.until(is_frame)
        monkeypatch.setattr(viewer.session.panes[0], "render", broken)
        await tab.send(do="restart")
        error, _ = await tab.until(lambda kind, content: "error" in content)
        monkeypatch.undo()
        await tab.send(do="play", on=True)
        await tab.send(do="restart", id=99)
        await tab.until(lambda kind, content: kind == "frame" and 99 in content["seen"].values())
        return error

    assert with_tab(viewer, body)[0] == {"error": "ZeroDivisionError: a fault in a test"}


def test_a_fault_in_an_answer_is_one_line_and_its_traceback_is_printed(viewer, monkeypatch, capsys):
    def broken(*_):
        raise ZeroDivisionError("a fault in a test")

    async def body(tab):
        await tab.send(do="inspect", x=-1, y=0)
        mistake, _ = await tab.until(lambda kind, content: "error" in content)
        before = capsys.readouterr().err
        monkeypatch.setattr(viewer.session.panes[0], "pixel", broken)
        await tab.send(do="inspect", x=1, y=1)
        fault, _ = await tab.until(lambda kind, content: "error" in content)
        monkeypatch.undo()
        return mistake["error"], before, fault["error"]

    mistake, before, fault = with_tab(viewer, body)[0]
    assert mistake.startswith("pixel -1 0 is not one") and not before
    assert fault == "ZeroDivisionError: a fault in a test"
    printed = capsys.readouterr().err
    assert printed.startswith("Traceback ") and "in broken" in printed
    monkeypatch.setitem(capture._KINDS, "picture.png", (broken, "image/png"))
    assert fetch(viewer.url + "capture/picture.png")[2] == b"ZeroDivisionError: a fault in a test\n"
    assert "in broken" in capsys.readouterr().err


def test_pictures_come_again_once_what_failed_is_changed(viewer, monkeypatch, capsys):
    def broken():
        raise ZeroDivisionError("a fault in a test")

    async def body(tab):
        await tab.until(is_frame)
        monkeypatch.setattr(viewer.session, "frame", broken)
        await tab.until(lambda kind, content: "error" in content)
        frames = viewer.session.panes[0].frames
        await asyncio.sleep(0.5)  # told once, not again and again, while rendering goes on
        monkeypatch.undo()
        assert viewer.session.panes[0].frames > frames
        await tab.send(do="exposure", stops=0, id=98)
        told = []
        await tab.until(
            lambda kind, content: told.append(content) or (kind == "frame" and 98 in content["seen"].values())
        )
        return [content for content in told if "error" in content]

    assert with_tab(viewer, body)[0] == []


def test_numbers_that_are_not_finite_are_told(viewer, monkeypatch):
    strange = [float("nan"), float("inf"), -float("inf"), 0.5]

    async def body(tab):
        await tab.until(is_frame)
        monkeypatch.setattr(viewer.session.panes[0], "pixel", lambda x, y: {"picture": strange})
        monkeypatch.setattr(viewer.session, "errors", lambda: [float("nan")])
        await tab.send(do="inspect", x=8, y=8)
        pixel, _ = await tab.until(lambda kind, content: "pixel" in content)
        header, _ = await tab.until(lambda kind, content: kind == "frame" and content["panes"][0]["mape"] is not None)
        return pixel["pixel"]["panes"][0]["picture"], header["panes"][0]["mape"]

    assert with_tab(viewer, body)[0] == (["NaN", "Infinity", "-Infinity", 0.5], "NaN")
    assert as_json({"a": (1, [float("nan")])}) == '{"a": [1, ["NaN"]]}'


def test_the_end_does_not_wait_for_a_download(scene, monkeypatch):
    with restirpg.view(GRAPH, scene, SIZE, validation=True) as own:
        rendering, release = threading.Event(), threading.Event()

        def slow(kept):
            rendering.set()
            release.wait(SECONDS)

        monkeypatch.setattr(own.session.panes[0], "render", slow)
        own.rendering.set_audience(True, False)
        assert rendering.wait(SECONDS)
        failures = []

        def download():
            try:
                fetch(own.url + "capture/picture.png")
            except aiohttp.ClientError as error:
                failures.append(error)

        asking = threading.Thread(target=download)
        asking.start()
        while not own.rendering.waiting():  # it asks while a frame is rendered
            time.sleep(0.01)
        threading.Timer(0.5, release.set).start()  # the frame ends once the end is asked for
        start = time.monotonic()
        own.close()
        asking.join()
    assert time.monotonic() - start < 10 and len(failures) == 1
    assert own.rendering.submit(print).cancelled()


def test_a_command_that_nobody_waits_for_is_left_out(viewer):
    blocked, release = viewer.rendering.submit(time.sleep, 0.5), viewer.rendering.submit(int)
    assert release.cancel() and blocked.result(SECONDS) is None
    assert viewer.rendering.submit(int).result(SECONDS) == 0


def test_random_input_leaves_the_viewer_alive(viewer):
    """The monkey of benchmarks/viewer_monkey.py: messages that are right, wrong and absurd."""
    dice = random.Random(5)

    async def body(tab):
        for _ in range(400):
            await tab.send(**viewer_monkey.message(dice))
        for message in viewer_monkey.TAME:
            await tab.send(**message)
        header, data = await tab.until(lambda kind, content: kind == "frame" and 12345 in content["seen"].values())
        assert Image.open(io.BytesIO(data)).size == SIZE

    threads = threading.active_count()
    with_tab(viewer, body)
    assert threading.active_count() <= threads + 1
    assert viewer.rendering.is_alive() and viewer.rendering.waiting() < 10
    assert logging.getLogger("aiohttp.server").getEffectiveLevel() <= logging.ERROR


def test_a_reference_that_shows_something_else_is_told(scene, scene_file, tmp_path, capsys):
    file = tmp_path / "truth.exr"

    def told(scene, **header):
        attributes = {f"restirpg.{name}": text for name, text in header.items()}
        restirpg.write_exr(file, {"": np.ones((SIZE[1], SIZE[0], 3), np.float32)}, attributes=attributes)
        with restirpg.view(GRAPH, scene, SIZE, reference=file):
            pass
        lines = capsys.readouterr().err.splitlines()
        return [line.removeprefix(f"warning: {file}: ").partition(":")[0] for line in lines]

    other = {"pose": "0,0,0", "time": "0.5", "denoised": "true", "camera": "1", "energyCompensation": "true"}
    assert told(scene_file, sceneHash=scene.hash, **other) == [
        "its camera was moved",
        "it shows another time of the animation",
        "it was denoised",
        "its camera is number 1, for the methods it is 0",
        "its energy compensation is true, for the methods it is false",
    ]
    assert told(scene_file, sceneHash=scene.hash) == []
    assert told(scene, sceneHash=scene.hash, camera="1") == []  # of which it may be the camera


def test_a_reference_of_another_bounce_cap_measures_nothing(scene, tmp_path):
    renderer = restirpg.Renderer(scene, restirpg.load_graph(GRAPH), size=SIZE, seed=9, validation=True)
    renderer.set("paths.bounces", 2)
    renderer.render(1)
    renderer.save(tmp_path / "truth.exr")
    with restirpg.view(GRAPH, scene, SIZE, reference=tmp_path / "truth.exr", validation=True) as own:
        (pane,) = own.rendering.submit(own.session.frame).result(SECONDS).header["panes"]
    assert pane["mape"] is None and pane["no_error"] == "its bounce cap is 8, that of the reference is 2"


@pytest.mark.parametrize(
    "options, words",
    [
        ({"window": (0, 0, 8, 8)}, "the viewer shows whole pictures: leave out window"),
        ({"fps": 24}, "leave out fps"),
        ({"graphs": []}, "give 1 to 4 graphs, not 0"),
        ({"reference": "absent.exr"}, "absent.exr"),
        ({"pose": {"position": 1, "target": 2, "up": 3, "yfov": 1.0}}, "position is not three numbers"),
    ],
)
def test_what_view_refuses_is_an_error_of_the_package(scene, options, words):
    graphs = options.pop("graphs", GRAPH)
    with pytest.raises(restirpg.Error, match=words) as caught:
        restirpg.view(graphs, scene, SIZE, **options)
    assert "\n" not in str(caught.value)
