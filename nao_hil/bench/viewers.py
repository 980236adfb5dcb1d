"""Who looks at the live page in its benchmark: one who only takes what it sends, and a browser."""

from __future__ import annotations

import shutil
import threading
import time
from abc import ABC, abstractmethod
from typing import Final

import msgspec

from bridge.errors import ConfigurationError, LinkError
from nao_hil.runs.supervisor import free_port
from nao_hil.view.export.video import CHROMIUM, SOFTWARE

PICTURE: Final = b"/world/robot/Torso"
"""What a message of the page has in it that moves the robot, once its msgpack part is decompressed."""
HEADER: Final = 16
"""Bytes before that part: its sizes decompressed and compressed, two little-endian uint64."""
LOOK: Final = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (1.0, 0.0, 0.5),
    "fov": 1.0,
    "near": 0.01,
    "far": 100.0,
    "image_height": 800,
    "image_width": 1280,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}
"""What a browser says first; from then on it is sent pictures."""
COUNT: Final = """
(() => {
  let drew = false;
  const draw = WebGL2RenderingContext.prototype.drawElements;
  WebGL2RenderingContext.prototype.drawElements = function (...a) { drew = true; return draw.apply(this, a); };
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
        import viser
        import zstandard
        from websockets.sync.client import connect
        from websockets.typing import Origin, Subprotocol

        own, pictures = f"127.0.0.1:{self.port}", 0
        reader = zstandard.ZstdDecompressor()
        with connect(
            f"ws://{own}",
            origin=Origin(f"http://{own}"),
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            max_size=None,
            compression=None,
        ) as page:
            page.send(msgspec.msgpack.encode(LOOK))
            self._ready.set()
            begin = time.monotonic()
            while not self._stop.is_set():
                try:
                    message = page.recv(timeout=0.1, decode=False)
                except TimeoutError:
                    continue
                size = int.from_bytes(message[8:HEADER], "little")
                pictures += PICTURE in reader.decompress(message[HEADER : HEADER + size])
            self._rate = pictures / (time.monotonic() - begin)


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
            page.wait_for_selector(".uplot canvas")
            self._ready.set()
            begin, first = time.monotonic(), page.evaluate("window.pictures")
            self._stop.wait()
            self._rate = (page.evaluate("window.pictures") - first) / (time.monotonic() - begin)
            browser.close()
