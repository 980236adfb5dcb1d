"""Pictures of the page, as the documentation shows them. Needs Chromium and playwright.

`python -m tests.docs.screenshots docs/images/page`: all, at 1280 x 800 and as on a phone, 390 x 844.

`python -m tests.docs.screenshots FOLDER --only replay`: the runs that make these.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from PIL import Image
from playwright.sync_api import Page

from bridge.link.client import WorldClient
from bridge.messages.world import PlaceObject
from nao_hil.runs.supervisor import Child
from tests.ports import free_endpoint, free_port
from tests.system.pages import browser_page, open_page

SCREEN: Final = (1280, 800)
PHONE: Final = (390, 844)
TIMEOUT: Final = 600_000
"""ms; without a graphics card, and with other work, drawing takes its time."""
SETTLING: Final = 4_000
"""ms from a change of the page to its picture."""
COLOURS: Final = 256
"""Colours of a picture, so that its file is small."""
FALL: Final = "[[pushes]]\ntime = 5.0\nimpulse = 6.0\ndirection = 90.0\n"
"""Push that fells the recorded robot."""
WORLD: Final = """
[[robots]]
name = "red"
robot = "nao-v6"
at = [-0.6, 0.5]

[[robots]]
name = "blue"
robot = "nao-v6"
at = [0.7, 0.0]
yaw = 180.0

[[robots]]
name = "green"
robot = "nao-v6"
at = [1.2, -1.0]
yaw = 150.0
"""
BALL: Final = PlaceObject(
    name="ball", shape="ball", size=(0.1, 0.1, 0.1), mass=0.044, at=(0.1, 0.0), frame="floor"
)
WALK: Final = ("--robot", "nao-v6", "--engine", "mujoco", "--gait", "omni")


class Photographer:
    """Takes the pictures, run by run.

    Args:
        folder: Of the pictures.
        work: Of the runs and their recordings.
    """

    def __init__(self, folder: Path, work: Path) -> None:
        self._folder, self._work = folder, work

    def live(self) -> None:
        """A robot that stands, walks, is pushed, falls, gets up and is stopped."""
        up = ["up", "--serve", "--view", *WALK, "--listen", free_endpoint(), "--out", str(self._work / "live")]
        with self._served(up) as page:
            _state(page, "stands")
            self._shoot(page, "stand", "Charts")
            _press(page, "Walk")
            _state(page, "step")
            self._shoot(page, "walk", "Walk")
            self._shoot(page, "phone-walk", "Walk", PHONE)
            page.get_by_role("tab", name="World").click()
            page.get_by_label("to the left, N s").fill("0.8")
            _press(page, "Push")
            self._shoot(page, "push", "World")
            page.get_by_label("to the left, N s").fill("6")
            _press(page, "Push")
            _state(page, "lies")
            self._shoot(page, "live-fall", "Charts")
            _press(page, "Stop")
            _state(page, "stands")
            self._shoot(page, "got-up", "Events")
            _press(page, "Emergency stop")
            _state(page, "limp")
            self._shoot(page, "stop", "Run")

    def world(self) -> None:
        """Three robots and a ball on a field; the second one is chosen."""
        endpoint = free_endpoint()
        file = self._work / "world.toml"
        file.write_text(WORLD)
        emulate = ["emulate", "--world", str(file), "--scenario", "field", "--engine", "mujoco"]
        where = ["--listen", endpoint, "--out", str(self._work / "world")]
        robots = Child("world", [*emulate, *where], self._work)
        try:
            with self._served(["view", "--connect", endpoint]) as page:
                page.get_by_label("robot that is shown").select_option("blue")
                page.get_by_text("robot blue", exact=True).wait_for()
                page.evaluate("Object.assign(player.camera, { distance: 4.4, elevation: 0.42, azimuth: -2.0 })")
                with WorldClient("blue", endpoint) as client:
                    client.send(BALL)
                self._shoot(page, "world", "World")
        finally:
            robots.end(20.0)

    def replay(self) -> None:
        """A recorded fall at its first sign, on dark and light pages, the estimate, and two runs."""
        walk, fall = self._recorded("walk"), self._recorded("fall", FALL)
        with self._served(["view", "--replay", str(fall)]) as page:
            page.evaluate("player.goTo(player.runs[0].header.fall.time + 0.05)")
            self._shoot(page, "fall", "Charts")
            self._shoot(page, "phone-replay", "Charts", PHONE)
            page.evaluate("player.goTo(4.0), $('theme').click()")
            page.get_by_role("button", name="Legend").click()
            page.get_by_label("estimated pose").check()
            self._shoot(page, "light", "Joints")
        with self._served(["view", "--replay", str(walk), "--replay", str(fall)]) as page:
            page.evaluate("player.goTo(5.2)")
            self._shoot(page, "two", "Charts")
            self._shoot(page, "two-differences", "Differences")

    def _recorded(self, name: str, scenario: str = "") -> Path:
        """A walk, in a world of its own."""
        options = [*WALK, "--steps", "30", "--mode", "in-process", "--out", str(self._work / name)]
        if scenario:
            (self._work / f"{name}.toml").write_text(scenario)
            options += ["--scenario", str(self._work / f"{name}.toml")]
        command = [sys.executable, "-m", "nao_hil.cli", "up", *options]
        subprocess.run(command, check=False, stdout=subprocess.DEVNULL)  # one falls, and so ends with 1
        return self._work / name

    def _shoot(self, page: Page, name: str, tab: str, size: tuple[int, int] = SCREEN) -> None:
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.get_by_role("tab", name=tab).click()
        page.wait_for_timeout(SETTLING)
        picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        picture.quantize(COLOURS, kmeans=2).save(self._folder / f"{name}.png", optimize=True)
        print(self._folder / f"{name}.png", flush=True)
        page.set_viewport_size({"width": SCREEN[0], "height": SCREEN[1]})

    @contextlib.contextmanager
    def _served(self, command: list[str]) -> Iterator[Page]:
        """The page of a command in a browser, once it shows a robot."""
        port = free_port()
        served = Child("page", [*command, "--port", str(port)], self._work)
        try:
            with browser_page([]) as page:
                page.set_default_timeout(TIMEOUT)
                page.emulate_media(color_scheme="dark")
                open_page(page, port)
                page.evaluate("player.adaptive = false, player.scene.sharpness = 1")
                yield page
        finally:
            served.end(20.0)


def _press(page: Page, button: str) -> None:
    page.get_by_role("button", name=button, exact=True).click()


def _state(page: Page, words: str) -> None:
    """Wait until the robot's state is this."""
    page.locator("#state", has_text=words).wait_for()


RUNS: Final[tuple[Any, ...]] = ("live", "world", "replay")


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
