"""What others order is shown on the page, and text that is no number is refused; one robot for all tests.

The tests run in their order: each begins where the robot stands, and leaves it there.
"""

from __future__ import annotations

import contextlib
import io
import os
import socket
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import msgpack
import pytest
from PIL import Image
from playwright.sync_api import Page

from bridge.body import load_body
from bridge.link.client import WalkClient
from emulator.shell import lamps
from tests.loops import repeat_while, until
from tests.ports import free_endpoint, free_port
from tests.system.conftest import Command
from tests.system.pages import browser_page, open_page, state, velocity

Start = Callable[..., Any]

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


@dataclass
class Live:
    """A robot that serves, and its page."""

    endpoint: str
    page: Page
    errors: list[str]

    def stands(self) -> None:
        state(self.page, "stands")


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    folder, endpoint, port = tmp_path_factory.mktemp("live"), free_endpoint(), free_port()
    up = ["up", "--serve", "--view", "--engine", "mujoco", "--gait", "omni", "--robot", BODY]
    where = ["--port", str(port), "--listen", endpoint, "--out", str(folder / "run")]
    command, errors = Command([*up, *where], folder, None), list[str]()
    try:
        with browser_page(errors) as page:
            open_page(page, port)
            yield Live(endpoint, page, errors)
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
    assert "stands" in page.inner_text("#state")
    sideways.fill("0.00")
    assert sideways.locator("xpath=following-sibling::span").inner_text() == ""


def test_a_light_of_a_lola_program_shines_in_its_place(start: Start, live: Live, tmp_path: Path) -> None:
    page, path, lamp = live.page, str(tmp_path / "lola"), list(lamps(load_body(BODY))).index("ChestBoard/Led/")
    live.stands()

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
    dark = colour()
    start("serve", "lola", "--socket", path, "--connect", live.endpoint)
    until(lambda: os.path.exists(path), "LoLA's socket")
    with socket.socket(socket.AF_UNIX) as program:
        program.connect(path)
        threading.Thread(target=read_away, args=(program,), daemon=True).start()
        for rgb in ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0)):
            program.sendall(msgpack.packb({"Chest": rgb}, use_single_float=True))
            until(partial(lit, *(int(255 * share) for share in rgb)), f"the light {rgb}", pause=0.2)
        program.sendall(msgpack.packb({"Chest": (0.0, 0.0, 0.0)}, use_single_float=True))
        until(partial(lit, *dark), "darkness", pause=0.2)
