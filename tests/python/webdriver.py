"""A headless Chromium, driven through chromedriver's WebDriver protocol with the standard library."""

import base64
import json
import re
import shutil
import subprocess
import tempfile
import time
import urllib.request

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--hide-scrollbars",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1280,1600",
]


class Browser:
    """A context manager: `with Browser() as browser: browser.open(file)`."""

    def __enter__(self):
        self._profile = tempfile.mkdtemp()
        self._driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, text=True)
        try:
            self._start_session()
        except BaseException:
            self._stop_driver()
            raise
        return self

    def __exit__(self, *exception):
        self._ask("", method="DELETE")
        self._stop_driver()

    def _start_session(self):
        for line in self._driver.stdout:
            if match := re.search(r"started successfully on port (\d+)", line):
                break
        else:
            raise RuntimeError("chromedriver did not start")
        self._url = f"http://127.0.0.1:{match[1]}/session"
        options = {"args": [*FLAGS, f"--user-data-dir={self._profile}"]}
        capabilities = {
            "alwaysMatch": {
                "browserName": "chrome",
                "goog:chromeOptions": options,
                "goog:loggingPrefs": {"browser": "ALL"},
            }
        }
        self._url += "/" + self._ask("", {"capabilities": capabilities})["sessionId"]

    def _stop_driver(self):
        self._driver.terminate()
        self._driver.wait(60)
        shutil.rmtree(self._profile, ignore_errors=True)

    def _ask(self, path, body=None, method="POST"):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self._url + path, data, {"Content-Type": "application/json"}, method=method)
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        with opener.open(request, timeout=60) as answer:
            return json.load(answer)["value"]

    def open(self, place):
        """Load a local file, or an address."""
        self._ask("/url", {"url": place if "://" in str(place) else f"file://{place}"})

    def wait(self, condition, seconds=60):
        """Until a JavaScript expression holds."""
        deadline = time.monotonic() + seconds
        while not self.run(f"return Boolean({condition})"):
            assert time.monotonic() < deadline, condition
            time.sleep(0.05)

    def resize(self, width, height):
        """Give the page that many CSS pixels, as a narrow device has them."""
        self._ask(
            "/goog/cdp/execute",
            {
                "cmd": "Emulation.setDeviceMetricsOverride",
                "params": {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
            },
        )

    def run(self, script):
        """The value of a JavaScript function body."""
        return self._ask("/execute/sync", {"script": script, "args": []})

    def point(self, selector, *actions):
        """Pointer actions on the first element of a CSS selector: ("move", x, y), x and y from its centre in
        CSS pixels, ("down",), ("up",), ("wheel", delta)."""
        element = self._ask("/element", {"using": "css selector", "value": selector})
        # Its centre is that of the part in view.
        self.run(f"document.querySelector({json.dumps(selector)}).scrollIntoView({{block: 'center'}})")
        pointer, wheel = [], []
        for name, *values in actions:
            if name == "move":
                at = {"x": values[0], "y": values[1], "origin": element}
                pointer.append({"type": "pointerMove", "duration": 20, **at})
            elif name == "wheel":
                wheel.append({"type": "scroll", "x": 0, "y": 0, "deltaX": 0, "deltaY": values[0], "origin": element})
            else:
                pointer.append({"type": "pointerDown" if name == "down" else "pointerUp", "button": 0})
        sources = [{"type": "pointer", "id": "mouse", "actions": pointer}] if pointer else []
        sources += [{"type": "wheel", "id": "wheel", "actions": wheel}] if wheel else []
        self._ask("/actions", {"actions": sources})

    def log(self):
        """Errors of scripts and of the network since the last call."""
        return [entry["message"] for entry in self._ask("/se/log", {"type": "browser"}) if entry["level"] == "SEVERE"]

    def screenshot(self, file):
        """Write a PNG of the window."""
        file.write_bytes(base64.b64decode(self._ask("/screenshot", method="GET")))
