"""The link with real sessions on loopback; whoever is to be killed is a process of its own."""

from __future__ import annotations

import contextlib
import re
import secrets
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import pytest
import zenoh

from bridge.errors import ConfigurationError, FrameError, LeaseRefused, LinkError, RobotSilent
from bridge.link import ControllerLink, RobotLink, controller_side, keys
from bridge.link.client import GuardClient, WalkClient
from bridge.link.session import MAX_MESSAGE_SIZE, open_client, open_robot, subscribe
from bridge.messages import ActuatorFrame, Info, LeaseReply, LeaseRequest, Notice, WalkTelemetry, decode, encode
from tests.frames import info_of_robot, standing_frame, walk_telemetry
from tests.loops import TIMEOUT, until
from tests.one_link import one_link
from tests.ports import free_endpoint

ZEROS = (0.0,) * 25

HOLDER = """
import sys, time
from bridge.link import ControllerLink
with ControllerLink(connect=sys.argv[1], name="victim") as link:
    link.wait_robot()
    link.acquire()
    print("ready", flush=True)
    time.sleep(600)
"""


@pytest.fixture
def robot(endpoint: str) -> Iterator[RobotLink]:
    with RobotLink(new_robot(), endpoint) as link:
        yield link


@pytest.fixture
def controller(robot: RobotLink, endpoint: str) -> Iterator[ControllerLink]:
    """A controller that found the robot and holds the lease."""
    with ControllerLink(connect=endpoint) as link:
        link.wait_robot(timeout=TIMEOUT)
        link.acquire()
        yield link


def new_robot() -> Info:
    return info_of_robot(mode="lockstep", absent=("LWristYaw",), boot=secrets.randbits(31))


def command(reply_to: int) -> ActuatorFrame:
    return ActuatorFrame(reply_to=reply_to, position=ZEROS, stiffness=ZEROS)


def put(session: zenoh.Session, suffix: str, payload: bytes) -> None:
    """Publish, and rather wait than drop."""
    session.put(keys.key("nao", suffix), payload, congestion_control=zenoh.CongestionControl.BLOCK)


def next_command(robot: RobotLink) -> ActuatorFrame:
    """The next command; waits that a granted lease ended are begun again."""
    frame: ActuatorFrame = until(lambda: robot.wait_command(0.2), "a command")
    return frame


@contextlib.contextmanager
def child(script: str, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A Python process that has said `ready`; killed at the end."""
    process = subprocess.Popen(
        [sys.executable, "-c", script, *arguments], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield process
    finally:
        process.kill()
        process.communicate()


def test_a_controller_waits_for_a_robot_that_starts_later(endpoint: str) -> None:
    found: list[Info | None] = []
    with ControllerLink(connect=endpoint) as link:
        waiting = threading.Thread(target=lambda: found.append(link.wait_robot(timeout=TIMEOUT)))
        waiting.start()
        with RobotLink(new_robot(), endpoint) as robot:
            waiting.join(TIMEOUT)
            assert found == [robot.info]


def test_another_robot_at_the_endpoint_is_not_taken_for_ours(robot: RobotLink, endpoint: str) -> None:
    began = time.monotonic()
    with (
        ControllerLink("nao2", endpoint) as link,
        pytest.raises(LinkError, match=r"no robot `nao2`.*`nao` is there"),
    ):
        link.wait_robot(timeout=TIMEOUT)
    with (
        GuardClient("nao2", endpoint) as guard,
        pytest.raises(LinkError, match=r"no robot `nao2`.*`nao` is there"),
    ):
        guard.stop()
    with (
        WalkClient("nao2", endpoint) as walker,
        pytest.raises(LinkError, match=r"no robot `nao2`.*`nao` is there"),
    ):
        walker.status()
    assert time.monotonic() - began < 0.5 * TIMEOUT


def test_a_robot_of_a_world_is_found_though_another_one_was_announced_before_it(
    endpoint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: list[object] = []
    others, looked = ControllerLink._other_robots, threading.Event()

    def look(link: ControllerLink) -> str:
        names = others(link)
        if names:
            looked.set()
        return names

    monkeypatch.setattr(ControllerLink, "_other_robots", look)
    monkeypatch.setattr(controller_side, "_WORLD_LOOKS", 1 << 30)
    with RobotLink(info_of_robot(robot="away"), endpoint) as away, ControllerLink("home", endpoint) as link:
        waiting = threading.Thread(target=lambda: found.append(link.wait_robot(timeout=TIMEOUT)))
        waiting.start()
        assert looked.wait(TIMEOUT)
        with RobotLink(info_of_robot(robot="home"), endpoint, beside=away) as home:
            waiting.join(TIMEOUT)
            assert found == [home.info]


def test_robots_on_one_link_do_not_hear_one_another() -> None:
    """Each controller is connected to the node of another robot than its own."""
    names, places, end = (
        ("anna", "bert", "carl"),
        [free_endpoint() for _ in range(3)],
        time.monotonic() + TIMEOUT,
    )
    with contextlib.ExitStack() as stack:
        robots = [
            stack.enter_context(RobotLink(info_of_robot(robot=name), place))
            for name, place in zip(names, places, strict=True)
        ]
        stack.enter_context(contextlib.closing(one_link(places)))
        controllers = [
            stack.enter_context(ControllerLink(name, place, f"of-{name}"))
            for name, place in zip(names, places[1:] + places[:1], strict=True)
        ]
        for controller, robot in zip(controllers, robots, strict=True):
            info = controller.wait_robot(stop=lambda: time.monotonic() > end)
            assert info == robot.info
            controller.acquire()
        for number, (controller, robot) in enumerate(zip(controllers, robots, strict=True)):
            for _ in range(10):
                controller.publish(walk_telemetry(number))
                controller.send(command(number))
                robot.publish(standing_frame(number))
            robot.notice("last", f"Of robot {number}.")
        for number, (controller, robot) in enumerate(zip(controllers, robots, strict=True)):
            assert robot.holder is not None and robot.holder.name == controller.name
            assert gather(controller, {"last"})["last"].text == f"Of robot {number}."
            frames = [controller.next(TIMEOUT) for _ in range(10)]
            assert [frame.seq for frame in frames if frame is not None] == [number] * 10
            commands: list[ActuatorFrame] = []
            until(lambda of=robot, to=commands: to.extend(of.commands()) or len(to) >= 10, "the commands")
            assert [given.reply_to for given in commands] == [number] * 10
            assert [said.seq for said in robot.telemetry()] == [number] * 10
        assert [robot.refused for robot in robots] == [0, 0, 0]
        assert [link.latest(0.1) for link in controllers] == [None, None, None]


def test_the_latest_frame_overtakes_the_others(robot: RobotLink, controller: ControllerLink) -> None:
    seen: list[int] = []
    for seq in range(30):
        robot.publish(standing_frame(seq))
    until(lambda: (f := controller.latest(0.1)) is not None and (seen.append(f.seq) or f.seq == 29))
    assert seen == sorted(set(seen))
    assert controller.latest(0.0) is None


def test_a_command_arrives_with_the_lease_and_the_time(robot: RobotLink, controller: ControllerLink) -> None:
    controller.send(command(7))
    frame = next_command(robot)
    assert frame.reply_to == 7
    assert frame.lease == controller.lease != 0
    assert frame.wall > 0


def test_a_granted_lease_ends_the_robots_wait(robot: RobotLink, endpoint: str) -> None:
    """So that the frame the robot waits on is sent again, to a controller that did not hear it."""
    ended = threading.Event()

    def wait() -> None:
        assert robot.wait_command(TIMEOUT) is None
        ended.set()

    waiting = threading.Thread(target=wait)
    began = time.monotonic()
    waiting.start()
    with ControllerLink(connect=endpoint) as link:
        link.wait_robot(timeout=TIMEOUT)
        link.acquire()
        assert ended.wait(TIMEOUT)
    assert time.monotonic() - began < TIMEOUT
    waiting.join()


@pytest.mark.parametrize("name", ["another", "walker"])
def test_a_second_controller_is_refused_and_told_who_holds_the_robot(
    robot: RobotLink, controller: ControllerLink, endpoint: str, name: str
) -> None:
    with ControllerLink(connect=endpoint, name=name) as second:
        second.wait_robot(timeout=TIMEOUT)
        with pytest.raises(LeaseRefused, match="`walker`"):
            second.acquire()
        second.send(command(1))
    controller.lease += 1  # the holder's own seal, and the number of no lease
    controller.send(command(1))
    controller.lease -= 1
    controller.send(command(2))
    assert next_command(robot).reply_to == 2
    assert robot.holder is not None
    assert robot.holder.lease == controller.lease


def test_a_lease_given_back_is_free_at_once(
    robot: RobotLink, controller: ControllerLink, endpoint: str
) -> None:
    controller.release()
    assert robot.holder is None
    with ControllerLink(connect=endpoint, name="next") as following:
        following.wait_robot(timeout=TIMEOUT)
        following.acquire()
        assert robot.holder is not None
        assert robot.holder.name == "next"


@pytest.mark.parametrize("leave", ["release", "abandon"])
def test_a_lease_of_which_the_controller_knows_nothing_ends_when_it_leaves(
    robot: RobotLink, endpoint: str, leave: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The robot granted it, but its answer came too late; or an old notice said that there is none."""
    with ControllerLink(connect=endpoint) as link:
        link.wait_robot(timeout=TIMEOUT)
        ask = link._get
        with monkeypatch.context() as late:
            late.setattr(link, "_get", lambda *query: (ask(*query), None)[b"acquire" in query[1]])
            with pytest.raises(RobotSilent):
                link.acquire()
        assert robot.holder is not None
        getattr(link, leave)()
        until(lambda: robot.holder is None, "the end of the lease")
        assert robot.leases.abandoned == (leave == "abandon")


def test_no_command_goes_out_with_a_lease_that_is_being_given_back(
    robot: RobotLink, controller: ControllerLink, monkeypatch: pytest.MonkeyPatch
) -> None:
    ask, leases = controller._get, []
    monkeypatch.setattr(controller, "_get", lambda *query: leases.append(controller.lease) or ask(*query))
    controller.release()
    assert leases == [0]


def test_a_lease_dies_with_its_killed_holder(robot: RobotLink, endpoint: str) -> None:
    with ControllerLink(connect=endpoint, name="witness") as witness, child(HOLDER, endpoint) as holder:
        witness.wait_robot(timeout=TIMEOUT)
        assert robot.holder is not None
        assert robot.holder.name == "victim"
        holder.kill()
        until(lambda: robot.holder is None)
        assert robot.leases.abandoned
        gone = ("controller-gone", "Controller `victim` is gone; the robot is free.")
        until(lambda: gone in [(notice.code, notice.text) for notice in witness.notices()])
    with ControllerLink(connect=endpoint, name="heir") as heir:
        heir.wait_robot(timeout=TIMEOUT)
        heir.acquire()


def test_what_is_no_command_is_refused_with_a_notice_and_the_robot_goes_on(
    robot: RobotLink, controller: ControllerLink, endpoint: str
) -> None:
    good = encode(command(1))
    with contextlib.closing(open_client(endpoint)) as stranger:
        for payload in (b"", b"garbage", good[:-3], encode(standing_frame(0)), b"\xc1" * 100_000):
            put(stranger, "actuators", payload)
        put(stranger, "actuators", good)  # valid, but without the lease
        until(lambda: robot.refused == 6)
    assert not robot.commands()
    notices = gather(controller, {"frame-refused", "no-lease"})
    assert "ActuatorFrame" in notices["frame-refused"].text
    assert "`walker` holds" in notices["no-lease"].text
    controller.send(command(3))
    assert next_command(robot).reply_to == 3


def gather(controller: ControllerLink, codes: set[str]) -> dict[str, Notice]:
    """Notices by code, as soon as all these have come."""
    notices: dict[str, Notice] = {}

    def complete() -> bool:
        notices.update((n.code, n) for n in controller.notices())
        return codes <= set(notices)

    until(complete)
    return notices


def test_a_flood_of_refusals_is_answered_by_a_notice_not_by_a_flood(
    robot: RobotLink, controller: ControllerLink, endpoint: str
) -> None:
    """One per second of each kind: the flood is over in far less than the number of its frames in seconds."""
    with contextlib.closing(open_client(endpoint)) as stranger:
        for _ in range(200):
            put(stranger, "actuators", b"garbage")
        until(lambda: not robot.commands() and robot.refused == 200)
    robot.notice("last", "The flood is over.")
    heard: list[str] = []
    until(lambda: heard.extend(n.code for n in controller.notices()) or "last" in heard)
    assert 1 <= heard.count("frame-refused") <= 20


def test_an_error_in_an_answer_becomes_an_error_reply_and_the_next_is_answered(
    robot: RobotLink, controller: ControllerLink
) -> None:
    def answer(payload: bytes) -> bytes:
        if payload == b"wrong":
            raise ConfigurationError("`wrong` is wrong; `right` would be right.")
        if payload == b"broken":
            raise ZeroDivisionError
        return payload.upper()

    robot.serve("world/test", answer)
    assert controller.query("world/test", b"abc") == b"ABC"
    with pytest.raises(LinkError, match=r"^`wrong` is wrong; `right` would be right\.$"):
        controller.query("world/test", b"wrong")
    with pytest.raises(LinkError, match="world/test"):
        controller.query("world/test", b"broken")
    assert controller.query("world/test") == b""
    with pytest.raises(LinkError, match="no-such-thing"):
        controller.query("no-such-thing")


def test_listeners_hear_the_walker_through_the_robots_session(
    robot: RobotLink, controller: ControllerLink, endpoint: str
) -> None:
    heard: list[bytes] = []
    telemetry = walk_telemetry(1, step=1, steps=10)
    with contextlib.closing(open_client(endpoint)) as listener:
        subscriber = subscribe(listener, keys.topic_key("nao", WalkTelemetry), heard.append)

        def publish_until_heard() -> bool:
            controller.publish(telemetry)
            return bool(heard)

        until(publish_until_heard)
        subscriber.undeclare()
    assert decode(heard[0], WalkTelemetry) == telemetry
    until(lambda: telemetry in robot.telemetry())


def test_a_frame_that_is_none_is_told_to_the_controller(
    robot: RobotLink, controller: ControllerLink, endpoint: str
) -> None:
    with contextlib.closing(open_client(endpoint)) as stranger:
        put(stranger, "sensors", b"garbage")
        with pytest.raises(FrameError, match="SensorFrame"):
            controller.next(TIMEOUT)


@pytest.mark.parametrize("bad", ["", "7447", "127.0.0.1:7447", "tcp/127.0.0.1", "tcp/h:0", "tcp/h:x", "x/h:1"])
def test_what_is_no_endpoint_is_refused_by_both_sides(bad: str) -> None:
    with pytest.raises(ConfigurationError, match="tcp/127"):
        RobotLink(new_robot(), bad)
    with pytest.raises(ConfigurationError, match="tcp/127"):
        ControllerLink(connect=bad)


@pytest.mark.parametrize("host", ["0.0.0.0", "[::]", "192.168.1.7", "robot.local"])
def test_a_link_beyond_loopback_takes_certificates_or_the_word_open(host: str, port: int) -> None:
    with pytest.raises(ConfigurationError, match=rf"add --keys DIR .* tcp/{re.escape(host)}:{port}#open"):
        open_robot(f"tcp/{host}:{port}")


def test_a_link_that_is_called_open_listens_beyond_loopback(port: int) -> None:
    with open_robot(f"tcp/0.0.0.0:{port}#open"), open_client(f"tcp/127.0.0.1:{port}#open", TIMEOUT):
        pass


def test_the_last_frame_before_a_release_is_still_the_holders(
    robot: RobotLink, controller: ControllerLink
) -> None:
    controller.release()
    for seq in range(100):
        controller.acquire()
        controller.send(command(seq))
        controller.release()
        assert [given.reply_to for given in robot.commands()] == [seq]
    assert robot.refused == 0


def test_telemetry_is_there_when_the_answer_it_was_sent_before_is(
    robot: RobotLink, controller: ControllerLink
) -> None:
    robot.wait_command(0.0)  # the grant ends one wait
    for seq in range(200):
        controller.publish(walk_telemetry(seq))
        controller.send(command(seq))
        given = robot.wait_command(TIMEOUT)
        assert given is not None
        assert [t.seq for t in robot.telemetry()] == [given.reply_to] == [seq]


def test_a_payload_that_would_fill_the_memory_is_dropped_by_the_transport(
    robot: RobotLink, controller: ControllerLink, endpoint: str
) -> None:
    with contextlib.closing(open_client(endpoint)) as stranger:
        put(stranger, "actuators", b"\x00" * (2 * MAX_MESSAGE_SIZE))
        put(stranger, "actuators", b"")
        until(lambda: robot.refused, "the small one after it")
    assert robot.refused == 1
    controller.send(command(0))
    until(robot.commands, "the good frame")


def test_the_status_tells_a_listener_who_holds_the_robot(controller: ControllerLink, endpoint: str) -> None:
    request = encode(LeaseRequest(op="status", controller="listener"))
    with contextlib.closing(open_client(endpoint)) as listener:
        (reply,) = listener.get(keys.key("nao", keys.LEASE), payload=request)
    assert reply.ok is not None
    status = decode(reply.ok.payload.to_bytes(), LeaseReply)
    assert (status.granted, status.lease, status.holder) == (False, 0, "walker")
