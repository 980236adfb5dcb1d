"""The page in a browser where its connection, its keys and its gamepad could move a robot; no robot runs."""

from __future__ import annotations

import contextlib
import json
import socket
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from playwright.sync_api import Page

from bridge.body import load_body
from bridge.messages.guard import GuardStatus
from emulator.robot import EmulatedRobot
from nao_hil.runs.run import CycleBuilder
from nao_hil.view.access import Access
from nao_hil.view.follow import LinkFollower
from nao_hil.view.live_run import LiveRun
from nao_hil.view.orders import Orders
from nao_hil.view.page import page as live_page
from nao_hil.view.server import PageServer
from nao_hil.view.state import describe
from tests.loops import until
from tests.ports import free_port
from tests.proxy import proxy
from tests.system.pages import open_page, retry_until, shown_states, watch_states

pytestmark = pytest.mark.browser

GAMEPAD = """
() => {
  window.pad = { connected: true, axes: [0, 0, 0, 0], buttons: [] };
  navigator.getGamepads = () => [window.pad];
}
"""
NAMELESS = """
() => [...document.querySelectorAll("button, input, select, a, [tabindex]")]
  .filter((e) => !(e.getAttribute("aria-label") || e.title || e.textContent.trim()))
  .filter((e) => !e.closest("label")?.textContent.trim())
  .map((e) => e.outerHTML)
"""


@dataclass
class Served:
    """A page of some seconds of a standing robot; the orders that reach its server."""

    port: int
    folder: Path
    orders: list[dict[str, Any]] = field(default_factory=list)
    armed: bool | None = True
    side: str = "emulator"
    cycles: int = 300

    def open(self) -> PageServer:
        """Serve it."""
        body, builder = load_body("nao-v6"), CycleBuilder()
        server, stop = PageServer("127.0.0.1", self.port, Access()), threading.Event()
        follower = LinkFollower(server, "nao", "tcp/127.0.0.1:1", stop).follower("nao")
        info = SimpleNamespace(body=body.name, sheet="", side=self.side, mode="real-time")
        run = follower._run = LiveRun(info, "robot nao", None)  # type: ignore[arg-type]
        with EmulatedRobot(body, seed=0, engine="mujoco") as robot:
            for _ in range(self.cycles):
                robot.advance(None)
                for message in (robot.frame, robot.truth()):
                    if (cycle := builder.add(message)) is not None:
                        run.take(cycle)
        guard = GuardStatus(seq=1, state="idle", armed=bool(self.armed), text="")
        follower._state = describe(run.newest, None if self.armed is None else guard, None, None, 0.0)
        follower._state["gait"] = "omni"
        follower._orders = Orders(follower._commands, follower._driving, None, body, None)
        server.show(*live_page("a page"))
        server.feed(follower._packed, self.take, lambda _: None)
        return server

    @contextlib.contextmanager
    def shown(self, page: Page) -> Iterator[PageServer]:
        """Serve it, and open it in the browser."""
        server = self.open()
        try:
            open_page(page, self.port)
            yield server
        finally:
            server.close()

    @contextlib.contextmanager
    def driven_by_gamepad(self, page: Page) -> Iterator[PageServer]:
        """The same with a gamepad, `pad` of the page's script, that drives."""
        page.add_init_script(f"({GAMEPAD})()")
        with self.shown(page) as server:
            tab(page, "Walk")
            page.get_by_label("drive by keys and gamepad").check()
            yield server

    def take(self, text: str | bytes) -> tuple[str, bool]:
        """Keep an order."""
        self.orders.append(json.loads(text))
        return "Done.", True


@pytest.fixture
def served(tmp_path: Path) -> Served:
    return Served(free_port(), tmp_path)


def tab(page: Page, name: str) -> None:
    page.get_by_role("tab", name=name).click()


def test_a_lost_page_knows_nothing_of_the_robot_and_its_emergency_stop_says_that_it_did_not_go_out(
    served: Served, page: Page
) -> None:
    server = served.open()
    open_page(page, served.port)
    server._server.shutdown()  # as a process that is killed: without a word
    for browser in list(server._browsers):
        with contextlib.suppress(OSError):
            browser._connection.socket.shutdown(socket.SHUT_RDWR)
    until(lambda: "the robot may still move" in page.inner_text("#state"), "the lost connection")
    assert page.get_by_role("button", name="Walk", exact=True).is_disabled()
    assert page.locator("#robot").is_disabled()  # a choice would be lost
    page.get_by_role("button", name="Emergency stop").click()
    assert "DID NOT GO OUT" in page.inner_text("#toast")
    page.wait_for_timeout(2000)
    assert "ended" not in page.inner_text("body") and "DID NOT GO OUT" in page.inner_text("#toast")
    page.screenshot(path=served.folder / "lost.png")
    again = served.open()
    until(lambda: "the robot may still move" not in page.inner_text("#state"), "the connection")
    until(lambda: page.get_by_role("button", name="Walk", exact=True).is_enabled(), "the orders")
    until(lambda: again.absence < 1.0, "the server to know the page")
    again.close("The end of it.", run=True)
    until(lambda: "the run has ended" in page.inner_text("#state"), "the run's own word")
    assert page.inner_text("#toast") == "The end of it."


def test_a_message_that_the_page_cannot_take_stops_no_later_one(served: Served, page: Page) -> None:
    with served.shown(page) as server:
        state = page.evaluate("player.runs[0].header.live.state")
        server.publish({"state": {}})
        server.publish({"state": state | {"words": "is shown again"}})
        until(lambda: "is shown again" in page.inner_text("#state"), "the later one")


def test_a_connection_that_is_only_silent_counts_as_lost_and_an_unanswered_stop_is_reported(
    served: Served, page: Page
) -> None:
    with served.shown(page):
        watch_states(page)

        def stays_connected() -> bool:
            """For longer than a silence that counts as a loss; a robot that sends nothing is none."""
            page.evaluate("window.states.length = 0")
            page.wait_for_timeout(6000)
            words = [page.inner_text("#state"), *(text for *_, text in shown_states(page))]
            return not any("no connection" in each for each in words)

        until(stays_connected, "six seconds without a loss")

        def stop_in_silence() -> None:
            page.evaluate("() => { player.live.socket.onmessage = () => {}; }")  # as with its cable out
            page.keyboard.press("Escape")

        retry_until(stop_in_silence, lambda: "may not have gone out" in page.inner_text("#toast"), "the report")
        until(lambda: any("the robot may still move" in text for *_, text in shown_states(page)), "the loss")
        until(lambda: "the robot may still move" not in page.inner_text("#state"), "the next connection")


def test_behind_a_proxy_that_changes_host_the_page_says_why_it_is_refused(served: Served, page: Page) -> None:
    server = served.open()
    try:
        with proxy("/nao/", served.port, host=f"127.0.0.1:{served.port}") as address:
            page.goto(address)
            until(lambda: "proxy changed the header Host" in page.inner_text("#toast"), "the refusal")
            page.screenshot(path=served.folder / "refused.png")
    finally:
        server.close()


def test_keys_of_a_control_are_its_own_and_escape_is_the_emergency_stop(served: Served, page: Page) -> None:
    with served.shown(page):
        tab(page, "Walk")
        page.get_by_label("drive by keys and gamepad").check()
        page.keyboard.press("w")
        page.keyboard.press(" ")
        until(lambda: len(served.orders) == 2, "two keys")
        assert [order["key"] for order in served.orders] == ["w", " "]
        page.get_by_label("drive by keys and gamepad").is_checked()
        page.locator("#scene").focus()
        camera = page.evaluate("({...player.camera})")
        for key in ("Shift+ArrowLeft", "Shift+ArrowUp", "+"):
            page.keyboard.press(key)
        turned = page.evaluate("({...player.camera})")
        assert turned["azimuth"] < camera["azimuth"] and turned["elevation"] > camera["elevation"]
        assert turned["distance"] < camera["distance"] and page.evaluate("player.following")
        for control in ("robot time", "steps, 0: no end", "gait"):
            page.get_by_label(control, exact=True).focus()
            page.keyboard.press("ArrowLeft")
            page.keyboard.press("ArrowDown")
        page.get_by_label("steps, 0: no end").fill("")
        page.keyboard.type("wasd")
        page.get_by_role("button", name="Set without walking").focus()
        page.keyboard.press(" ")
        until(lambda: len(served.orders) == 3, "the button's order")
        assert served.orders[-1]["command"]["op"] == "set"
        page.get_by_label("steps, 0: no end").focus()
        page.keyboard.press("Escape")
        until(lambda: len(served.orders) == 4, "the emergency stop")
        assert served.orders[-1] == {"do": "stop", "robot": "nao", "how": "crouch"}
        tab(page, "World")
        page.get_by_role("button", name="head front").focus()
        page.keyboard.down("Enter")
        page.keyboard.up("Enter")
        until(lambda: len(served.orders) == 6, "a press")
        assert [order["command"]["pressed"] for order in served.orders[-2:]] == [True, False]


def test_a_number_that_is_typed_at_a_stand_waits_for_the_button(served: Served, page: Page) -> None:
    with served.shown(page) as server:
        tab(page, "Walk")
        state = page.evaluate("player.runs[0].header.live.state")
        for number in ("0.1", "0.15"):
            page.get_by_label("forward, m/s").fill(number)
            page.keyboard.press("Tab")
            server.publish({"state": state | {"missed": 1}})  # a stand's, of velocity zero
        until(lambda: "cycles missed: 1" in page.inner_text("body"), "the state")
        page.get_by_role("button", name="Walk", exact=True).click()
        until(lambda: served.orders, "the order")
        assert [order["do"] for order in served.orders] == ["walk"]
        assert served.orders[0]["command"]["velocity"] == pytest.approx([0.15, 0.0, 0.0])
        moving = state | {"words": "walks", "walking": True, "velocity": [0.15, 0.0, 0.0]}
        server.publish({"state": moving})
        until(lambda: "walks" in page.inner_text("#state"), "the walk")
        page.get_by_label("forward, m/s").fill("0.2")
        page.keyboard.press("Tab")
        until(lambda: len(served.orders) == 2, "the other velocity")
        assert served.orders[1]["velocity"] == pytest.approx([0.2, 0.0, 0.0])
        server.publish({"state": state})
        until(lambda: float(page.get_by_label("forward, m/s").input_value()) == 0.0, "the field at rest")


def test_every_control_has_a_name_for_a_screen_reader(served: Served, page: Page) -> None:
    with served.shown(page):
        assert page.evaluate(NAMELESS) == []


def test_a_gamepad_drives_by_all_axes_and_its_release_is_a_stop(served: Served, page: Page) -> None:
    with served.driven_by_gamepad(page):
        page.evaluate("pad.axes = [0.5, -1, -1, 0]")
        until(lambda: served.orders, "an order")
        assert served.orders[-1]["do"] == "steer"
        assert served.orders[-1]["velocity"] == pytest.approx([0.4, -0.1, 1.5])
        for release in ("pad.axes = [0.05, 0, 0, 0]", "pad.connected = false", "player.live.driving.click()"):
            page.evaluate("pad.connected = true; pad.axes = [0, -1, 0, 0]")
            until(lambda: served.orders[-1]["velocity"] == [0.4, 0, 0], "the walk")
            page.evaluate(release)
            until(lambda: served.orders[-1]["velocity"] == [0, 0, 0], f"the stop of {release}")


def test_the_past_of_a_live_run_is_marked_and_orders_act_now(served: Served, page: Page) -> None:
    with served.shown(page):
        assert "past" not in page.inner_text("#state")
        page.evaluate("player.goTo(player.last - 1)")
        until(lambda: "the past, 1.0 s ago" in page.inner_text("#state"), "the mark")
        assert page.locator("body.past").count() == 1
        page.screenshot(path=served.folder / "past.png")
        page.get_by_role("button", name="Walk", exact=True).click()
        until(lambda: served.orders, "the order")
        page.get_by_role("button", name="Live").click()
        until(lambda: "past" not in page.inner_text("#state"), "the present")


@pytest.mark.parametrize(("armed", "shown"), [(True, "Walk"), (False, "Arm"), (None, "Walk")])
def test_arm_is_offered_only_by_the_robots_own_word(
    served: Served, page: Page, armed: bool | None, shown: str
) -> None:
    served.armed = armed
    with served.shown(page):
        for name in ("Walk", "Arm"):
            assert page.get_by_role("button", name=name, exact=True).is_visible() == (name == shown)


def test_the_page_of_a_real_robot_has_no_world_and_shows_its_state(served: Served, page: Page) -> None:
    served.side = "naoqi"
    with served.shown(page) as server:
        state = page.evaluate("player.runs[0].header.live.state")
        server.publish({"state": state | {"words": "stands", "holder": "walker"}})
        until(lambda: "stands" in page.inner_text("#state"), "the state")
        tab(page, "Walk")
        until(lambda: "controller: walker" in page.inner_text(".tab[data-name=Walk]"), "the controller")
        assert page.get_by_role("tab", name="World").count() == 0


def test_a_stick_released_without_a_connection_stops_the_robot_once_there_is_one(
    served: Served, page: Page
) -> None:
    with served.driven_by_gamepad(page):
        page.evaluate("pad.axes = [0, -1, 0, 0]")
        until(lambda: served.orders and served.orders[-1]["velocity"] == [0.4, 0, 0], "the walk")
        page.evaluate("() => { player.live.connect = () => {}; player.live.socket.close(); }")
        until(lambda: "the robot may still move" in page.inner_text("#state"), "the lost connection")
        page.evaluate("pad.axes = [0, 0, 0, 0]")
        page.wait_for_timeout(1000)
        page.evaluate("() => { delete player.live.connect; player.live.connect(); }")
        until(lambda: served.orders[-1]["velocity"] == [0, 0, 0], "the stop")


def test_a_stick_stops_the_robot_that_it_moved_when_another_one_is_shown(served: Served, page: Page) -> None:
    with served.driven_by_gamepad(page):
        page.evaluate("pad.axes = [0, -1, 0, 0]")
        until(lambda: served.orders and served.orders[-1]["velocity"] == [0.4, 0, 0], "the walk")
        page.evaluate("() => { player.runs[0].header.name = 'blue'; pad.axes = [0, 0, 0, 0]; }")
        until(lambda: served.orders[-1]["velocity"] == [0, 0, 0], "the stop")
        assert [each["robot"] for each in served.orders if each["velocity"] == [0, 0, 0]] == ["nao"]


def test_controls_show_what_is_in_force_whatever_was_asked_for(served: Served, page: Page) -> None:
    with served.shown(page) as server:
        state = page.evaluate("player.runs[0].header.live.state")
        page.evaluate(
            "() => { player.runs[0].header.names = ['blue', 'nao']; player.live.show(player.runs[0]); }"
        )
        page.select_option("#robot", "blue")
        until(lambda: served.orders and served.orders[-1]["robot"] == "blue", "the order")
        until(lambda: page.input_value("#robot") == "nao", "the robot that is shown")
        tab(page, "World")
        slow = page.get_by_label("slow motion", exact=True)
        slow.select_option("0.25")
        until(lambda: served.orders[-1]["do"] == "slow", "the order")
        until(lambda: slow.input_value() == "1", "the speed in force")
        server.publish({"state": state | {"time_scale": 0.25}})
        until(lambda: slow.input_value() == "0.25", "the slow motion")
        tab(page, "Walk")
        box = page.locator(".pad").first.bounding_box()
        assert box is not None
        page.mouse.move(box["x"] + 75, box["y"] + 20)
        page.mouse.down()
        page.locator(".pad").first.dispatch_event("pointercancel")
        server.publish({"state": state | {"velocity": [0.12, 0.0, 0.0]}})
        until(lambda: page.get_by_label("forward, m/s").input_value() == "0.12", "the velocity in force")
        page.mouse.up()


def test_a_robot_without_a_cycle_has_its_state_and_one_with_other_joints_its_own_ones(
    served: Served, page: Page
) -> None:
    served.cycles = 0
    with served.shown(page):
        until(lambda: "waits for the robot" in page.inner_text("#state"), "the state")
        page.evaluate(
            "() => { const [run] = player.runs; run.header.joints = run.header.joints.slice(2, 5);"
            "player.live.show(run); }"
        )
        tab(page, "World")
        assert page.get_by_label("joint", exact=True).locator("option").count() == 3


def test_all_orders_fit_on_a_phone_with_several_robots(served: Served, page: Page) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    with served.shown(page):
        page.evaluate(
            "() => { player.runs[0].header.names = ['blue', 'nao']; player.live.show(player.runs[0]); }"
        )
        for name in ("Emergency stop", "Emergency stop all", "Walk", "Stop", "Sit"):
            button = page.get_by_role("button", name=name, exact=True)
            button.click(trial=True)
            box = button.bounding_box()
            assert box is not None and box["x"] >= 0.0 and box["x"] + box["width"] <= 390.0, name
        page.screenshot(path=served.folder / "phone.png")


def test_no_walk_begins_by_a_number_that_is_none(served: Served, page: Page) -> None:
    with served.shown(page):
        tab(page, "Walk")
        for label, number in (("steps, 0: no end", "4 or 5"), ("forward, m/s", "")):
            page.get_by_label(label, exact=True).fill(number)
            page.get_by_role("button", name="Walk", exact=True).click()
            until(lambda: "was not sent" in page.inner_text("#toast"), "the refusal")
            page.evaluate("player.live.notify('')")
            page.get_by_label(label, exact=True).fill("0")
        page.get_by_role("button", name="Stop", exact=True).click()
        until(lambda: served.orders and served.orders[-1]["do"] == "key", "the order after them")
        assert "walk" not in [each["do"] for each in served.orders]


def test_a_mark_stays_at_its_time_while_the_run_goes_on(served: Served, page: Page) -> None:
    with served.shown(page) as server:
        last = page.evaluate("player.last")
        server.publish({"events": [{"time": last, "kind": "world", "text": "A push."}], "fall": None})
        until(lambda: page.locator("#marks i").count() == 1, "the mark")
        page.evaluate(
            "() => { const [run] = player.runs, at = (i) => i * run.width;"
            "const row = run.rows.slice(at(run.count - 1), at(run.count)); row[0] += 10; run.append(row); }"
        )
        until(
            lambda: page.evaluate("parseFloat($('marks').firstChild.style.left)") < 50, "the mark in the past"
        )
