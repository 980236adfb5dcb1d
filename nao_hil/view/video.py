"""A recorded run as a video: an exported page draws it in a headless Chromium, which encodes it."""

from __future__ import annotations

import base64
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.progress import track

from bridge.errors import ConfigurationError
from nao_hil.files import write_bytes
from nao_hil.view.page import recorded_page
from nao_hil.view.webm import EncodedPicture, webm

CHROMIUM: Final = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
SOFTWARE: Final = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""It draws without a graphics card."""
SIZE: Final = (1280, 720)
"""Pixels."""
RATE: Final = 30
"""Pictures per second."""
BITS: Final = 3_000_000
"""Per second of the video."""
TOGETHER: Final = 15
"""Pictures between two looks at the progress."""


def write_video(recording: Path, file: Path, begin: float, end: float | None, speed: float) -> None:
    """Write a stretch of a recording as WebM (VP9).

    Args:
        recording: The recording.
        file: To write.
        begin: Robot time of the first picture, s.
        end: Of the last; None: the end of the recording.
        speed: Robot time per time of the video.

    Raises:
        ConfigurationError: not a recording, nothing in that stretch, or no Chromium here.
    """
    with _browser() as browser, tempfile.TemporaryDirectory() as folder:
        page_file = Path(folder) / "run.html"
        page_file.write_text(recorded_page([recording])[0], encoding="utf-8")
        page = browser.new_page()
        page.goto(page_file.as_uri())
        page.wait_for_selector("body[data-ready]")
        first, last = page.evaluate("[player.first, player.last]")
        times = np.arange(max(begin, first), last if end is None else min(end, last), speed / RATE)
        if not len(times):
            raise ConfigurationError(f"{recording} goes from {first:g} s to {last:g} s; --from, --to miss it.")
        width, height = SIZE
        options = {"width": width, "height": height, "rate": RATE, "bits": BITS, "theme": "dark"}
        page.evaluate("options => { window.video = new Video(player, options); }", options)
        parts = np.array_split(times, -(-len(times) // TOGETHER))
        pictures = [
            EncodedPicture(round(1e-3 * when), key, base64.b64decode(data))
            for part in track(parts, "drawing", console=Console(stderr=True), transient=True)
            for when, key, data in page.evaluate("times => video.add(times)", part.tolist())
        ]
    write_bytes(file, webm(pictures, SIZE, RATE))


@contextmanager
def _browser() -> Iterator[Any]:
    try:
        from playwright.sync_api import sync_playwright
    except ModuleNotFoundError as error:
        raise ConfigurationError(f"A video needs {error.name}: pip install 'nao-hil[video]'.") from None
    chromium = next((path for name in CHROMIUM if (path := shutil.which(name))), None)
    if chromium is None:
        raise ConfigurationError("A video needs Chromium; on Debian or Ubuntu: apt-get install chromium.")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=list(SOFTWARE))
        yield browser
        browser.close()
