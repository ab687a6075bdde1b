"""A browser driven over WebDriver (W3C), which is JSON over HTTP: no more of it than the tests need."""

import base64
import contextlib
import json
import os
import shutil
import socket
import subprocess
import time

import httpx

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
DRIVERS = ("chromedriver",)

FLAGS = (
    "--headless=new", "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-default-apps", "--no-first-run", "--no-default-browser-check", "--enable-unsafe-swiftshader",
    "--force-color-profile=srgb", "--hide-scrollbars", "--webgl-antialiasing-mode=none",
)  # fmt: skip

WAIT = 120
"""Seconds that a command of the browser may take: software drawing is slow on a busy machine."""


def installed(names):
    return next(filter(None, map(shutil.which, names)), None)


def missing():
    """Names the programs that are not installed here; empty if all are."""
    wanted = {"Chromium": BROWSERS, "chromedriver": DRIVERS}
    return " and ".join(name for name, names in wanted.items() if installed(names) is None)


class Browser:
    """A headless Chromium with a window of this size, closed at the end of `with`. `ratio`: its pixels by
    those of the page's own measure."""

    def __init__(self, *flags, width=1280, height=900, dark=False, ratio=1.0):
        self.ratio = ratio
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.process = subprocess.Popen(
            [str(installed(DRIVERS)), f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.client = httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=WAIT, trust_env=False)
        root = ("--no-sandbox", "--disable-dev-shm-usage") if os.geteuid() == 0 else ()
        options = {
            "binary": installed(BROWSERS),
            "args": [*FLAGS, *root, f"--window-size={width},{height}", *flags],
            "perfLoggingPrefs": {"enableNetwork": True},
        }
        wanted = {
            "browserName": "chrome",
            "goog:chromeOptions": options,
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"},
            "timeouts": {"script": WAIT * 1000},
        }
        try:
            self._await_driver()
            session = self._post("/session", {"capabilities": {"alwaysMatch": wanted}})
        except BaseException:
            self.process.kill()
            raise
        self.page = None
        self.path = f"/session/{session['sessionId']}"
        self.size(width, height, dark=dark)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        with contextlib.suppress(httpx.HTTPError):
            self.client.delete(self.path)
        self.client.close()
        self.process.terminate()
        self.process.wait(10)

    def _await_driver(self):
        until = time.monotonic() + WAIT
        while True:
            try:
                if self.client.get("/status").json()["value"]["ready"]:
                    return
            except httpx.ConnectError:
                pass
            if time.monotonic() > until:
                raise TimeoutError("chromedriver does not answer")
            time.sleep(0.05)

    def _post(self, path, body):
        value = self.client.post(path, json=body).json()["value"]
        if isinstance(value, dict) and "error" in value:
            raise RuntimeError(f"{value['error']}: {value['message'].splitlines()[0]}")
        return value

    def cdp(self, command, **parameters):
        """A command of Chromium's own protocol."""
        body = {"cmd": command, "params": parameters}
        return self._post(f"{self.path}/goog/cdp/execute", body)

    def size(self, width, height, *, dark=False, still=False):
        """Sets the page's area [px], light or dark, and whether little motion is wanted."""
        self.cdp(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=self.ratio, mobile=False,
        )  # fmt: skip
        features = {"prefers-color-scheme": "dark" if dark else "light"}
        features["prefers-reduced-motion"] = "reduce" if still else "no-preference"
        named = [{"name": name, "value": value} for name, value in features.items()]
        self.cdp("Emulation.setEmulatedMedia", features=named)

    def open(self, page):
        """Opens a file from disk, and waits until the view has started or said why it does not."""
        self.page = page
        self._post(f"{self.path}/url", {"url": page.as_uri()})
        # The answer to a navigation may come before the page's scripts have run.
        self.run(
            "for (let i = 0; i < 300 && document.readyState !== 'complete'; i++)"
            "  await new Promise((done) => setTimeout(done, 100));"
            "await window.linkwright?.ready"
        )

    def leave(self):
        """Closes the page."""
        self.page = None
        self._post(f"{self.path}/url", {"url": "about:blank"})

    def run(self, script, *values):
        """Runs the body of an async function; `values` are its `arguments`."""
        code = f"return (async function() {{ {script} }}).apply(null, arguments)"
        return self._post(f"{self.path}/execute/sync", {"script": code, "args": list(values)})

    def act(self, *actions):
        """Lets a mouse act: WebDriver's own steps of a pointer."""
        kind = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}}
        mouse = {**kind, "actions": list(actions)}
        self._post(f"{self.path}/actions", {"actions": [mouse]})

    def keys(self, text):
        steps = [{"type": kind, "value": key} for key in text for kind in ("keyDown", "keyUp")]
        self._post(f"{self.path}/actions", {"actions": [{"type": "key", "id": "keys", "actions": steps}]})

    def console(self):
        """Errors and warnings since the last call."""
        entries = self._post(f"{self.path}/se/log", {"type": "browser"})
        return [entry["message"] for entry in entries if entry["level"] in ("SEVERE", "WARNING")]

    def requests(self):
        """The addresses that were asked for since the last call, without pictures that are in the page."""
        for entry in self._post(f"{self.path}/se/log", {"type": "performance"}):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                address = message["params"]["request"]["url"]
                if not address.startswith("data:"):
                    yield address

    def picture(self, path, *, whole=False):
        """Saves what is to be seen as PNG; `whole`: the page down to its end."""
        screenshot = self.cdp("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(screenshot["data"]))
