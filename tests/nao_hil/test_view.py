"""The page's Python without a browser: rows, events, states in words, orders, surroundings."""

from __future__ import annotations

import base64
import json
import math
import re
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS
from bridge.errors import LinkError
from bridge.link import keys
from bridge.link.query import serve_query
from bridge.link.robots import LinkRobot
from bridge.link.session import open_robot
from bridge.messages import ActuatorFrame, Notice, SensorFrame, WalkTelemetry, decode, encode
from bridge.messages.frames import ORDER
from bridge.messages.guard import GuardStatus, StopRequest
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.messages.world import Pause, Press, Push, Resume, Step
from bridge.messages.world_state import WorldReply
from bridge.rotations import matrix
from emulator.robot import EmulatedRobot
from emulator.scenarios import load_scenario
from nao_hil.analysis.diagnosis import BalanceEstimator, Diagnosis, Symptom, explain
from nao_hil.analysis.diagnosis.symptoms import MEANING, Symptoms
from nao_hil.drive.driver import HOLD
from nao_hil.runs.run import Cycle, CycleBuilder
from nao_hil.view.access import Access
from nao_hil.view.follow import LEARNED, LinkFollower, LiveRun
from nao_hil.view.live import MAX_FRAMES, Subscriber, stop_all
from nao_hil.view.orders import (
    ABSENCE_TIMEOUT,
    JOINT_RATE,
    Driving,
    Hand,
    Orders,
    SlowMotion,
    answered,
)
from nao_hil.view.page import page, world_page, world_recordings
from nao_hil.view.rows import RunRows, events_json
from nao_hil.view.server import MAX_BACKLOG, PING_INTERVAL, Browser, PageServer
from nao_hil.view.signals import SIGNALS
from nao_hil.view.state import describe
from nao_hil.view.surroundings import initial_world, terrain_meshes
from tests.frames import standing_frame, truth_frame, walk_status, walk_telemetry
from tests.loops import TIMEOUT, until
from tests.made_worlds import record_world
from tests.nao_hil.test_export_run import unpacked
from tests.ports import free_endpoint, free_port

BODY = load_body("nao-v3")
REPLY = WorldReply(
    text="Done.", seq=0, time=0.0, paused=False, floor=(0.0, 0.0), friction=0.8, objects=(), faults=()
)
STATUS = walk_status(text="It walks.", state="walk", velocity=(0.05, 0.0, 0.0))


@pytest.fixture(scope="module")
def standing() -> list[Cycle]:
    """Two seconds of a robot that stands."""
    builder, kept = CycleBuilder(), []
    with EmulatedRobot(BODY, seed=0, engine="mujoco") as robot:
        for _ in range(200):
            robot.advance(None)
            for message in (robot.frame, robot.truth()):
                if (cycle := builder.add(message)) is not None:
                    kept.append(cycle)
    return kept


def test_a_row_holds_the_true_pose_the_forces_and_every_signal(standing: list[Cycle]) -> None:
    cycle = standing[-1]
    asked = ActuatorFrame(position=tuple(0.01 * i for i in range(25)), stiffness=(1.0,) * 25, reply_to=1)
    rows = RunRows(BODY)
    row = rows.row(BalanceEstimator(BODY).update(cycle._replace(asked=asked)), 1.5)
    _, tables = unpacked(rows.pack(np.array([row]), []))
    assert cycle.truth is not None
    torso = 3 * rows.links.index("Torso")
    np.testing.assert_allclose(tables["position"][0, torso : torso + 3], cycle.truth.torso_position, atol=1e-4)
    w, x, y, z = tables["attitude"][0, :4]
    np.testing.assert_allclose(matrix((x, y, z, w)), matrix(cycle.truth.torso_orientation), atol=1e-3)
    np.testing.assert_allclose(tables["loads"][0], cycle.sensors.fsr, atol=0.06)
    signals = dict(zip(SIGNALS, tables["signals"][0], strict=True))
    knee = JOINTS.index("LKneePitch")
    expected = {
        "torso pitch": math.degrees(cycle.sensors.angle[1]),
        "force left foot": sum(cycle.sensors.fsr[:4]),
        "cycle late": 1.5,
        "accelerometer z": cycle.sensors.accelerometer[2],
        "angle LKneePitch": math.degrees(cycle.sensors.position[knee]),
        "command LKneePitch": math.degrees(0.01 * knee),
        "current LKneePitch": cycle.sensors.current[knee],
        "temperature LKneePitch": cycle.sensors.temperature[knee],
    }
    assert {name: signals[name] for name in expected} == pytest.approx(expected, abs=0.006)
    assert math.isnan(signals["ZMP margin planned"])  # no walker has said anything


def test_a_row_holds_the_pose_of_each_other_robot_of_the_world_by_its_name(standing: list[Cycle]) -> None:
    bodies = {"blue": load_body("nao-v6"), "green": BODY, "white": BODY}
    turn = (0.0, 0.0, math.sin(0.4), math.cos(0.4))
    joints = tuple(0.01 * i for i in range(len(JOINTS)))
    blue = truth_frame(torso_position=(1.0, -0.5, 0.3), torso_orientation=turn, joints=joints)
    rows = RunRows(BODY, None, bodies)
    balance = BalanceEstimator(BODY).update(standing[-1])
    row = rows.row(balance, others={"blue": blue, "green": standing[-1].truth, "white": None})
    header, tables = unpacked(rows.pack(np.array([row]), []))
    assert [other["name"] for other in header["others"]] == ["blue", "green", "white"]  # type: ignore[index, attr-defined]
    poses = tables["others"].reshape(3, 32)
    w, x, y, z = poses[0, 3:7]
    np.testing.assert_allclose(poses[0], [1.0, -0.5, 0.3, w, x, y, z, *joints], atol=1e-4)
    np.testing.assert_allclose(matrix((x, y, z, w)), matrix(turn), atol=1e-3)
    assert standing[-1].truth is not None
    np.testing.assert_allclose(poses[1, :3], standing[-1].truth.torso_position, atol=1e-4)
    assert np.isnan(poses[2]).all()
    # own body with the ground, and the other one; each piece of a link of its body
    bodies_ = header["bodies"]
    assert len(bodies_) == 2 and [o["body"] for o in header["others"]] == [1, 0, 0]  # type: ignore[arg-type, index, attr-defined]


def test_a_live_run_gives_a_late_browser_what_the_others_have(standing: list[Cycle]) -> None:
    info = SimpleNamespace(body=BODY.name, sheet="", side="emulator", mode="real-time")
    run = LiveRun(info, "robot nao", REPLY)  # type: ignore[arg-type]
    assert len(unpacked(run.packed(emulated=True))[1]["time"]) == 0  # of one before the first frame
    messages = [message for cycle in standing for message in run.take(cycle)]
    sent = np.array([np.frombuffer(m, "<f4") for m in messages if isinstance(m, bytes)])
    header, tables = unpacked(run.packed(emulated=True))
    assert sent.shape == (len(tables["time"]), run.rows.width)
    np.testing.assert_allclose(sent[:, 0], tables["time"][:, 0], atol=1e-3)
    prints = [p for m in messages if isinstance(m, dict) for p in m.get("prints", [])]
    assert len(prints) == len(tables["footprints"]) == 2
    assert header["live"] == {"emulated": True}


def test_the_fall_says_its_first_sign_and_when_it_was_over() -> None:
    first = Symptom(4.2, "zmp", "the ZMP left the support polygon")
    push = Symptom(4.0, "world", "Torso is pushed with 1 N s over 0.1 s")
    fall = Symptom(4.9, "fall", "the robot fell")
    diagnosis = Diagnosis(fell=4.9, chain=(push, first, fall), first=first, before=push, torso_off=True)
    told = events_json([push, first, fall], diagnosis, 9.5)
    assert told["fall"]["time"] == 4.9 and told["fall"]["until"] == 9.5 and told["fall"]["first"] == 4.0
    assert told["fall"]["text"] == f"{push.text}, then {first.text}"
    assert told["fall"]["meaning"].startswith(MEANING["zmp"])
    assert told["fall"]["meaning"].endswith("torso control was off.")
    assert [event["time"] for event in told["events"]] == [4.0, 4.2, 4.9]
    assert events_json([], None) == {"events": [], "fall": None}


def telemetry(seq: int, state: str = "walk") -> WalkTelemetry:
    return walk_telemetry(seq, state=state, phase="SSL", step=3)


@pytest.mark.parametrize(
    ("guard", "angle", "words", "alarm"),
    [
        ({"state": "active", "holder": "walker"}, (0.0, 0.0), "walks", False),
        ({"state": "active", "holder": "mine"}, (0.0, 0.0), "held by mine", False),
        ({"state": "crouch", "reason": "stop"}, (0.0, 0.0), "crouching, emergency stop", True),
        ({"state": "rest", "reason": "stop"}, (0.0, 0.0), "limp, emergency stop", True),
        ({"state": "fallen", "reason": "fall"}, (0.0, -1.5), "limp, lies on its back", True),
        ({"state": "fallen", "reason": "fall"}, (0.0, 1.5), "limp, lies on its front", True),
        ({"state": "fallen", "reason": "fall"}, (1.5, 0.0), "limp, lies on its side", True),
        ({"state": "hold", "reason": "silence"}, (0.0, 0.0), "holds its pose: its controller is silent", False),
        ({"state": "idle"}, (0.0, 0.0), "free, joints left alone", False),
        ({"state": "idle", "holder": "mine"}, (0.0, 0.0), "held by mine", False),
    ],
)
def test_the_state_is_the_robots_own_report_not_the_walkers_last_word(
    standing: list[Cycle], guard: dict[str, str], angle: tuple[float, float], words: str, alarm: bool
) -> None:
    frame = msgspec.structs.replace(standing[-1].sensors, angle=angle)
    walks = guard.get("holder") == "walker"
    cycle = Cycle(frame, walk=telemetry(frame.seq if walks else max(frame.seq - 100, 0)))
    report = GuardStatus(seq=1, armed=True, text="", **guard)  # type: ignore[arg-type]
    state = describe(cycle, report, STATUS, REPLY, 0.0)
    assert (state["words"], state["alarm"]) == (words, alarm)
    assert state["velocity"] == ([0.05, 0.0, 0.0] if walks else [0.0, 0.0, 0.0])


def test_a_silent_robot_is_not_said_to_walk(standing: list[Cycle]) -> None:
    frame = standing[-1].sensors
    cycle = Cycle(frame, walk=telemetry(frame.seq))
    report = GuardStatus(seq=1, state="active", armed=True, holder="walker", text="")
    assert describe(cycle, report, STATUS, REPLY, 4.2)["words"] == "no word from the robot for 4 s"
    paused = msgspec.structs.replace(REPLY, paused=True)
    assert describe(cycle, report, STATUS, paused, 4.2)["words"] == "paused"
    assert describe(None, None, None, None, 0.0)["words"] == "waits for the robot"


def test_stops_arming_and_orders_are_events_also_of_a_robot_that_lies_and_no_sign_of_trouble(
    standing: list[Cycle],
) -> None:
    notices = tuple(
        Notice(seq=1, level="info", code=code, text=f"{code}.")
        for code in ("guard-stop", "guard-armed", ORDER, "guard-active", "clipped")
    )
    watch = Symptoms(observer := BalanceEstimator(BODY))
    watch.update(observer.update(standing[-2]))
    watch._lies = True
    found = watch.update(observer.update(standing[-1]._replace(notices=notices)))
    assert [(s.kind, s.text) for s in found] == [("order", c) for c in ("guard-stop", "guard-armed", ORDER)]
    fall = Symptom(found[0].time + 1.0, "fall", "the robot fell")
    diagnosis = explain([*found, fall])
    assert diagnosis is not None and diagnosis.first is None and diagnosis.before is None


class FakeCommands:
    """Takes commands and keeps them."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.there = True
        self.state = "stand"

    def world(self, command: Any) -> WorldReply:
        self.sent.append(command)
        return REPLY

    def walk(self, command: WalkCommand) -> WalkStatus:
        self.sent.append(command)
        return msgspec.structs.replace(STATUS, state=self.state)

    send = walk

    def status(self) -> WalkStatus:
        return msgspec.structs.replace(STATUS, state=self.state)

    def walker(self) -> FakeCommands:
        return self

    def stop(self) -> GuardStatus:
        if not self.there:
            raise LinkError("No robot `nao` at tcp/127.0.0.1:7447 answered `stop`.")
        return GuardStatus(seq=1, state="crouch", reason="stop", armed=False, text="It goes down.")


@pytest.fixture
def commands() -> FakeCommands:
    return FakeCommands()


@pytest.fixture
def lookers() -> list[str]:
    """Who looks at the page."""
    return ["somebody"]


@pytest.fixture
def driving(commands: FakeCommands, lookers: list[str]) -> Driving:
    return Driving(lambda: commands, lambda: 0.0 if lookers else ABSENCE_TIMEOUT)  # type: ignore[arg-type, return-value]


@pytest.fixture
def order(commands: FakeCommands, driving: Driving, tmp_path: Path) -> Callable[..., tuple[str, bool]]:
    config = tmp_path / "config.toml"
    config.write_text('robot = "nao-v3"\n')
    orders = Orders(commands, driving, None, BODY, lambda: config)  # type: ignore[arg-type]
    return lambda doing, **fields: answered(json.dumps({"do": doing, **fields}), orders.execute)  # type: ignore[arg-type]


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


@pytest.fixture
def link(commands: FakeCommands) -> tuple[LinkFollower, FakeCommands]:
    """A link with the chosen robot `red`, and `blue`; the commands that reach `blue`."""
    server, others = SimpleNamespace(absence=0.0), FakeCommands()
    follower = LinkFollower(server, "red", "tcp/127.0.0.1:1", threading.Event())  # type: ignore[arg-type]
    for name, taken in (("red", commands), ("blue", others)):
        driving = Driving(lambda taken=taken: taken, lambda: 0.0)  # type: ignore[misc, return-value]
        follower.follower(name)._orders = Orders(taken, driving, None, BODY, None)  # type: ignore[arg-type]
        follower.robots.found[name] = LinkRobot(BODY, deque())
    return follower, others


def test_an_order_reaches_the_robot_that_the_page_showed_whichever_is_chosen_since(
    link: tuple[LinkFollower, FakeCommands], commands: FakeCommands
) -> None:
    follower, others = link
    push = {"op": "push", "impulse": [1, 0, 0]}
    for robot in ({"robot": "blue"}, {"robot": "red"}, {}):
        answer, done = follower.carry_out(json.dumps({"do": "world", "command": push, **robot}))
        assert done and answer.startswith(robot.get("robot", "red"))
    assert len(others.sent) == 1 and len(commands.sent) == 2
    assert follower.carry_out('{"do":"choose","robot":"blue"}')[1]
    follower.carry_out(json.dumps({"do": "world", "command": push}))
    assert len(others.sent) == 2
    answer, done = follower.carry_out('{"do":"choose","robot":"blu"}')
    assert not done and "'blue'" in answer


def test_a_run_that_begins_with_the_first_message_of_its_robot_has_a_whole_state(
    link: tuple[LinkFollower, FakeCommands],
) -> None:
    for follower in map(link[0].follower, ("red", "blue")):
        for _ in range(2):
            info = SimpleNamespace(body=BODY.name, sheet="", side="emulator", mode="real-time")
            follower._run = LiveRun(info, "robot", None)  # type: ignore[arg-type]
            packed = follower._packed()
            assert packed is not None
            state = unpacked(packed)[0]["live"]["state"]
            assert describe(None, None, None, None, 0.0).items() <= state.items()
            assert state["words"] == "waits for the robot"
            follower.hide()  # another robot is chosen, and then this one again


def test_ground_that_was_not_answered_at_first_is_asked_for_again_and_shown(
    link: tuple[LinkFollower, FakeCommands], commands: FakeCommands, monkeypatch: pytest.MonkeyPatch
) -> None:
    follower, fed = link[0].follower("red"), list[Any]()
    monkeypatch.setattr(follower._server, "feed", lambda whole, *_: fed.append(whole()), raising=False)
    monkeypatch.setattr(follower._server, "publish", lambda _: None, raising=False)
    terrain = initial_world(load_scenario("tiles"), 3).terrain
    info = SimpleNamespace(body=BODY.name, sheet="", side="emulator", mode="real-time")
    run = follower._run = LiveRun(info, "robot", None)  # type: ignore[arg-type]
    monkeypatch.setattr(
        follower._commands,
        "world",
        lambda command: msgspec.structs.replace(REPLY, terrain=terrain if command.terrain else None),
    )
    for _ in range(3):
        follower._ask_world(run)
        follower.poll()
    (packed,) = fed
    assert {"link": 0}.items() <= unpacked(packed)[0]["pieces"][-1].items()  # type: ignore[index]


def test_a_robot_that_begins_again_begins_once_and_without_the_last_cycle_before(
    link: tuple[LinkFollower, FakeCommands], standing: list[Cycle], monkeypatch: pytest.MonkeyPatch
) -> None:
    follower, rows, begun = link[0].follower("red"), list[Any](), list[int]()
    monkeypatch.setattr(follower._server, "publish", rows.append, raising=False)
    info = SimpleNamespace(body=BODY.name, sheet="", side="emulator", mode="real-time")
    monkeypatch.setattr(follower._commands, "info", lambda: info)

    def begin(_: Any) -> None:
        begun.append(len(rows))
        follower._run = LiveRun(info, "robot", None)  # type: ignore[arg-type]

    monkeypatch.setattr(follower, "_begin", begin)
    for cycle in (*standing[:60], *standing[:20]):
        follower._process(cycle.sensors)
    assert len(begun) == 2
    first = next(row for row in rows[begun[1] :] if isinstance(row, bytes))
    assert np.frombuffer(first, "<f4")[0] == pytest.approx(standing[0].sensors.time, abs=1e-6)


def test_a_state_of_the_guard_is_shown_though_the_next_one_follows_before_the_page_looks(
    link: tuple[LinkFollower, FakeCommands],
) -> None:
    follower, published = link[0].follower("red"), list[dict[str, Any]]()
    frames = [standing_frame(seq, angle=(0.0, 0.0)) for seq in range(2)]
    hold, crouch = (
        GuardStatus(seq=1, state=state, reason="silence", armed=True, text="") for state in ("hold", "crouch")
    )
    info = SimpleNamespace(body=BODY.name, sheet="", side="emulator", mode="real-time")
    follower._run = LiveRun(info, "robot", None)  # type: ignore[arg-type]
    follower._run.newest = Cycle(frames[0])
    follower._server = SimpleNamespace(publish=published.append)  # type: ignore[assignment]
    follower._subscriber = SimpleNamespace(take=lambda: iter((hold, *frames[1:], crouch)))  # type: ignore[assignment]
    follower.poll()
    words = [message["state"]["words"] for message in published if "state" in message]
    assert words == ["holds its pose: its controller is silent", "crouching"]


def test_a_page_that_is_behind_skips_frames_and_no_notice() -> None:
    subscriber = Subscriber("nao", "tcp/127.0.0.1:1")
    subscriber._subscription.connect = lambda: True  # type: ignore[method-assign]
    notice = Notice(seq=0, level="info", code="guard-armed", text="The robot was armed.")
    subscriber._enqueue(SensorFrame, encode(standing_frame(0)))
    subscriber._enqueue(Notice, encode(notice))
    for seq in range(1, 3000):
        subscriber._enqueue(SensorFrame, encode(standing_frame(seq)))
    assert [message.seq for message in subscriber.take()] == [0, *range(3000 - MAX_FRAMES, 3000)]
    subscriber._enqueue(SensorFrame, encode(standing_frame(0)))
    subscriber._enqueue(Notice, encode(notice))
    assert [type(message) for message in subscriber.take()] == [SensorFrame, Notice]  # in their order


def test_a_stop_of_all_robots_reaches_each_and_names_the_one_that_is_silent() -> None:
    endpoint, reached = free_endpoint(), list[bytes]()
    down = GuardStatus(seq=1, state="crouch", reason="stop", armed=False, text="It goes down.")
    with open_robot(endpoint) as session:
        answering = serve_query(
            session, keys.key("red", keys.STOP), lambda payload, _: reached.append(payload) or encode(down)
        )
        assert stop_all(["red"], endpoint) == "red: It goes down."
        with pytest.raises(LinkError, match="`blue`: no answer"):
            stop_all(["blue", "red"], endpoint)
        assert [decode(payload, StopRequest).how for payload in reached] == ["crouch"] * 2
        answering.undeclare()


def test_a_stop_of_all_robots_says_that_it_reached_none(
    link: tuple[LinkFollower, FakeCommands],
) -> None:
    answer, done = link[0].carry_out('{"do":"stop-all"}')  # nothing listens there
    assert not done and "tcp/127.0.0.1:1" in answer


def test_the_page_keeps_no_walk_alive_that_a_stop_of_all_robots_did_not_reach(
    link: tuple[LinkFollower, FakeCommands], monkeypatch: pytest.MonkeyPatch
) -> None:
    follower, others = link
    others.state = "walk"
    driving = follower.follower("blue")._driving = follower.follower("blue")._orders._driving  # type: ignore[union-attr]
    assert follower.carry_out('{"do":"steer","robot":"blue","velocity":[0.1,0,0]}')[1]
    assert not follower.carry_out('{"do":"stop-all"}')[1]  # nothing listens there
    monkeypatch.setattr("nao_hil.drive.session.KEEPALIVE_INTERVAL", 0.0)
    sent = len(others.sent)
    driving.keep_alive()
    assert len(others.sent) == sent


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
    order: Callable[..., tuple[str, bool]], commands: FakeCommands, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    if way == "another gait before":
        assert order("key", key="x")[1]
    monkeypatch.setattr("tests.nao_hil.test_view.STATUS", msgspec.structs.replace(STATUS, gait=LEARNED[0]))
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


def test_a_page_is_absent_once_its_browser_does_not_answer() -> None:
    """Also where its connection stays open: a laptop that sleeps, a cable that is out."""
    pings = list[threading.Event]()
    connection = SimpleNamespace(send=lambda _: None, ping=lambda: pings.append(threading.Event()) or pings[-1])
    browser = Browser(connection, lambda: None)
    browser.start()
    until(lambda: pings, "a ping")
    asked = browser.seen
    until(lambda: time.monotonic() - asked > 3 * PING_INTERVAL, "the time of some pings")
    assert browser.seen == asked
    browser.end(1.0)


def test_a_browser_that_is_behind_gets_the_run_again_and_every_answer() -> None:
    sent, end = list[Any](), threading.Event()

    def send(message: Any) -> None:
        end.wait(TIMEOUT)
        sent.append(message)

    browser = Browser(SimpleNamespace(send=send, ping=threading.Event), lambda: b"the run")
    server: Any = SimpleNamespace(_order=lambda text: (text, True))
    browser.start()
    for i in range(MAX_BACKLOG + 2):
        if i in (0, MAX_BACKLOG):
            PageServer._answer(server, browser, f"answer {i}", urgent=False)
        browser.put(b"a row")
    PageServer._answer(server, browser, "the last answer", urgent=False)
    end.set()
    browser.end(TIMEOUT)
    words = [json.loads(message)["answer"] for message in sent if isinstance(message, str) and message != "{}"]
    assert words == ["answer 0", f"answer {MAX_BACKLOG}", "the last answer"]
    assert b"the run" in sent and sent.count(b"a row") < 10


def test_an_order_that_fails_by_a_fault_is_answered() -> None:
    said = list[str]()
    server: Any = SimpleNamespace(_order=lambda text: {}[text])
    PageServer._answer(server, SimpleNamespace(tell=said.append), "walk", urgent=True)  # type: ignore[arg-type]
    (answer,) = map(json.loads, said)
    assert "KeyError('walk')" in answer["answer"] and not answer["done"] and answer["urgent"]


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


def test_a_recorded_world_holds_a_run_of_each_robot_with_the_others_in_it(tmp_path: Path) -> None:
    last = record_world(tmp_path, 30)
    assert list(world_recordings(tmp_path)) == ["blue", "red"]
    html, _ = world_page(world_recordings(tmp_path), "blue")
    texts = re.findall(r'<script type="application/octet-stream">(.*?)</script>', html)
    runs = [unpacked(base64.b64decode(text)) for text in texts]
    assert [header["name"] for header, _ in runs] == ["blue", "red"]  # the chosen one is shown first
    for (header, tables), other in zip(runs, ("red", "blue"), strict=True):
        assert header["names"] == ["blue", "red"]
        (drawn,) = header["others"]  # type: ignore[misc, attr-defined]
        assert drawn["name"] == other
        np.testing.assert_allclose(tables["others"][-1, :3], last[other].torso_position, atol=2e-3)
        np.testing.assert_allclose(tables["others"][-1, 7:], last[other].joints, atol=5e-3)
        assert len(header["objects"]) == 6 and header["field"]["size"] == [7.4, 5.4]  # type: ignore[index, arg-type]


@pytest.mark.parametrize("name", ["tiles", "rough"])
def test_the_terrain_of_a_recording_is_the_one_the_robot_walked(name: str) -> None:
    scenario = load_scenario(name)
    terrain = initial_world(scenario, 3).terrain
    assert terrain is not None
    with EmulatedRobot(BODY, seed=3, scenario=scenario) as robot:
        assert robot.world.terrain == terrain
        (mesh,) = terrain_meshes(terrain)
        # over the middle of each upward face the ground is as high as the face, where no other tile is near
        corners = mesh[0][mesh[1]]
        upward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 1e-9
        middles = corners[upward].mean(axis=1)
        inside = middles[np.abs(middles[:, :2]).max(axis=1) < 0.4]
        heights = robot.world.ground([(float(x), float(y)) for x, y, _ in inside])
    assert len(inside) > 50
    np.testing.assert_allclose(heights, inside[:, 2], atol=1e-4)


def test_every_answer_of_the_page_has_a_content_security_policy_and_its_script_is_named() -> None:
    port = free_port()
    server = PageServer("127.0.0.1", port, Access())
    server.show(*page("policy"))
    try:
        for path, source in (("/", "script-src 'sha256-"), ("/nothing", "default-src 'none'")):
            connection = HTTPConnection("127.0.0.1", port, timeout=TIMEOUT)
            connection.request("GET", path)
            policy = connection.getresponse().headers["Content-Security-Policy"]
            assert source in policy and "frame-ancestors 'none'" in policy and "unsafe-eval" not in policy
            connection.close()
    finally:
        server.close()


@pytest.mark.parametrize("seed", sorted(Path("tests/fuzz/corpus/page").iterdir()), ids=lambda file: file.name)
def test_whatever_a_stranger_sends_the_next_one_gets_the_page(seed: Path) -> None:
    port = free_port()
    server = PageServer("127.0.0.1", port, Access())
    server.show(*page("policy"))
    try:
        with socket.create_connection(("127.0.0.1", port), TIMEOUT) as stranger:
            stranger.sendall(seed.read_bytes())
            connection = HTTPConnection("127.0.0.1", port, timeout=TIMEOUT)
            connection.request("GET", "/")
            assert connection.getresponse().status == 200
            connection.close()
    finally:
        server.close()
