"""Viewers of the live page in its benchmark: a client that draws nothing, and a browser."""

from __future__ import annotations

import shutil
import threading
import time
from abc import ABC, abstractmethod
from typing import Final

from bridge.errors import ConfigurationError, LinkError
from nao_hil.runs.supervisor import free_port
from nao_hil.view.video import CHROMIUM, SOFTWARE

GZIP: Final = b"\x1f\x8b"
"""First bytes of a packed run; other binary messages are rows."""
COUNT: Final = """
(() => {
  let drew = false;
  const draw = WebGL2RenderingContext.prototype.drawArrays;
  WebGL2RenderingContext.prototype.drawArrays = function (...a) { drew = true; return draw.apply(this, a); };
  window.pictures = 0;
  const count = () => { window.pictures += drew; drew = false; requestAnimationFrame(count); };
  count();
})()
"""
"""Counts the pictures that a browser draws, in `window.pictures`."""


class Viewer(ABC):
    """Looks at a page in a thread of its own, from its creation to `close`."""

    def __init__(self) -> None:
        self.port = free_port()
        self._ready, self._stop = threading.Event(), threading.Event()
        self._rate = 0.0
        self._thread = threading.Thread(target=self._look, daemon=True)

    def open(self, timeout: float) -> None:
        """Look at the page, which is served, and wait until it is shown; `timeout` in s. Raises LinkError."""
        self._thread.start()
        if not self._ready.wait(timeout):
            raise LinkError("the page was not shown.")

    def close(self) -> float:
        """Look away; returns the pictures per second since the page was shown."""
        self._stop.set()
        self._thread.join()
        return self._rate

    @abstractmethod
    def _look(self) -> None:
        """Look until `_stop`: set `_ready` when the page is shown and, at the end, `_rate`."""


class Receiver(Viewer):
    """Takes everything, draws nothing."""

    def _look(self) -> None:
        from websockets.sync.client import connect
        from websockets.typing import Origin

        own, rows = f"127.0.0.1:{self.port}", 0
        with connect(f"ws://{own}/", origin=Origin(f"http://{own}"), max_size=None, compression=None) as page:
            self._ready.set()
            begin = time.monotonic()
            while not self._stop.is_set():
                try:
                    message = page.recv(timeout=0.1)
                except TimeoutError:
                    continue
                rows += isinstance(message, bytes) and message[:2] != GZIP
            self._rate = rows / (time.monotonic() - begin)


class Browser(Viewer):
    """Headless Chromium that draws in software at 1280 x 800.

    Raises:
        ConfigurationError: there is no Chromium, or no playwright.
    """

    def __init__(self) -> None:
        super().__init__()
        try:
            import playwright  # noqa: F401
        except ModuleNotFoundError:
            raise ConfigurationError("This needs playwright: pip install 'nao-hil[video]'.") from None
        self._path = next((path for name in CHROMIUM if (path := shutil.which(name))), None)
        if self._path is None:
            raise ConfigurationError("This needs Chromium; on Debian or Ubuntu: apt-get install chromium.")

    def _look(self) -> None:
        from playwright.sync_api import sync_playwright

        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=self._path, args=list(SOFTWARE))
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.set_default_timeout(0)  # `open` has one
            page.add_init_script(COUNT)
            page.goto(f"http://127.0.0.1:{self.port}/")
            page.wait_for_selector("body[data-ready=yes]")
            self._ready.set()
            begin, first = time.monotonic(), page.evaluate("window.pictures")
            self._stop.wait()
            self._rate = (page.evaluate("window.pictures") - first) / (time.monotonic() - begin)
            browser.close()
