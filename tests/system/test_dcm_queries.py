"""A DCM program over the link: the `dcm/` queries reach the robot's loop, in real time and in lockstep."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import msgspec
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.errors import LinkError
from bridge.guard import Guard
from bridge.link import ControllerLink, RobotLink
from bridge.messages import ActuatorFrame, SensorFrame, decode
from bridge.messages import dcm as wire

pytest.importorskip("pybullet")

from emulator.process import RobotSide, WorldProcess
from emulator.robot import EmulatedRobot
from emulator.timing import CycleTimer
from tests.frames import info_of_robot
from tests.loops import TIMEOUT, until
from tests.ports import free_endpoint

BODY = load_body("nao-v3")
LED = "ChestBoard/Led/Red/Actuator/Value"
ELBOW = "LElbowYaw/Position/Actuator/Value"
SLOT = INDEX["LElbowYaw"]


@contextmanager
def running_robot(mode: str) -> Iterator[str]:
    """A robot's process in a thread, held in the air; gives its endpoint."""
    endpoint, stop = free_endpoint(), threading.Event()
    info = info_of_robot(body=BODY.name, mode=mode, cycle=BODY.cycle)
    robot = EmulatedRobot(BODY, seed=0, posture="Stand", held=True, lift=0.3, settle=0.1)
    with robot, RobotLink(info, endpoint) as link:
        process = WorldProcess([RobotSide(robot, link, Guard(BODY), [])], stop)
        loop = (lambda: process.real_time(CycleTimer(BODY.cycle))) if mode == "real-time" else process.lockstep
        thread = threading.Thread(target=loop)
        thread.start()
        try:
            yield endpoint
        finally:
            stop.set()
            thread.join(TIMEOUT)
            assert not thread.is_alive()


@contextmanager
def controller(endpoint: str, name: str = "program", lease: bool = True) -> Iterator[ControllerLink]:
    with ControllerLink("nao", endpoint, name) as link:
        link.wait_robot(timeout=TIMEOUT)
        if lease:
            link.acquire()
        yield link


def ask(link: ControllerLink, key: str, **fields: Any) -> Any:
    payload = msgspec.msgpack.encode({"version": 3, **fields})

    def answer() -> bytes | None:
        try:
            return link.query(key, payload)
        except LinkError as error:
            if "send it again" in str(error):  # the robot's loop had no processor for that long
                return None
            raise

    return decode(until(answer, f"an answer to {key}"), wire.DcmReply).result


def command(link: ControllerLink, key: str, *items: Any) -> Any:
    return ask(link, key, lease=link.lease, command=list(items))


def test_a_dcm_program_moves_the_robot_in_real_time() -> None:
    with running_robot("real-time") as endpoint, controller(endpoint) as link:
        names = [wire.PREFIX + ELBOW, "RHipYawPitch/Position/Actuator/Value", "LHand/Position/Actuator/Value"]
        assert command(link, wire.CREATE_ALIAS, "JointAngles", names) == ["JointAngles", [*names[:2], ""]]
        begin = ask(link, wire.GET_TIME, offset=50)
        mixed = [[[-0.5, begin], [-1.0, begin + 200]], [[0.3, begin]], [[1.0, begin]]]
        assert command(link, wire.SET_ALIAS, "JointAngles", "ClearAll", "time-mixed", mixed) is None
        read = pytest.approx(-1.0, abs=1e-4)
        until(lambda: ask(link, wire.READ, names=[ELBOW]) == [read], "the end of the command")
        assert ask(link, wire.GET_TIME) - begin >= 200

        def turned() -> bool:
            frame = link.latest(TIMEOUT)
            return frame is not None and frame.position[SLOT] == pytest.approx(-1.0, abs=0.06)

        until(turned, "the elbow to turn")


def step(link: ControllerLink, frame: SensorFrame) -> SensorFrame:
    """Answer a frame; the one after it."""
    link.send(ActuatorFrame(reply_to=frame.seq, position=POSTURES["Stand"], stiffness=(1.0,) * 25))

    def newer() -> SensorFrame | None:
        other = link.next(TIMEOUT)
        return other if other is not None and other.seq > frame.seq else None

    result: SensorFrame = until(newer, "the next frame")
    return result


def test_in_lockstep_only_the_answer_to_the_present_frame_moves_the_robot() -> None:
    with running_robot("lockstep") as endpoint, controller(endpoint) as link:
        frame = link.latest(TIMEOUT)
        assert frame is not None
        for other in (frame.seq + 1, frame.seq + 5, frame.seq - 1):
            link.send(ActuatorFrame(reply_to=other, position=POSTURES["Stand"], stiffness=(1.0,) * 25))
        ask(link, wire.GET_TIME)  # behind the answers on the same link
        later = link.next(0.5)  # the robot repeats the frame that has no answer
        assert later is None or later.seq == frame.seq
        assert step(link, frame).seq == frame.seq + 1


def test_in_lockstep_queries_are_answered_while_the_robot_waits() -> None:
    with running_robot("lockstep") as endpoint, controller(endpoint) as link:
        now = ask(link, wire.GET_TIME)
        command(link, wire.SET, LED, "ClearAll", [[0.0, now], [1.0, now + 40]])
        assert ask(link, wire.READ, names=[LED]) == [0.0]
        assert ask(link, wire.GET_TIME) == now
        seen = []
        frame = link.latest(TIMEOUT)
        assert frame is not None
        for _ in range(5):
            frame = step(link, frame)
            seen += ask(link, wire.READ, names=[LED])
        assert seen == [0.0, 0.25, 0.5, 0.75, 1.0]
        assert ask(link, wire.GET_TIME) == now + 50
