"""The page shows the state that the robot reports, each sentence of it on one robot and in one browser.

The tests run in their order: each begins where the robot stands, and leaves it there.
"""

from __future__ import annotations

import contextlib
import io
import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import msgpack
import pytest
from PIL import Image
from playwright.sync_api import Page

from bridge.body import load_body
from bridge.link import keys
from bridge.link.client import WalkClient, WorldClient
from bridge.link.session import open_client, subscribe
from bridge.messages import SensorFrame, decode
from bridge.messages.guard import GuardStatus
from bridge.messages.walk import WalkCommand
from bridge.messages.world import Push, Reset
from emulator.shell import lamps
from nao_hil.connection import connect
from tests.loops import repeat_while, until
from tests.ports import free_endpoint, free_port
from tests.system.conftest import Command
from tests.system.pages import (
    browser_page,
    open_page,
    press,
    retry_until,
    shown_states,
    state,
    velocity,
    watch_states,
)

Start = Callable[..., Any]

LATEST = 3.0
"""s of the robot's time from its report to the page, which was 2 s on a machine that was busy."""
BODY = "nao-v6"
LAMP = """
(i) => {
  const { scene } = player, [actor] = player.actors(), { link, at: [x, y, z] } = actor.run.header.lamps[i];
  scene.place(actor);
  const m = scene.frames.subarray(16 * link, 16 * link + 16);
  return scene.project([0, 1, 2].map((k) => m[k] * x + m[4 + k] * y + m[8 + k] * z + m[12 + k]));
}
"""
"""Place of a lamp in the picture, pixels."""

pytestmark = pytest.mark.browser


class Report(NamedTuple):
    """A report of the guard."""

    at: float
    """Arrival, s since 1970."""
    time: float
    """Of the robot's newest frame then, s."""
    status: GuardStatus


@dataclass
class Live:
    """A robot that serves, its page, and the reports of its guard as they come."""

    command: Command
    endpoint: str
    page: Page
    errors: list[str]
    reports: list[Report] = field(default_factory=list)
    time: float = 0.0
    """Of the robot's newest frame, s."""

    def hear(self, data: bytes) -> None:
        """The robot's next frame."""
        self.time = decode(data, SensorFrame).time

    def hear_report(self, data: bytes) -> None:
        """The next report of its guard."""
        self.reports.append(Report(time.time(), self.time, decode(data, GuardStatus)))

    def reported(self, name: str, since: float) -> Report | None:
        """The first report of a state of the guard."""
        return next((each for each in self.reports if each.at >= since and each.status.state == name), None)

    @property
    def holder(self) -> str | None:
        """Who has the robot by its newest report; None: it has not reported a change yet."""
        return self.reports[-1].status.holder if self.reports else None

    def shown(self, words: str, since: float) -> float | None:
        """Robot time up to which the page had the run as it first showed these words."""
        states = shown_states(self.page)
        return next((time for at, time, text in states if at >= since and words in text), None)

    def shows(self, words: str, name: str, since: float) -> None:
        """The page shows the words of a state of the guard soon after its report."""
        reported = until(lambda: self.reported(name, since), f"the report `{name}`")
        until(lambda: self.shown(words, since) is not None, f"the state `{words}`", pause=0.1)
        self.check_shown(words, since, reported)

    def check_shown(self, words: str, since: float, reported: Report) -> None:
        """The page has shown these words soon after a report."""
        shown = self.shown(words, since)
        assert shown is not None
        late = shown - reported.time
        assert late < LATEST, f"`{words}` {late:.2f} s after the report"

    def stands(self) -> None:
        state(self.page, "stands")

    def reset(self) -> None:
        """Reset the world; it stands again, and the page shows that."""
        before = self.page.evaluate("player.last")
        with WorldClient(connect=self.endpoint) as world:
            world.send(Reset())
        until(lambda: self.page.evaluate("player.last") < before, "the time to begin again", pause=0.02)
        self.stands()


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    folder, endpoint, port = tmp_path_factory.mktemp("live"), free_endpoint(), free_port()
    up = ["up", "--serve", "--view", "--engine", "mujoco", "--gait", "omni", "--robot", BODY]
    where = ["--port", str(port), "--listen", endpoint, "--out", str(folder / "run")]
    command, errors = Command([*up, *where], folder, None), list[str]()
    try:
        with browser_page(errors) as page:
            open_page(page, port)
            watch_states(page)
            shown = Live(command, endpoint, page, errors)
            with open_client(endpoint) as session:
                subscribers = [
                    subscribe(session, keys.topic_key(keys.DEFAULT_ROBOT, SensorFrame), shown.hear),
                    subscribe(session, keys.key(keys.DEFAULT_ROBOT, keys.GUARD), shown.hear_report),
                ]
                yield shown
                del subscribers
            assert errors == []
    finally:
        command.end()


def test_a_velocity_is_shown_whoever_ordered_it(live: Live) -> None:
    page = live.page
    live.stands()
    page.get_by_role("tab", name="Walk").click()
    with WalkClient(connect=live.endpoint) as walker:
        walker.walk((0.1, 0.0, 0.2))
        until(lambda: velocity(page) == pytest.approx([0.1, 0.0, 0.2], abs=0.02), "the velocity of another")
        assert float(page.get_by_label("forward, m/s").input_value()) == pytest.approx(0.1, abs=0.02)
        knob, strip = page.locator(".tab:not([hidden]) .pad b").all()
        assert float(knob.evaluate("(b) => parseFloat(b.style.top)")) < 45.0  # above the middle: ahead
        assert float(strip.evaluate("(b) => parseFloat(b.style.left)")) < 50.0
        walker.stop()
    live.stands()
    until(lambda: velocity(page) == [0.0, 0.0, 0.0], "the pad at rest")


@pytest.mark.parametrize("text", ["fast", "", "1e9", "0x1", "--", "9999"])
def test_text_that_is_no_number_is_refused_beside_the_field_and_not_sent(live: Live, text: str) -> None:
    page = live.page
    live.stands()
    page.get_by_role("tab", name="Walk").click()
    sideways = page.get_by_label("to the left, m/s").first
    sideways.fill(text)
    refusal = sideways.locator("xpath=following-sibling::span").inner_text()
    assert refusal == ("-10 to 10" if text == "9999" else "not a number")
    page.keyboard.press("Tab")
    page.wait_for_timeout(300)
    live.stands()
    sideways.fill("0.00")
    assert sideways.locator("xpath=following-sibling::span").inner_text() == ""


def test_a_light_of_a_lola_program_shines_in_its_place(start: Start, live: Live, tmp_path: Path) -> None:
    page, path, lamp = live.page, str(tmp_path / "lola"), list(lamps(load_body(BODY))).index("ChestBoard/Led/")
    live.stands()
    live.reset()  # it faces the viewer again, wherever it has walked

    def colour() -> tuple[int, ...]:
        """Of the picture where the lamp is."""
        x, y = page.evaluate(LAMP, lamp)
        picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        return tuple(picture.getpixel((round(x), round(y))))

    def lit(*rgb: int) -> bool:
        """Whether the lamp is as bright as that."""
        return all(abs(a - b) < 90 for a, b in zip(colour(), rgb, strict=True))

    def read_away(program: socket.socket) -> None:
        """A program that does not read is given up."""
        with contextlib.suppress(OSError):
            for _ in repeat_while(lambda: program.recv(1 << 16), limit=1 << 20):
                pass

    page.evaluate("Object.keys(player.overlays).forEach((name) => (player.overlays[name] = false))")
    drawn = page.evaluate("player.pictures")
    until(lambda: page.evaluate("player.pictures") > drawn + 1, "pictures of it as it stands now")
    dark = colour()
    start("serve", "lola", "--socket", path, "--connect", live.endpoint)
    until(lambda: os.path.exists(path), "LoLA's socket")
    with socket.socket(socket.AF_UNIX) as program:
        program.connect(path)
        threading.Thread(target=read_away, args=(program,), daemon=True).start()

        def shines(rgb: tuple[float, ...], seen: tuple[int, ...]) -> bool:
            """After another packet, as programs send one in each cycle."""
            program.sendall(msgpack.packb({"Chest": rgb}, use_single_float=True))
            return lit(*seen)

        for rgb in ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0)):
            seen = tuple(int(255 * share) for share in rgb)
            until(partial(shines, rgb, seen), f"the light {rgb}", pause=0.1)
        until(partial(shines, (0.0, 0.0, 0.0), dark), "darkness", pause=0.1)


@pytest.mark.realtime
def test_an_emergency_stop_is_shown_as_it_is_carried_out_and_the_robot_stands_up_again(live: Live) -> None:
    live.stands()
    began = time.time()
    stop = live.page.get_by_role("button", name="Emergency stop")
    retry_until(stop.click, lambda: live.reported("crouch", began), "the stop")
    live.shows("crouching, emergency stop", "crouch", began)
    live.shows("limp, emergency stop", "rest", began)
    live.page.get_by_role("button", name="Arm", exact=True).click()
    live.stands()
    events = live.page.locator("#events").text_content() or ""
    assert "Emergency stop (crouch) by page" in events
    assert "The robot was armed by page" in events


@pytest.mark.realtime
def test_a_robot_of_another_controller_is_shown_as_held_by_it(live: Live) -> None:
    live.stands()
    began = time.time()
    with WalkClient(connect=live.endpoint) as walker:
        walker.send(WalkCommand(op="release"))
        until(lambda: live.holder == "", "that the walker lets go")
        with connect(live.endpoint, name="other") as robot:
            pose = robot.frame.position
            for _ in repeat_while(lambda: live.shown("held by other", began) is None, limit=1000):
                robot.step(pose)
        walker.send(WalkCommand(op="take"))
    reports = (each for each in live.reports if each.at >= began and each.status.holder == "other")
    # in other states it says what it does
    held = next(each for each in reports if each.status.state in ("idle", "active"))
    live.check_shown("held by other", began, held)
    live.stands()


@pytest.mark.realtime
def test_a_fall_is_shown_and_its_headline_goes_once_the_robot_stands(live: Live) -> None:
    live.stands()
    page, began = live.page, time.time()
    with WorldClient(connect=live.endpoint) as world:
        world.send(Push(impulse=(-6.0, 0.0, 0.0)))
    until(lambda: live.shown("lies on its back", began) is not None, "the fall", pause=0.1)
    until(lambda: live.shown("It fell at", began) is not None, "its headline", pause=0.1)
    until(lambda: live.shown("gets up, lies on its", began) is not None, "that it gets up", pause=0.1)
    live.stands()
    until(lambda: page.locator("#fell").is_hidden(), "the headline to go")


@pytest.mark.realtime
def test_a_reset_is_shown_and_its_recording_is_offered(live: Live) -> None:
    live.stands()
    page = live.page
    page.get_by_role("tab", name="Run").click()
    names = page.locator(".tab:not([hidden]) .field", has_text="MB")

    def offered() -> list[str]:
        return [text.split(",")[0] for text in names.all_inner_texts()]

    earlier = list(page.evaluate("fetch('recordings').then((answer) => answer.json())"))
    live.reset()
    look = page.get_by_role("button", name="Look for recordings")
    retry_until(
        look.click, lambda: offered() == [*earlier, f"run/frames-{1 + len(earlier)}"], "the next recording"
    )


@pytest.mark.realtime
def test_a_killed_walker_is_reported_and_another_one_takes_the_robot(live: Live) -> None:
    live.stands()
    page, began = live.page, time.time()
    (walker,) = live.command.children_with("walk")
    os.kill(walker, signal.SIGKILL)
    live.shows("holds its pose: its controller is silent", "hold", began)
    page.get_by_text("The walker ended: it was killed by SIGKILL. A new one starts").wait_for()
    until(lambda: live.holder == "walker", "that the new walker has the robot")
    live.stands()
    press(page, "Walk", "Walk")
    state(page, "walks")
    until(lambda: page.locator("#notice").is_hidden(), "the report to go")
    page.get_by_role("button", name="Stop", exact=True).click()
    live.stands()
