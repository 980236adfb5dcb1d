"""Pictures of the live page, as the documentation shows them. Needs Chromium and playwright.

`python -m nao_hil.view.screenshots docs/images/page`: all ten, at 1280 x 800 and as on a phone, 390 x 844.

`python -m nao_hil.view.screenshots FOLDER --only joints things`: the runs that make these.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from PIL import Image
from playwright.sync_api import Error, Page, ViewportSize, sync_playwright

from nao_hil.runs.supervisor import Child, free_endpoint, free_port
from nao_hil.view.export.video import SOFTWARE

SCREEN: Final[ViewportSize] = {"width": 1280, "height": 800}
PHONE: Final[ViewportSize] = {"width": 390, "height": 844}
TIMEOUT: Final = 600_000
"""ms; without a graphics card, and beside other work, drawing takes its time."""
SETTLING: Final = 3_000
"""ms from a change of the page to its picture: meshes, light and the script's pins come last."""
IMPULSE: Final = ".nao-pad:visible >> xpath=following::input[1]"
"""Field of the pad in the World tab."""
COLOURS: Final = 256
"""Of a picture, so that its file is small."""
PUSH: Final = "[[pushes]]\ntime = 5.0\nimpulse = 5.0\ndirection = 90.0\n"
"""What the recorded robot falls by."""
THINGS: Final = """floor = { roll = 3.0 }

[[boxes]]
name = "plate"
size = [0.12, 0.12, 0.03]
at = [0.25, 0.16]

[[boxes]]
name = "crate"
size = [0.1, 0.1, 0.1]
at = [0.3, -0.2]
mass = 0.2
"""
"""A world in which there is something to see."""


class Photographer:
    """Takes the pictures, run by run.

    Args:
        folder: Where they go.
        work: Of the runs and their recordings.
    """

    def __init__(self, folder: Path, work: Path) -> None:
        self._folder, self._work = folder, work

    def live(self) -> None:
        """A robot that stands, walks, is pushed and falls, on a screen and on a phone."""
        with self._up("--gait", "omni") as page:
            self._take(page, "stand", "Charts")
            press(page, "Walk")
            page.wait_for_function("/step [3-9]/.test(document.body.innerText)")
            pause(page, "Pause")
            self._take(page, "walk", "Walk")
            page.get_by_role("tab", name="World").click()
            page.locator(IMPULSE).fill("0.5 1.5")  # the arrow shows it before it is given
            self._take(page, "push", "World")
            self._take(page, "phone-walk", "Walk", PHONE)  # the panel's width does not come back
            pause(page, "Resume")
            page.locator(IMPULSE).fill("0 5")
            press(page, "Push")
            page.wait_for_function("document.body.innerText.includes('It fell at')")
            self._take(page, "phone-fall", "Charts", PHONE)

    def replay(self) -> None:
        """A recorded fall at what went wrong first, and a walk by day."""
        recording = self._recorded()
        with self._page("· walk", "?t=4.5", ["view", "--replay", str(recording)]) as page:
            page.get_by_role("tab", name="View").click()
            page.get_by_label("dark", exact=True).uncheck()
            self._take(page, "light", "Charts")
            page.get_by_role("tab", name="View").click()
            page.get_by_label("dark", exact=True).check()
            page.get_by_role("tab", name="Timeline").click()
            press(page, "To what went wrong first")
            page.wait_for_function("document.body.innerText.includes('What went wrong first')")
            self._take(page, "fall", "Charts")
            self._take(page, "phone-replay", "Timeline", PHONE)

    def joints(self) -> None:
        """A robot that hangs, its joints at sliders."""
        endpoint = free_endpoint()
        hangs, view = ["emulate", "--start", "hang", "--listen", endpoint], ["view", "--connect", endpoint]
        with self._page(" s", "", hangs, view) as page:
            page.get_by_role("tab", name="Joints").click()
            press(page, "Take the joints")
            page.get_by_text("The page holds the robot").wait_for()
            self._take(page, "joints", "Joints")

    def things(self) -> None:
        """Boxes on a tilted floor."""
        scenario = self._work / "things.toml"
        scenario.write_text(THINGS)
        with self._up("--scenario", str(scenario)) as page:
            self._take(page, "things", "World")

    def _recorded(self) -> Path:
        """A walk and its fall."""
        scenario = self._work / "push.toml"
        scenario.write_text(PUSH)
        run = self._work / "recorded"
        walk = ["--gait", "omni", "--steps", "30", "--mode", "lockstep", "--scenario", str(scenario)]
        up = [sys.executable, "-m", "nao_hil.cli", "up", *walk, "--listen", free_endpoint(), "--out", str(run)]
        subprocess.run(up, check=False, stdout=subprocess.DEVNULL)  # it falls, and so ends with 1
        return run / "frames.mcap"

    def _up(self, *options: str) -> contextlib.AbstractContextManager[Page]:
        """The page of a robot that stands."""
        run = Path(tempfile.mkdtemp(dir=self._work))
        up = ["up", "--serve", "--view", "--listen", free_endpoint(), "--out", str(run), *options]
        return self._page("· stand", "", up)

    def _take(self, page: Page, name: str, tab: str, size: ViewportSize = SCREEN) -> None:
        page.set_viewport_size(size)
        page.get_by_role("tab", name=tab).click()
        page.wait_for_timeout(SETTLING)
        picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        picture = picture.quantize(COLOURS, kmeans=2)
        picture.save(self._folder / f"{name}.png", optimize=True)
        print(self._folder / f"{name}.png", flush=True)

    @contextlib.contextmanager
    def _page(self, ready: str, query: str, *commands: list[str]) -> Iterator[Page]:
        """The page of the last of some commands in a browser, once these words are on it."""
        port = free_port()
        served = []
        try:
            for i, command in enumerate(commands):
                last = ["--port", str(port)] if i + 1 == len(commands) else []
                served.append(Child(f"command-{i}", [*command, *last], self._work))
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(
                    executable_path=shutil.which("chromium"), args=list(SOFTWARE)
                )
                page = browser.new_page(viewport=SCREEN)
                page.set_default_timeout(TIMEOUT)
                _open(page, f"http://127.0.0.1:{port}/{query}")
                page.wait_for_function("words => document.body.innerText.includes(words)", arg=ready)
                yield page
                browser.close()
        finally:
            for child in reversed(served):
                child.end(20.0)


def press(page: Page, button: str) -> None:
    """Click a button by its label."""
    page.get_by_role("button", name=button, exact=True).click()


def pause(page: Page, button: str) -> None:
    """Pause or resume: a browser that draws in software shows lines later than meshes."""
    page.get_by_role("tab", name="World").click()
    press(page, button)


def _open(page: Page, address: str) -> None:
    """Open the page as soon as it is served, and wait for its charts."""
    while True:
        try:
            page.goto(address)
            break
        except Error:
            page.wait_for_timeout(500)
    page.wait_for_selector(".uplot canvas")
    for notice in page.locator(".mantine-Notification-closeButton").all():
        notice.click()  # of the browser's missing graphics card


RUNS: Final = ("live", "replay", "joints", "things")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="+", choices=RUNS, default=RUNS, metavar="RUN", help=", ".join(RUNS))
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        photographer = Photographer(arguments.folder, Path(place))
        for name in arguments.only:
            getattr(photographer, name)()
