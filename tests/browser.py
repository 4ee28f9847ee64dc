"""A headless Chromium for tests of pages: driven through two pipes, so that it needs no package.

`LOCOSWEEP_BROWSER` names the program where it is not on the path. The browser has no network: a
page that asks for anything fails, and `requests` lists what was asked for.
"""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from types import TracebackType

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
_PATIENCE = 60.0
"""Seconds until a silent browser counts as hung, on a loaded machine too."""

_CONTRAST = """(() => {
  const light = (text) => {
    const [r, g, b] = text.match(/[\\d.]+/g).map(Number)
      .map((v) => (v / 255 <= 0.03928 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = (e) => {
    for (; e; e = e.parentElement) {
      const colour = getComputedStyle(e).backgroundColor;
      if (!colour.endsWith(", 0)")) return colour;
    }
    return "rgb(255, 255, 255)";
  };
  const texts = "p, li, label, select, textarea, button, h1, h2, h3, output, td, th, dd, a, small";
  return Math.min(...[...document.querySelectorAll(texts)].map((e) => {
    const [a, b] = [light(getComputedStyle(e).color), light(ground(e))];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  }));
})()"""


_INK = """(() => { const c = document.getElementById('CANVAS'); const d = c.getContext('2d')
  .getImageData(0, 0, c.width, c.height).data; let n = 0;
  for (let i = 0; i < d.length; i += 4) n = (n * 31 + d[i] + 3 * d[i+1] + 7 * d[i+2]) % 1000003;
  return n; })()"""


def program() -> str | None:
    """Return the browser of this machine, None without one."""
    return next(filter(None, map(shutil.which, (os.environ.get("LOCOSWEEP_BROWSER", ""), *NAMES))),
                None)  # fmt: skip


class Page:
    """One page in a browser of its own.

    Attributes
    ----------
    requests : list of str
        What the page that was opened last asked for, itself and data: addresses left out.
    faults : list of str
        Its errors: of scripts, of its policy, and of what did not load.
    """

    def __init__(self, *, width: int = 1200, height: int = 900) -> None:
        self.requests: list[str] = []
        self.faults: list[str] = []
        self._size = (width, height)
        self._number = 0
        self._buffer = b""
        self._events: list[dict[str, Any]] = []
        self._session: str | None = None

    def __enter__(self) -> Self:
        found = program()
        assert found, "no browser: see tests/browser.py"
        self._home = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_read, self._write = os.pipe()
        self._read, to_write = os.pipe()
        flags = ("--headless=new", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe",
                 "--disable-dev-shm-usage", "--no-first-run", "--disable-extensions",
                 "--host-resolver-rules=MAP * ~NOTFOUND",
                 f"--user-data-dir={self._home.name}", "about:blank")  # fmt: skip
        # The browser takes commands from 3 and answers on 4.
        line = f'exec 3<&{to_read} 4>&{to_write}; exec "$@"'
        self._process = subprocess.Popen(
            ["/bin/bash", "-c", line, "browser", found, *flags], pass_fds=(to_read, to_write),
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(to_read)
        os.close(to_write)
        pages = self.call("Target.getTargets")["targetInfos"]
        target = next(one["targetId"] for one in pages if one["type"] == "page")
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")
        self.resize(*self._size)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._write)
        os.close(self._read)
        self._home.cleanup()

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command of the DevTools protocol and return its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return dict(answer["result"])

    def open(self, file: Path, query: str = "") -> Self:
        """Open a file as a double click does, and wait until it is loaded."""
        for seen in (self._events, self.requests, self.faults):
            seen.clear()
        self.call("Page.navigate", url=file.resolve().as_uri() + query)
        end = time.monotonic() + _PATIENCE
        while not any(one["method"] == "Page.loadEventFired" for one in self._events):
            self._next()
            assert time.monotonic() < end, f"{file} does not load"
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        return self

    def afresh(self, file: Path) -> Self:
        """Open a file on a light screen of the usual size, whatever was set before."""
        self.resize(1200, 900)
        self.medium()
        return self.open(file)

    def wait(self, seconds: float) -> None:
        """Let the page go on for a while."""
        self.run(f"new Promise(done => setTimeout(done, {1000.0 * seconds}))")

    def ink(self, canvas: str) -> int:
        """Return a number that changes with the picture in a canvas."""
        return int(self.run(_INK.replace("CANVAS", canvas)))

    def run(self, script: str) -> Any:
        """Evaluate JavaScript in the page and return its value."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True,
                           awaitPromise=True)  # fmt: skip
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def resize(self, width: int, height: int) -> None:
        """Give the window another size; below 500 pixels it is a phone."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=width < 500)  # fmt: skip

    def medium(self, *, dark: bool = False, kind: str = "") -> None:
        """Show the page in a dark or light scheme, on a screen or on paper."""
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", media=kind, features=[scheme])

    def key(self, name: str) -> None:
        """Press a key."""
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=name, code=name)

    def mouse(self, kind: str, x: float, y: float, button: str = "none") -> None:
        """Move, press or release the mouse: kind is mouseMoved, mousePressed or mouseReleased."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, clickCount=1,
                  buttons=int(button == "left"))  # fmt: skip

    def click(self, x: float, y: float) -> None:
        """Click with the left button."""
        self.mouse("mouseMoved", x, y)
        self.mouse("mousePressed", x, y, "left")
        self.mouse("mouseReleased", x, y, "left")

    def picture(self, file: Path, *, whole: bool = True) -> None:
        """Write what is seen as PNG."""
        found = self.call("Page.captureScreenshot", captureBeyondViewport=whole)
        if whole:
            size = self.call("Page.getLayoutMetrics")["cssContentSize"]
            clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
            found = self.call("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
        file.write_bytes(base64.b64decode(found["data"]))

    def print_to(self, file: Path) -> None:
        """Print the page to a PDF."""
        file.write_bytes(base64.b64decode(self.call("Page.printToPDF")["data"]))

    def contrast(self) -> float:
        """Return the least contrast of a text with its ground (WCAG 2: 4.5 is legible)."""
        return float(self.run(_CONTRAST))

    def overflow(self) -> int:
        """Return by how many pixels the page is wider than its window."""
        root = "document.documentElement"
        return int(self.run(f"{root}.scrollWidth - {root}.clientWidth"))

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._read], [], [], _PATIENCE)
            assert ready, "the browser does not answer"
            some = os.read(self._read, 1 << 20)
            assert some, "the browser has ended"
            self._buffer += some
        text, _, self._buffer = self._buffer.partition(b"\0")
        message: dict[str, Any] = json.loads(text)
        if "method" in message:
            self._events.append(message)
            self._note(message["method"], message["params"])
        return message

    def _note(self, method: str, what: dict[str, Any]) -> None:
        if method == "Network.requestWillBeSent":
            address = what["request"]["url"]
            if address.partition(":")[0] not in ("data", "about") and what["type"] != "Document":
                self.requests.append(address)
        elif method == "Network.loadingFailed":
            self.faults.append(f"not loaded: {what['errorText']}")
        elif method == "Runtime.exceptionThrown":
            self.faults.append(str(what["exceptionDetails"]))
        elif method == "Log.entryAdded" and what["entry"]["level"] == "error":
            self.faults.append(str(what["entry"]["text"]))
        elif method == "Runtime.consoleAPICalled" and what["type"] in ("error", "assert"):
            self.faults.append(str(what["args"]))
