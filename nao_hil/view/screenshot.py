"""The live page as a picture: what the README and docs/view.md show. Needs Chromium and playwright.

`python -m nao_hil.view.screenshot FILE.png [--step 4] [--gait static]`: the walk of the demo, begun when the
page is drawn, because without a graphics card that may take longer than a walk.

`python -m nao_hil.view.screenshot FILE.png --fall frames.mcap`: a recorded fall, at what went wrong first.
"""

from __future__ import annotations

import argparse
import contextlib
import shutil
import socket
import tempfile
from collections.abc import Iterator
from pathlib import Path

from playwright.sync_api import Error, Page, ViewportSize, sync_playwright

from bridge.link import DEFAULT_ROBOT
from bridge.link.walk_client import WalkClient
from nao_hil.runs.supervisor import Child, free_endpoint
from nao_hil.view.export.video import SOFTWARE
from walker.planning import GAITS

SIZE: ViewportSize = {"width": 1120, "height": 700}
TALL: ViewportSize = {"width": 1120, "height": 820}
TIMEOUT = 600_000
"""ms; without a graphics card, and beside other work, drawing takes its time."""
SETTLING = 5_000
"""ms from the first numbers to the walk: meshes and light come last."""
STEPS = 10
"""Of the demo."""


def draw(file: str, step: int, gait: str) -> None:
    """Walk in real time with a page, and take its picture in a step of the ten."""
    port, endpoint = _free_port(), free_endpoint()
    with tempfile.TemporaryDirectory() as folder:
        up = ["up", "--serve", "--view", "--port", str(port), "--listen", endpoint, "--out", folder]
        with _browser(up, Path(folder), port, SIZE) as page:
            page.wait_for_function("document.body.innerText.includes('· stand')")
            page.wait_for_timeout(SETTLING)
            with WalkClient(DEFAULT_ROBOT, endpoint) as walker:
                walker.walk(steps=STEPS, gait=gait)
            page.wait_for_function(f"document.body.innerText.includes('step {step} of {STEPS}')")
            page.screenshot(path=file)


def draw_fall(file: str, recording: str) -> None:
    """Take a picture of a recorded fall at what went wrong first."""
    port = _free_port()
    with tempfile.TemporaryDirectory() as folder:
        view = ["view", "--replay", recording, "--port", str(port)]
        with _browser(view, Path(folder), port, TALL) as page:
            page.get_by_role("tab", name="Timeline").click()
            page.get_by_role("button", name="To what went wrong first").click()
            page.wait_for_function("document.body.innerText.includes('What went wrong first')")
            page.get_by_role("tab", name="Charts").click()
            page.wait_for_timeout(SETTLING)
            page.screenshot(path=file)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def _browser(command: list[str], folder: Path, port: int, size: ViewportSize) -> Iterator[Page]:
    """The page of a command in a browser, its charts drawn."""
    served = Child("served", command, folder)
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=list(SOFTWARE))
            page = browser.new_page(viewport=size)
            page.set_default_timeout(TIMEOUT)
            _open(page, f"http://127.0.0.1:{port}/")
            yield page
            browser.close()
    finally:
        served.end(20.0)


def _open(page: Page, address: str) -> None:
    """Open the page as soon as it is served, and wait for its charts."""
    while True:
        try:
            page.goto(address)
            break
        except Error:
            page.wait_for_timeout(500)
    page.wait_for_selector("svg.charts polyline")
    for notice in page.locator(".mantine-Notification-closeButton").all():
        notice.click()  # of the browser's missing graphics card


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file")
    parser.add_argument("--step", type=int, default=4)
    parser.add_argument("--gait", choices=GAITS, default="static")
    parser.add_argument("--fall", metavar="FILE")
    arguments = parser.parse_args()
    if arguments.fall is not None:
        draw_fall(arguments.file, arguments.fall)
    else:
        draw(arguments.file, arguments.step, arguments.gait)
