"""Orders of the page, walks that it keeps alive, and joints that it holds."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.body.joints import INDEX, JOINTS
from bridge.errors import LinkError
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.messages.world import Pause, Press, Push, Resume, Step
from nao_hil.drive.driver import HOLD
from nao_hil.view.follow import LEARNED
from nao_hil.view.orders import (
    ABSENCE_TIMEOUT,
    JOINT_RATE,
    Driving,
    Hand,
    Orders,
    SlowMotion,
)
from tests.loops import TIMEOUT, until
from tests.nao_hil.view.conftest import BODY, STATUS, FakeCommands


def test_orders_become_the_links_own_commands(
    order: Callable[..., tuple[str, bool]], commands: FakeCommands
) -> None:
    assert order("world", command={"op": "push", "impulse": [-0.5, 2, 0]}) == ("Done.", True)
    assert order("world", command={"op": "press", "button": "head_front", "pressed": True}) == ("Done.", True)
    assert order("walk", command={"op": "walk", "torso": "robust", "steps": 0}) == ("It walks.", True)
    assert order("stop", how="crouch") == ("It goes down.", True)
    push, press, walk = commands.sent
    assert isinstance(push, Push) and push.impulse == (-0.5, 2.0, 0.0)
    assert press == Press(button="head_front", pressed=True)
    assert walk == WalkCommand(op="walk", torso="robust", steps=0, hold=HOLD)


@pytest.mark.parametrize(
    ("doing", "fields", "sentence"),
    [
        ("fly", {}, "no order of the page"),
        ("world", {"command": {"op": "push", "impulse": ["x", 0, 0]}}, "no order of the page"),
        ("steer", {"velocity": [float("nan"), 0, 0]}, "no order of the page"),
        ("joints", {"angles": {"LKneePitch": 0.0}}, "real robot"),
    ],
)
def test_what_is_no_order_is_refused_in_one_sentence(
    order: Callable[..., tuple[str, bool]], doing: str, fields: dict[str, Any], sentence: str
) -> None:
    words, done = order(doing, **fields)
    assert sentence in words and not done and "\n" not in words


def test_an_emergency_stop_waits_for_no_walker_that_does_not_answer(
    order: Callable[..., tuple[str, bool]], commands: FakeCommands, monkeypatch: pytest.MonkeyPatch
) -> None:
    hangs, end = threading.Event(), threading.Event()
    monkeypatch.setattr(commands, "status", lambda: (hangs.set(), end.wait(), STATUS)[-1])
    steering = threading.Thread(target=order, args=("steer",), kwargs={"velocity": [0.1, 0.0, 0.0]})
    steering.start()
    try:
        assert hangs.wait(TIMEOUT)
        stopped = threading.Thread(target=order, args=("stop",), kwargs={"how": "crouch"})
        stopped.start()
        stopped.join(TIMEOUT)
        assert not stopped.is_alive()
    finally:
        end.set()
        steering.join(TIMEOUT)


def test_a_robot_that_does_not_answer_is_told(
    order: Callable[..., tuple[str, bool]], commands: FakeCommands
) -> None:
    commands.there = False
    assert order("stop", how="crouch") == ("No robot `nao` at tcp/127.0.0.1:7447 answered `stop`.", False)


WAYS = {
    "pad": [("steer", {"velocity": [0.2, -0.05, 0.4]})],
    "keys": [("key", {"key": "w"})],
    "button": [("walk", {"command": {"op": "walk"}})],
    "steps": [("walk", {"command": {"op": "walk", "steps": 500}})],
    "changed in stride": [
        ("steer", {"velocity": [0.2, 0, 0]}),
        ("walk", {"command": {"op": "set", "torso": "none"}}),
    ],
}


@pytest.mark.parametrize("way", WAYS)
def test_each_way_of_driving_is_kept_alive_and_stopped_once_no_page_is_open(
    order: Callable[..., tuple[str, bool]],
    commands: FakeCommands,
    driving: Driving,
    lookers: list[str],
    monkeypatch: pytest.MonkeyPatch,
    way: str,
) -> None:
    commands.state = "walk"
    for doing, fields in WAYS[way]:
        assert order(doing, **fields)[1]
    assert next(c for c in commands.sent if c.op == "walk").hold == HOLD
    monkeypatch.setattr("nao_hil.drive.session.KEEPALIVE_INTERVAL", 0.0)
    sent = len(commands.sent)
    driving.keep_alive()
    assert commands.sent[sent:] == [WalkCommand(op="set", hold=HOLD)]
    lookers.clear()
    driving.keep_alive()
    assert commands.sent[-1] == WalkCommand(op="stop")
    sent = len(commands.sent)
    driving.keep_alive()
    assert len(commands.sent) == sent


@pytest.mark.parametrize("way", ["begins with it", "another gait before"])
def test_a_stick_steers_and_stops_a_walk_of_a_learned_gait(
    order: Callable[..., tuple[str, bool]], commands: FakeCommands, way: str
) -> None:
    if way == "another gait before":
        assert order("key", key="x")[1]
    commands.report = msgspec.structs.replace(STATUS, gait=LEARNED[0])
    assert order("walk", command={"op": "walk", "gait": LEARNED[0]})[1]
    assert order("steer", velocity=[0.05, 0.02, 0.1])[1]
    assert commands.sent[-1].velocity == pytest.approx((0.05, 0.02, 0.1))
    assert order("steer", velocity=[0, 0, 0])[1]
    assert commands.sent[-1] == WalkCommand(op="stop")


def test_a_stop_that_was_not_answered_is_sent_again(
    order: Callable[..., tuple[str, bool]],
    commands: FakeCommands,
    driving: Driving,
    lookers: list[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    order("steer", velocity=[0.2, 0, 0])
    lookers.clear()

    def silent(_: WalkCommand) -> WalkStatus:
        raise LinkError("no answer")

    with monkeypatch.context() as lost:
        lost.setattr(commands, "send", silent)
        driving.keep_alive()
    driving.keep_alive()
    driving.keep_alive()
    assert [c for c in commands.sent if c.op == "stop"] == [WalkCommand(op="stop")]


def test_a_walk_that_another_client_stopped_is_not_begun_again(
    order: Callable[..., tuple[str, bool]],
    commands: FakeCommands,
    driving: Driving,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    order("steer", velocity=[0.2, 0, 0])
    monkeypatch.setattr("nao_hil.drive.session.KEEPALIVE_INTERVAL", 0.0)
    commands.state = "stand"
    for _ in range(4):
        driving.keep_alive()
    assert [c for c in commands.sent if c.op == "walk"] == commands.sent[:1] and len(commands.sent) == 3


def test_joints_that_the_page_holds_are_given_back_once_no_page_is_open(
    commands: FakeCommands, driving: Driving
) -> None:
    hand = SimpleNamespace(holds=True, given=0)
    hand.release = lambda: setattr(hand, "given", hand.given + 1)
    orders = Orders(commands, driving, hand, BODY, None)  # type: ignore[arg-type]
    orders.keep_alive(ABSENCE_TIMEOUT - 0.1)
    assert hand.given == 0
    orders.keep_alive(ABSENCE_TIMEOUT)
    assert hand.given == 1


def test_a_restart_that_cannot_begin_is_refused_and_the_run_goes_on(
    order: Callable[..., tuple[str, bool]], capsys: pytest.CaptureFixture[str]
) -> None:
    for settings in ({"mode": "in-process"}, {"wear": "rusty"}, {"robot": "nao-v9"}, {"scenario": "moon"}):
        words, done = order("restart", settings=settings)
        assert words and not done
    assert capsys.readouterr().out == ""


def test_slow_motion_steps_the_world_and_a_page_that_ends_leaves_it_going(commands: FakeCommands) -> None:
    slow = SlowMotion(commands.world, 0.01)
    slow.end()
    assert commands.sent == []  # it was not slowed down
    slow.set_speed(0.5)
    until(lambda: len(commands.sent) > 3, "some steps")
    assert slow.speed == 0.5
    slow.end()
    assert slow.speed == 1.0
    first, *steps, last = commands.sent
    assert (first, set(map(type, steps)), last) == (Pause(), {Step}, Resume())
    assert "slow" not in [thread.name for thread in threading.enumerate()]


def test_slow_motion_ends_without_a_viewer(commands: FakeCommands, driving: Driving) -> None:
    slow = SlowMotion(commands.world, 0.01)
    orders = Orders(commands, driving, None, BODY, None, slow)  # type: ignore[arg-type]
    slow.set_speed(0.5)
    orders.keep_alive(ABSENCE_TIMEOUT - 0.1)
    assert slow.speed == 0.5
    orders.keep_alive(ABSENCE_TIMEOUT)
    assert slow.speed == 1.0 and commands.sent[-1] == Resume()


class HeldRobot:
    """Follows what it is asked for, and goes away after some cycles."""

    def __init__(self, cycles: int, first: Callable[[], object]) -> None:
        self.first_target = (0.1,) * len(JOINTS)
        self.asked: list[Any] = []
        self.cycles, self.first = cycles, first

    @contextmanager
    def connect(self, *_: Any, **__: Any) -> Iterator[HeldRobot]:
        yield self

    def step(self, target: Any) -> None:
        if not self.asked:
            self.first()
        self.asked.append(np.array(target))
        if len(self.asked) == self.cycles:
            raise LinkError("The robot went away.")


def test_a_held_robots_joints_go_where_they_are_wanted_no_faster_than_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    words: list[str] = []
    hand = Hand(BODY, "nao", "tcp/127.0.0.1:1", words.append)
    robot = HeldRobot(100, lambda: hand.move({"LKneePitch": 0.5}))
    monkeypatch.setattr("nao_hil.view.orders.connect", robot.connect)
    hand.take()
    until(lambda: "The robot went away." in words, "the page's word")
    asked = np.array(robot.asked)
    knee = asked[:, INDEX["LKneePitch"]]
    assert knee[0] == pytest.approx(0.1) and knee[-1] == pytest.approx(0.5)
    assert np.diff(knee).max() == pytest.approx(JOINT_RATE * BODY.cycle)
    assert np.ptp(np.delete(asked, INDEX["LKneePitch"], axis=1)) == 0.0
    until(lambda: not hand.holds, "the robot to be free")
