"""`nao-hil bridge naoqi` on a served robot, as on a real one; and the whole loop, in which the walker walks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from bridge.body.joints import INDEX
from bridge.link import ControllerLink
from bridge.link.client import GuardClient
from bridge.messages import ActuatorFrame, SensorFrame
from tests.loops import TIMEOUT, until
from tests.system.naoqi_robot import ObedientRobot, obedient_robot

pytest.importorskip("qi")

HEAD = INDEX["HeadYaw"]


@pytest.fixture
def url(port: int) -> str:
    return f"tcp://127.0.0.1:{port}"


@pytest.fixture
def robot(endpoint: str) -> Iterator[ObedientRobot]:
    with obedient_robot("nao-v5", endpoint) as robot:
        yield robot


@pytest.fixture
def bridged(
    robot: ObedientRobot, start: Callable[..., Any], endpoint: str, url: str, far: str
) -> Callable[..., tuple[Any, Any]]:
    """Starts NAOqi's server and a bridge with some options, which finds its robot; both commands."""

    def begin(*options: str) -> tuple[Any, Any]:
        server = start("serve", "naoqi", "--listen", url, "--connect", endpoint, "--no-realtime-priority")
        bridge = start("bridge", "naoqi", "--url", url, "--listen", far, "--no-realtime-priority", *options)
        until(lambda: "not armed" in words(bridge), "the bridge to find its robot")
        return server, bridge

    return begin


@contextmanager
def armed(far: str) -> Iterator[tuple[GuardClient, ControllerLink]]:
    """A controller with the lease of an armed robot."""
    with GuardClient("nao", far) as guard, ControllerLink("nao", far, "test") as link:
        guard.arm("test")
        link.wait_robot(timeout=TIMEOUT)
        link.acquire()
        yield guard, link


def words(command: Any) -> str:
    return " ".join(command.stderr.split())


def newest(link: ControllerLink) -> SensorFrame:
    frame = link.latest(TIMEOUT)
    assert frame is not None
    return frame


def test_a_bridged_robot_shows_what_it_measures_and_obeys_when_it_is_armed(
    robot: ObedientRobot, bridged: Callable[..., tuple[Any, Any]], far: str
) -> None:
    _, bridge = bridged("--json")
    with ControllerLink("nao", far, "test") as link:
        info = link.wait_robot(timeout=TIMEOUT)
        assert info is not None
        assert (info.body, info.side, info.mode) == ("nao-v5", "naoqi", "real-time")
        frame = newest(link)
        for name in ("position", "fsr", "accelerometer", "gyroscope", "angle", "battery", "sonar"):
            assert getattr(frame, name) == pytest.approx(getattr(robot.frame, name), abs=1e-3), name
        link.acquire()

        def turn_head() -> float:
            position = list(frame.position)
            position[HEAD] = 0.05
            link.send(ActuatorFrame(reply_to=newest(link).seq, position=tuple(position), stiffness=(0.8,) * 25))
            return robot.frame.position[HEAD]

        for _ in range(20):
            turn_head()
        assert robot.frame.position[HEAD] == pytest.approx(0.0, abs=1e-3)  # a real robot starts disarmed
        with GuardClient("nao", far) as guard:
            guard.arm("test")
        until(lambda: turn_head() > 0.049, "the head to turn")
        until(lambda: turn_head() and robot.frame.stiffness[HEAD] < 0.81, "the stiffness")
        assert newest(link).position[HEAD] == pytest.approx(0.05, abs=2e-3)
        link.release()
    bridge.interrupt()
    assert bridge.result["connections"] == 1
    assert bridge.result["commands"] > 0


def test_a_frame_names_the_command_whose_time_had_come(
    bridged: Callable[..., tuple[Any, Any]], far: str
) -> None:
    """With a look-ahead of five cycles no answer is in force sooner, and the controller sees that."""
    bridged("--look-ahead", "50")
    with armed(far) as (_, link):
        first = newest(link).seq
        late = []

        def answered() -> bool:
            frame = newest(link)
            link.send(ActuatorFrame(reply_to=frame.seq, position=frame.position, stiffness=(1.0,) * 25))
            if frame.command >= first:
                late.append(frame.seq - 1 - frame.command)
            return len(late) >= 100 and 5 in late

        until(answered, "answers to be in force, one of them as soon as it can be")
    assert min(late) == 5


def test_a_dry_run_moves_nothing(
    robot: ObedientRobot,
    bridged: Callable[..., tuple[Any, Any]],
    start: Callable[..., Any],
    endpoint: str,
    url: str,
    far: str,
) -> None:
    server, bridge = bridged("--dry-run", "--json")
    with armed(far) as (guard, link):
        for _ in range(30):
            link.send(ActuatorFrame(reply_to=newest(link).seq, position=(0.1,) * 25, stiffness=(1.0,) * 25))
        assert guard.status().state != "idle"
        assert robot.frame.position[HEAD] == pytest.approx(0.0, abs=1e-3)
        server.kill()  # NAOqi is gone: so is the robot, until it is back
        until(lambda: not link.robot_alive, "the robot to disappear")
        start("serve", "naoqi", "--listen", url, "--connect", endpoint, "--no-realtime-priority")
        until(lambda: link.robot_alive, "the robot to come back")
    bridge.interrupt()
    assert bridge.result["commands"] == 0
    assert bridge.result["connections"] == 2


@pytest.mark.realtime
def test_the_walker_walks_through_the_loop(
    start: Callable[..., Any], endpoint: str, url: str, far: str
) -> None:
    """Emulator - serve naoqi - bridge naoqi - walker; NAOqi has no lockstep."""
    robot = start("emulate", "--robot", "nao-v3", "--wear", "ideal", "--listen", endpoint, "--json")
    start("serve", "naoqi", "--listen", url, "--connect", endpoint)
    bridge = start("bridge", "naoqi", "--url", url, "--listen", far, "--json")
    until(lambda: "not armed" in words(bridge), "the bridge to find its robot")
    assert start("arm", "--yes", "--connect", far).wait() == 0
    walker = start("walk", "--gait", "dynamic", "--steps", "6", "--connect", far, "--json")
    assert walker.wait() == 0
    assert walker.result["done"] and walker.result["steps"] == 6 and not walker.result["fell"]
    bridge.interrupt()
    assert bridge.result["left_out"] < 0.1 * bridge.result["frames"]
    robot.interrupt()
    assert robot.result["distance"] > 0.2
