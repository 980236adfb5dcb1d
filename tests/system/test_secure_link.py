"""Mutual TLS and access control over real sockets: who may listen, who may command, who may touch the world."""

from __future__ import annotations

import contextlib
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import zenoh

from bridge.errors import ConfigurationError, LinkError
from bridge.link import ControllerLink, RobotLink, keys
from bridge.link.certificates import ROLES, with_keys
from bridge.link.session import open_client, subscribe, try_client
from bridge.messages import ActuatorFrame, LeaseRequest, Notice, TruthFrame, encode
from nao_hil.certificates import Keys
from tests.frames import info_of_robot, standing_frame
from tests.loops import TIMEOUT, until

INFO = info_of_robot()
ZEROS = (0.0,) * 25
SENSORS = standing_frame()
COMMAND = ActuatorFrame(reply_to=0, position=ZEROS, stiffness=ZEROS)
LEASE_STATUS = encode(LeaseRequest(op="status", controller="thief"))
"""A question that the robot answers to all whose query reaches it."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("keys")
    authority = Keys(where)
    for role in ROLES:
        authority.issue(role, days=1.0)
    return where


@pytest.fixture
def place(endpoint: str, folder: Path) -> str:
    return with_keys(endpoint.replace("tcp/", "tls/"), folder)


@pytest.fixture
def robot(place: str) -> Iterator[RobotLink]:
    with RobotLink(INFO, place) as link:
        link.serve("world/command", lambda _: b"done")
        yield link


@pytest.fixture
def session(robot: RobotLink, place: str) -> Iterator[Callable[[str], zenoh.Session]]:
    with contextlib.ExitStack() as stack:

        def open_as(role: str) -> zenoh.Session:
            return stack.enter_context(contextlib.closing(open_client(place, role=role)))

        yield open_as


def ask(session: zenoh.Session, suffix: str, payload: bytes = b"", timeout: float = TIMEOUT) -> bytes | None:
    for reply in session.get(keys.key("nao", suffix), payload=payload, timeout=timeout):
        if reply.ok is not None:
            return bytes(reply.ok.payload.to_bytes())
    return None


def test_a_controller_commands(robot: RobotLink, place: str) -> None:
    with ControllerLink(connect=place) as link:
        assert link.wait_robot(timeout=TIMEOUT) == INFO
        link.acquire()
        link.send(COMMAND)
        until(lambda: robot.commands(), "the command")
        robot.publish(SENSORS)
        frame = link.next(TIMEOUT)
        assert frame is not None and frame.seq == 0
    until(lambda: robot.holder is None, "the end of the lease with its holder")


def test_a_listener_hears_all_and_commands_nothing(
    robot: RobotLink, session: Callable[[str], zenoh.Session]
) -> None:
    listener, heard = session("listener"), list[str]()
    subscriber = listener.declare_subscriber("nao/nao/**", lambda sample: heard.append(str(sample.key_expr)))
    until(lambda: robot.publish(SENSORS) or "nao/nao/sensors" in heard, "a sensor frame")
    robot.publish(Notice(seq=0, level="info", code="test", text="A test."))
    until(lambda: "nao/nao/notices" in heard, "a notice")
    assert ask(listener, keys.INFO) == encode(INFO)
    assert ask(listener, keys.LEASE, LEASE_STATUS, timeout=0.5) is None
    assert ask(listener, "world/command", timeout=0.5) is None
    token = listener.liveliness().declare_token("nao/nao/alive/robot")
    for _ in range(20):
        listener.put("nao/nao/actuators", encode(COMMAND))
        listener.put("nao/nao/sensors", encode(SENSORS))
    assert ask(listener, keys.INFO) is not None  # on the same link, behind what was sent
    assert robot.holder is None and not robot.commands() and robot.refused == 0
    token.undeclare()
    subscriber.undeclare()


def test_a_controller_sees_no_truth_and_does_not_touch_the_world(
    robot: RobotLink, session: Callable[[str], zenoh.Session]
) -> None:
    controller, heard = session("controller"), list[bytes]()
    subscribers = [
        subscribe(controller, f"nao/nao/{k}", heard.append) for k in ("sensors", "world/truth", "**")
    ]
    until(lambda: robot.publish(SENSORS) or heard, "a sensor frame")
    heard.clear()
    robot._publishers[TruthFrame].put(b"truth")
    until(lambda: robot.publish(SENSORS) or heard, "a sensor frame behind the truth")
    assert b"truth" not in heard
    assert ask(controller, "world/command", timeout=0.5) is None
    assert len(subscribers) == 3


def test_a_world_operator_touches_the_world_and_does_not_command(
    robot: RobotLink, session: Callable[[str], zenoh.Session]
) -> None:
    operator = session("world")
    assert ask(operator, "world/command") == b"done"
    assert ask(operator, keys.LEASE, LEASE_STATUS, timeout=0.5) is None
    assert robot.holder is None


def test_without_a_certificate_nobody_gets_in(robot: RobotLink, endpoint: str, place: str) -> None:
    with pytest.raises(ConfigurationError, match=r"add --keys DIR"):
        try_client(endpoint.replace("tcp/", "tls/"))
    with pytest.raises(ConfigurationError, match=r"write tls/127\.0\.0\.1:\d+ in place of tcp/"):
        try_client(place.replace("tls/", "tcp/"))
    # In plain text at the encrypted port: as if nobody listened.
    assert try_client(endpoint) is None


def test_another_authority_is_told_who_does_not_trust_whom(
    robot: RobotLink, endpoint: str, tmp_path: Path
) -> None:
    foreign = Keys(tmp_path)
    foreign.issue("controller", days=1.0)
    with pytest.raises(LinkError, match="is not trusted: it is of another authority"):
        try_client(with_keys(endpoint.replace("tcp/", "tls/"), tmp_path), "controller")


def test_a_certificate_of_a_foreign_authority_that_trusts_the_robot_is_refused(
    robot: RobotLink, endpoint: str, folder: Path, tmp_path: Path
) -> None:
    # Its `ca.pem` holds both authorities: its own files fit together, and it trusts the robot.
    foreign = Keys(tmp_path)
    foreign.issue("controller", days=1.0)
    both = tmp_path / "controller" / "ca.pem"
    both.write_bytes(both.read_bytes() + (folder / "ca" / "certificate.pem").read_bytes())
    with pytest.raises(LinkError, match=r"refuses .*certificate.pem: .*unknown ca"):
        try_client(with_keys(endpoint.replace("tcp/", "tls/"), tmp_path), "controller")


def test_a_robot_under_another_name_is_not_trusted(endpoint: str, folder: Path) -> None:
    port = endpoint.rpartition(":")[2]
    place = with_keys(f"tls/127.0.0.2:{port}", folder)
    words = r"not trusted: its certificate is not made for 127\.0\.0\.2; .*--host 127\.0\.0\.2"
    with RobotLink(INFO, place), pytest.raises(LinkError, match=words):
        try_client(place)


def test_a_session_ends_with_its_certificate_and_who_waits_again_is_told(
    endpoint: str, folder: Path, tmp_path: Path
) -> None:
    shutil.copytree(folder / "ca", tmp_path / "ca")
    shutil.copytree(folder / "robot", tmp_path / "robot")
    place = with_keys(endpoint.replace("tcp/", "tls/"), tmp_path)
    with RobotLink(INFO, place) as robot, ControllerLink(connect=place) as controller:
        began = time.monotonic()
        with ControllerLink(connect=with_keys(place.partition("#")[0], folder)) as lasting:
            assert lasting.wait_robot(timeout=TIMEOUT) == INFO
        span = 8.0 + 10.0 * (time.monotonic() - began)  # s, in which this machine connects
        issued = time.monotonic()
        Keys(tmp_path).issue("controller", days=span / 86400.0)
        assert controller.wait_robot(timeout=TIMEOUT) == INFO
        controller.acquire()
        until(lambda: robot.holder is None, "the end of the lease with the certificate")
        assert time.monotonic() - issued > span - 1.0
        until(lambda: not controller.robot_alive, "the session to end")
        with pytest.raises(ConfigurationError, match=r"it has expired; .* --renew"):
            controller.wait_robot(timeout=TIMEOUT)
