"""The page on a link of several robots."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.errors import LinkError
from bridge.link import keys
from bridge.link.query import serve_query
from bridge.link.session import open_robot
from bridge.messages import Notice, SensorFrame, decode, encode
from bridge.messages.guard import GuardStatus, StopRequest
from emulator.scenarios import load_scenario
from nao_hil.runs.run import Cycle
from nao_hil.view.follow import LinkFollower
from nao_hil.view.live import MAX_FRAMES, Subscriber, stop_all
from nao_hil.view.live_run import LiveRun
from nao_hil.view.state import describe
from nao_hil.view.surroundings import initial_world
from tests.frames import standing_frame
from tests.nao_hil.test_export_run import unpacked
from tests.nao_hil.view.conftest import BODY, REPLY, FakeCommands
from tests.ports import free_endpoint


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


def test_a_world_in_slow_motion_is_not_said_to_be_paused(
    link: tuple[LinkFollower, FakeCommands], commands: FakeCommands
) -> None:
    follower = link[0].follower("red")
    follower._world = msgspec.structs.replace(REPLY, paused=True)
    assert follower._describe(0.0)["paused"]
    slow = link[0].slow_motion(SimpleNamespace(world=commands.world), 0.01)  # type: ignore[arg-type]
    slow.set_speed(0.25)
    state = follower._describe(0.0)
    assert not state["paused"] and state["time_scale"] == 0.25
    slow.end()


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
