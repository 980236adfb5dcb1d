"""The live page in a headless browser: `make browser-test`, which needs Chromium on the machine."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page

from bridge.body import load_body
from bridge.recording.playback import read_recording
from bridge.recording.recorder import Recorder
from emulator.robot import EmulatedRobot
from nao_hil.runs.config import RunConfig
from nao_hil.runs.monitor import Monitor
from nao_hil.view.access import Access
from nao_hil.view.page import page as live_page
from nao_hil.view.server import PageServer
from tests.loops import until
from tests.proxy import proxy
from tests.system.pages import open_page, press, retry_until, state, velocity

Start = Callable[..., Any]

SIZES = [(1280, 800), (390, 844)]

pytestmark = pytest.mark.browser


def shows(page: Page, words: str) -> bool:
    """Whether the robot's state is this."""
    return words in page.inner_text("#state")


def check_in_sight(page: Page, *buttons: str) -> None:
    """Nothing covers these buttons, nor the emergency stop and the tabs; nothing is wider than the screen."""
    shown = [page.get_by_role("button", name=name, exact=True) for name in ("Emergency stop", *buttons)]
    for each in [*shown, *page.get_by_role("tab").all()]:
        each.click(trial=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= page.evaluate("innerWidth")


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_walk_push_fall_reset_and_emergency_stop(
    start: Start,
    endpoint: str,
    port: int,
    tmp_path: Path,
    page: Page,
    errors: list[str],
    width: int,
    height: int,
) -> None:
    run = tmp_path / "run"
    up = ["up", "--serve", "--view", "--engine", "mujoco", "--gait", "omni", "--no-recover"]
    start(*up, "--port", str(port), "--listen", endpoint, "--out", str(run))
    page.set_viewport_size({"width": width, "height": height})
    open_page(page, port)
    state(page, "stands")
    check_in_sight(page, "Walk", "Stop", "Sit")

    page.get_by_role("button", name="Walk", exact=True).click()
    state(page, "walks · step")
    page.get_by_role("tab", name="Walk").click()
    until(lambda: velocity(page)[0] > 0.05, "the velocity in force")  # ordered by a button, not by the pad
    page.get_by_label("forward, m/s").fill("fast")
    assert (
        page.get_by_label("forward, m/s").locator("xpath=following-sibling::span").inner_text()
        == "not a number"
    )
    page.get_by_label("forward, m/s").fill("0.1")
    page.keyboard.press("Tab")
    until(lambda: math.isclose(velocity(page)[0], 0.1, abs_tol=0.02), "the velocity that was typed")
    page.get_by_role("button", name="Stop", exact=True).click()
    state(page, "stands")
    until(lambda: velocity(page) == [0.0, 0.0, 0.0], "the pad at rest")

    before = page.evaluate("player.last")
    page.evaluate("player.goTo(player.last - 2)")
    still = page.evaluate("player.time")
    until(lambda: page.evaluate("player.last") > before, "the run to go on")
    assert page.evaluate("player.time") == still and not page.evaluate("player.following")
    page.get_by_role("button", name="Live").click()
    assert page.evaluate("player.following")

    page.get_by_role("tab", name="World").click()
    page.get_by_label("to the left, N s").fill("6")
    page.get_by_role("button", name="Push", exact=True).click()
    until(lambda: "It fell at" in page.inner_text("#fell"), "the verdict")
    state(page, "lies on its")
    press(page, "World", "Reset")
    state(page, "stands")
    assert page.locator("#fell").is_hidden()
    page.get_by_role("tab", name="Run").click()
    page.get_by_role("button", name="Look for recordings").click()
    until(lambda: page.get_by_role("link", name="recording").count() == 2, "both recordings")
    with page.expect_download() as download:
        page.get_by_role("link", name="recording").first.click()
    assert sum(r.topic == "sensors" for r in read_recording(Path(download.value.path()))) > 100

    stop = page.get_by_role("button", name="Emergency stop")
    retry_until(stop.click, partial(shows, page, "emergency stop"), "the stop")
    page.get_by_role("button", name="Arm", exact=True).wait_for()
    check_in_sight(page, "Arm")
    assert errors == []


def test_the_buttons_of_the_body_are_pressed_while_held_and_keys_drive_once_they_may(
    start: Start, endpoint: str, port: int, tmp_path: Path, page: Page, errors: list[str]
) -> None:
    run = tmp_path / "run"
    up = ["up", "--serve", "--view", "--engine", "mujoco", "--gait", "static", "--port", str(port)]
    command = start(*up, "--listen", endpoint, "--out", str(run))
    open_page(page, port)
    state(page, "stands")
    page.get_by_role("tab", name="World").click()
    page.get_by_role("button", name="head front").hover()
    page.mouse.down()
    page.get_by_text("head_front").first.wait_for()
    page.mouse.up()
    page.locator("#scene").hover()
    page.keyboard.press("w")  # not allowed yet
    page.get_by_role("tab", name="Walk").click()
    page.get_by_label("drive by keys and gamepad").check()
    for key, words in (("w", "walks"), ("x", "stands")):
        retry_until(partial(page.keyboard.press, key), partial(shows, page, words), f"the state `{words}`")
    events = page.locator("#events").text_content() or ""
    assert "Walks by the static gait" in events and "Closes the feet" in events
    assert errors == []
    command.interrupt()
    page.get_by_text("has ended the run").wait_for()
    touch = [r.message.touch for r in read_recording(run / "frames.mcap") if r.topic == "sensors"]
    assert {frame[1] for frame in touch} == {0.0, 1.0} and touch[-1][1] == 0.0


@pytest.mark.realtime
@pytest.mark.parametrize("way", ["button", "pad"])
def test_a_robot_stops_within_three_seconds_of_its_last_page(
    start: Start, endpoint: str, port: int, page: Page, way: str
) -> None:
    start("emulate", "--engine", "mujoco", "--listen", endpoint)
    start("walk", "--serve", "--connect", endpoint)
    start("view", "--connect", endpoint, "--port", str(port))
    open_page(page, port)
    state(page, "stands")
    page.get_by_role("button", name="Walk", exact=True).click()
    state(page, "walks · step")
    if way == "pad":
        page.get_by_role("tab", name="Walk").click()
        page.get_by_label("forward, m/s").fill("0.1")
        page.keyboard.press("Tab")
        until(lambda: math.isclose(velocity(page)[0], 0.1, abs_tol=0.02), "the velocity that was typed")
    page.wait_for_timeout(5000)
    state(page, "walks · step")  # for as long as the page is open
    with Monitor("nao", endpoint) as monitor:
        until(lambda: monitor.connect() and monitor.telemetry and monitor.sensors, "robot and walker")
        page.close()
        assert monitor.sensors is not None
        closed = monitor.sensors.time
        until(lambda: monitor.telemetry and monitor.telemetry.state != "walk", "the stop")
        assert monitor.sensors.time < closed + 3.0


def test_another_run_begins_from_the_page(
    start: Start, endpoint: str, port: int, tmp_path: Path, page: Page, errors: list[str]
) -> None:
    up = ["up", "--serve", "--view", "--engine", "mujoco", "--port", str(port), "--listen", endpoint]
    start(*up, "--out", str(tmp_path / "run"))
    open_page(page, port)
    state(page, "stands")
    page.get_by_role("tab", name="Run").click()
    page.get_by_label("robot", exact=True).select_option("nao-v6")
    page.get_by_label("scenario", exact=True).select_option("boxes")
    page.get_by_role("button", name="Restart").click()
    until(lambda: "nao-v6" in page.inner_text("#subtitle"), "the other robot")
    state(page, "stands")
    until(lambda: page.evaluate("player.runs[0].header.objects.length") > 0, "the boxes")
    assert errors == []


def test_a_killed_robot_is_said_to_be_silent(
    start: Start, endpoint: str, port: int, page: Page, errors: list[str]
) -> None:
    robot = start("emulate", "--engine", "mujoco", "--listen", endpoint)
    until(lambda: "; recording to" in robot.stderr or "listen" in robot.stderr, "the robot")
    start("view", "--connect", endpoint, "--port", str(port))
    open_page(page, port)
    state(page, "free, joints left alone")
    robot.kill()
    state(page, "no word from the robot")


CONNECT = """
(address) => new Promise((done) => {
  const socket = new WebSocket(address);
  socket.onopen = () => done("open");
  socket.onerror = () => done("refused");
})
"""


def test_another_site_in_the_same_browser_cannot_connect(
    start: Start, port: int, tmp_path: Path, page: Page
) -> None:
    recording = tmp_path / "frames.mcap"
    with EmulatedRobot(load_body("nao-v3"), seed=0) as robot, Recorder(recording, RunConfig()) as recorder:
        recorder.sensors(robot.frame, robot.truth())
    start("view", "--replay", str(recording), "--port", str(port))
    open_page(page, port)
    own = f"ws://127.0.0.1:{port}/"
    assert page.evaluate(CONNECT, own) == "open"
    for site in ("http://evil.example/", f"http://localhost:{port}/"):
        page.route("http://evil.example/", lambda route: route.fulfill(body="<p>another site"))
        page.goto(site)
        assert page.evaluate(CONNECT, own) == "refused"


def test_the_page_works_under_a_path_of_a_proxy(port: int, page: Page, errors: list[str]) -> None:
    server = PageServer("127.0.0.1", port, Access())
    server.show(*live_page("behind a proxy"))
    try:
        with proxy("/nao/", port) as address:
            page.goto(address)
            until(lambda: page.wait_for_timeout(100) or server.absence < 1.0, "the page to connect")
    finally:
        server.close()
