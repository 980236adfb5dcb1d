"""What the robot's side may rely on: one sender's frames are judged in the order of their sending."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec
import pytest
import zenoh

from bridge.link import ControllerLink, RobotLink
from bridge.link.session import MAX_RECEIVED, open_client
from bridge.messages import ActuatorFrame, LeaseReply, LeaseRequest, decode, encode
from tests.frames import info_of_robot, walk_telemetry
from tests.loops import TIMEOUT, until

INFO = info_of_robot(mode="lockstep")
ZEROS = (0.0,) * 25
COMMAND = ActuatorFrame(reply_to=0, position=ZEROS, stiffness=ZEROS)


@pytest.fixture
def robot(endpoint: str) -> Iterator[RobotLink]:
    with RobotLink(INFO, endpoint) as link:
        yield link


@pytest.fixture
def controller(robot: RobotLink, endpoint: str) -> Iterator[ControllerLink]:
    with ControllerLink(connect=endpoint) as link:
        assert link.wait_robot(timeout=TIMEOUT) == INFO
        yield link


@pytest.fixture
def stranger(robot: RobotLink, endpoint: str) -> Iterator[zenoh.Session]:
    session = open_client(endpoint)
    yield session
    session.close()


def test_the_last_frame_before_a_release_is_still_the_holders(
    robot: RobotLink, controller: ControllerLink
) -> None:
    for seq in range(100):
        controller.acquire()
        controller.send(msgspec.structs.replace(COMMAND, reply_to=seq))
        controller.release()
        assert [command.reply_to for command in robot.commands()] == [seq]
    assert robot.refused == 0


def test_telemetry_is_there_when_the_answer_it_was_sent_before_is(
    robot: RobotLink, controller: ControllerLink
) -> None:
    controller.acquire()
    robot.wait_command(0.0)  # the grant ends one wait
    for seq in range(200):
        controller.publish_telemetry(walk_telemetry(seq))
        controller.send(msgspec.structs.replace(COMMAND, reply_to=seq))
        command = robot.wait_command(TIMEOUT)
        assert command is not None
        assert [t.seq for t in robot.telemetry()] == [command.reply_to] == [seq]


def test_a_payload_that_would_fill_the_memory_is_dropped_by_the_transport(
    robot: RobotLink, controller: ControllerLink, stranger: zenoh.Session
) -> None:
    controller.acquire()
    # behind so large a payload the queue is full, and a put that does not wait is dropped there
    wait = zenoh.CongestionControl.BLOCK
    stranger.put("nao/nao/actuators", b"\x00" * (2 * MAX_RECEIVED), congestion_control=wait)
    stranger.put("nao/nao/actuators", b"", congestion_control=wait)
    until(lambda: robot.refused, "the small one after it")
    assert robot.refused == 1
    controller.send(COMMAND)
    until(robot.commands, "the good frame")


def test_the_status_tells_a_listener_who_holds_the_robot(
    controller: ControllerLink, stranger: zenoh.Session
) -> None:
    controller.acquire()
    request = encode(LeaseRequest(op="status", controller="listener"))
    (reply,) = stranger.get("nao/nao/lease", payload=request)
    status = decode(reply.ok.payload.to_bytes(), LeaseReply)
    assert (status.granted, status.lease, status.holder) == (False, 0, "walker")
