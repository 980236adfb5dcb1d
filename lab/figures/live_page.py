"""The live page of the default demo as a picture: what the README shows. Needs Chromium and playwright.

`python -m lab.figures.live_page FILE.png [--at 15] [--steps 10]`
"""

from __future__ import annotations

import argparse
import shutil
import socket
import tempfile
from pathlib import Path

from playwright.sync_api import Error, Page, sync_playwright

from lab.bench.lateness import free_endpoint
from lab.supervisor import Child

SIZE = {"width": 1120, "height": 700}
PATIENCE = 600_000
"""ms; without a graphics card, and beside other work, drawing takes its time."""
SETTLING = 5_000
"""ms from the first numbers to the picture: meshes and light come last."""
SOFTWARE = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def draw(file: str, at: float, steps: int) -> None:
    """Walk in real time with a page, and take its picture at a robot time of `at` s or later."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    with tempfile.TemporaryDirectory() as folder:
        up = ["up", "--view", "--port", str(port), "--listen", free_endpoint(), "--steps", str(steps)]
        demo = Child("demo", [*up, "--out", folder], Path(folder))
        try:
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=SOFTWARE)
                page = browser.new_page(viewport=SIZE)
                page.set_default_timeout(PATIENCE)
                _open(page, f"http://127.0.0.1:{port}/")
                page.get_by_role("tab", name="View").click()
                page.wait_for_function(
                    f"parseFloat((document.body.innerText.match(/· ([\\d.]+) s/) || [0, 0])[1]) > {at}"
                )
                page.wait_for_timeout(SETTLING)
                page.screenshot(path=file)
                browser.close()
        finally:
            demo.end(20.0)


def _open(page: Page, address: str) -> None:
    """Open the page as soon as it is served, and wait for its charts."""
    while True:
        try:
            page.goto(address)
            break
        except Error:
            page.wait_for_timeout(500)
    page.wait_for_selector("svg.charts polyline")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file")
    parser.add_argument("--at", type=float, default=15.0)
    parser.add_argument("--steps", type=int, default=10)
    arguments = parser.parse_args()
    draw(arguments.file, arguments.at, arguments.steps)
