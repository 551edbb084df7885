"""A live viewer in the browser: `restirpg.view(...)`, or scripts/view.py from a shell.

session.py    what is looked at and how, without a network; pane.py one graph of it, camera.py its moves
commands.py   what the page may ask for; inspector.py what is known of one pixel
rendering.py  the thread that owns the session
server.py     the page and its WebSocket; capture.py the downloads
page/         what runs in the browser
"""

from .start import Viewer, view

__all__ = ["Viewer", "view"]
