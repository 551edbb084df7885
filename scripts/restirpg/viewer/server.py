"""The viewer's web server: one page, one WebSocket a tab, on the loopback address, behind a token in the path.

The event loop never renders: all that touches the session goes through the render thread. A tab is sent the newest
picture when it has shown the last one, so a slow one drops frames.
"""

import asyncio
import contextlib
import functools
import hmac
import json
import secrets
import struct
from collections import deque
from pathlib import Path

from aiohttp import WSMsgType, web

from . import capture
from .rendering import told
from .values import as_json

PAGE = Path(__file__).parent / "page"
_TYPES = {
    "": "text/html",
    "viewer.js": "text/javascript",
    "controls.js": "text/javascript",
    "navigation.js": "text/javascript",
    "panel.js": "text/javascript",
    "viewer.css": "text/css",
}
_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; "
    "connect-src 'self' ws:",
}
_LARGEST = 1 << 16  # bytes of a message from a page


class Client:
    """A tab: what it is still to be sent."""

    def __init__(self, number, socket):
        self.number, self.socket = number, socket
        self.visible = self.ready = True  # ready: it has shown the last frame
        self.state = self.frame = None  # the newest of each
        self.notes = deque(maxlen=20)
        self.news = asyncio.Event()

    async def send_until_closed(self):
        """Send what is new until the tab is gone, or this is cancelled."""
        with contextlib.suppress(ConnectionError):
            await self._send_on()

    async def _send_on(self):
        while True:
            await self.news.wait()
            self.news.clear()
            while self.notes:
                await self.socket.send_str(as_json(self.notes.popleft()))
            if self.state is not None:
                state, self.state = self.state, None
                await self.socket.send_str(as_json({"state": state, "you": self.number}))
            if self.frame is not None and self.ready:
                frame, self.frame, self.ready = self.frame, None, False
                await self.socket.send_bytes(pack(frame))


def pack(frame):
    """The length of the header (4 bytes, little endian), the header as JSON, and the pictures."""
    header = as_json(frame.header).encode()
    return b"".join([struct.pack("<I", len(header)), header, *frame.images])


class Server:
    """Serves a session that `thread` renders; `publish` is what that thread is to call."""

    def __init__(self, session, loop):
        self.token = secrets.token_urlsafe(24)
        self._session, self._loop, self.thread = session, loop, None
        self._clients, self._count = [], 0

    def publish(self, **news):
        """From the render thread: something new for every tab."""
        self._loop.call_soon_threadsafe(functools.partial(self._spread, **news))

    def _spread(self, state=None, frame=None, **note):
        for client in self._clients:
            client.state = state or client.state
            client.frame = frame or client.frame
            if note:
                client.notes.append(note)
            client.news.set()

    def _count_audience(self):
        watching = [client for client in self._clients if client.visible]
        self.thread.set_audience(bool(watching), any(client.ready for client in watching))

    def application(self):
        """The aiohttp application. Its middleware refuses every path that does not begin with the token."""
        application = web.Application(middlewares=[self._guard])
        for name in _TYPES:
            application.router.add_get(f"/{{token}}/{name}", self._page)
        application.router.add_get("/{token}/live", self._live)
        application.router.add_get("/{token}/capture/{name}", self._capture)
        application.on_shutdown.append(self._close)
        return application

    @web.middleware
    async def _guard(self, request, handler):
        token = request.path.split("/")[1]
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            raise web.HTTPForbidden(text="This address lacks the viewer's token: use the one that it printed.\n")
        response = await handler(request)
        if not response.prepared:
            response.headers.update(_HEADERS)
        return response

    async def _page(self, request):
        name = request.path.split("/")[2]
        return web.Response(
            body=(PAGE / (name or "index.html")).read_bytes(), content_type=_TYPES[name], charset="utf-8"
        )

    async def _capture(self, request):
        """A download: its name chooses what it is, see capture.py; the page's query which graph."""
        pane = request.query.get("pane", "0")
        try:
            found = self.thread.submit(capture.make, self._session, request.match_info["name"], pane)
            data, content_type, name = await asyncio.wrap_future(found)
        except Exception as error:
            raise web.HTTPBadRequest(text=told(error) + "\n") from None
        return web.Response(
            body=data, content_type=content_type, headers={"Content-Disposition": f'attachment; filename="{name}"'}
        )

    async def _live(self, request):
        socket = web.WebSocketResponse(heartbeat=15, max_msg_size=_LARGEST, compress=False)
        await socket.prepare(request)
        self._count += 1
        client = Client(self._count, socket)
        sender = asyncio.ensure_future(client.send_until_closed())
        self._clients.append(client)
        self._greet(client)
        try:
            async for message in socket:
                if message.type == WSMsgType.TEXT:
                    self._receive(client, message.data)
        finally:
            sender.cancel()
            self._clients.remove(client)
            self._count_audience()
            self.thread.submit(self._session.seen.pop, client.number, None)
        return socket

    def _greet(self, client):
        """Send the state and the picture there is to a new tab."""

        def arrived(name, future):
            if future.cancelled():
                return
            if error := future.exception():
                self._note(client, error=told(error))
            else:
                setattr(client, name, future.result())
            client.news.set()
            self._count_audience()

        for name in ("state", "frame"):
            future = asyncio.wrap_future(self.thread.submit(getattr(self._session, name)))
            future.add_done_callback(functools.partial(arrived, name))

    def _receive(self, client, text):
        """A message of a page: a command for the session, "shown", "visible", "inspect" or "guide"."""
        try:
            message = json.loads(text)
            if not isinstance(message, dict):
                raise ValueError("it is no object")
        except ValueError as error:
            self._note(client, error=f"not a message of the viewer's page: {error}")
            return
        kind, number = message.get("do"), message.get("id")
        if kind in ("shown", "visible"):
            if kind == "shown":
                client.ready = True
                client.news.set()
            else:
                client.visible = message.get("on") is True
            self._count_audience()
        elif kind == "inspect":
            asked = (message.get(name) for name in ("x", "y"))
            self._answer(client, number, self.thread.submit(self._session.inspector.pixel, *asked), "pixel")
        elif kind == "guide":
            asked = (message.get(name) for name in ("pane", "x", "y", "product"))
            self._answer(client, number, self.thread.submit(self._session.inspector.guide, *asked), "guide")
        else:
            self._answer(client, number, self.thread.submit(self._session.apply, message, client.number))

    def _answer(self, client, number, future, name=None):
        """Tell the tab the result of a call under `name`, or what went wrong. number: id of the message that is refused
        then."""

        def finished(done):
            if done.cancelled():
                return
            if error := done.exception():
                self._note(client, error=told(error), refused=number)
            elif name:
                self._note(client, **{name: done.result()})

        asyncio.wrap_future(future).add_done_callback(finished)

    @staticmethod
    def _note(client, **note):
        client.notes.append(note)
        client.news.set()

    async def _close(self, _):
        for client in list(self._clients):
            await client.socket.close()
