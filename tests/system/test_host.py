"""A robot side of one's own: `RobotHost` between a robot and a real link on loopback."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import msgspec
import pytest

from bridge.body import load_body
from bridge.body.joints import N_JOINTS
from bridge.body.postures import POSTURES
from bridge.errors import LinkError
from bridge.guard import Guard, GuardSettings
from bridge.host import RobotHost, robot_info
from bridge.link import ControllerLink, RobotLink
from bridge.messages import ActuatorFrame, SensorFrame
from tests.frames import info_of_robot, standing_frame
from tests.loops import TIMEOUT, repeat_while, until

BODY = load_body("nao-v6")
STAND = POSTURES["StandInit"]


def sensors(seq: int) -> SensorFrame:
    return standing_frame(seq, time=BODY.cycle * seq, position=STAND)


@contextmanager
def echo(endpoint: str, name: str) -> Iterator[ControllerLink]:
    """A controller that answers every frame with a stand."""
    ended = threading.Event()
    with ControllerLink("nao", endpoint, name) as link:
        link.wait_robot(timeout=TIMEOUT)
        link.acquire()

        def serve() -> None:
            for _ in repeat_while(lambda: not ended.is_set(), 100_000):
                frame = link.next(0.05)
                if frame is not None:
                    link.send(ActuatorFrame(reply_to=frame.seq, position=STAND, stiffness=(1.0,) * N_JOINTS))

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield link
        finally:
            ended.set()
            thread.join()


@contextmanager
def hosted(endpoint: str, *, dry_run: bool = False) -> Iterator[RobotHost]:
    info = info_of_robot(body=BODY.name, side="lola", cycle=BODY.cycle)
    with RobotLink(info, endpoint) as link:
        yield RobotHost(link, Guard(BODY, dry_run=dry_run), dry_run=dry_run)


def test_each_frame_gets_its_answer_until_the_controller_is_silent_and_another_takes_over(
    endpoint: str,
) -> None:
    dog = GuardSettings().watchdog
    with hosted(endpoint) as host:
        assert host.exchange(sensors(0)) is None
        with echo(endpoint, "first"):
            for seq in range(1, 6):
                given = host.exchange(sensors(seq), wait=TIMEOUT)
                assert given is not None and given.reply_to == seq
                assert given.position == STAND
            assert (host.in_force, host.missed) == (5, 0)
        # it has left without giving the robot back
        until(lambda: host.link.leases.abandoned, "its lease to be abandoned")
        assert host.supervised and host.needs_cycle and host.link.holder is None
        given = None
        for seq in range(6, 6 + dog.silence_cycles + dog.hold_cycles):
            assert given is None
            given = host.exchange(sensors(seq))
        assert host.guard.state == "crouch"
        assert given is not None and given.reply_to == 5
        with echo(endpoint, "second"):
            given = host.exchange(sensors(1000), wait=TIMEOUT)
            assert given is not None and given.reply_to == 1000
            assert host.guard.state in ("approach", "active") and not host.needs_cycle


def test_a_dry_run_guards_and_gives_nothing_out(endpoint: str) -> None:
    with hosted(endpoint, dry_run=True) as host, echo(endpoint, "program"):
        for seq in range(5):
            assert host.exchange(sensors(seq), wait=TIMEOUT) is None
        assert host.guard.state == "active"
        assert host.in_force == -1


@pytest.mark.parametrize("payload", [b"", b"\x80"])
def test_a_stop_of_no_words_is_a_stop(payload: bytes, endpoint: str) -> None:
    with hosted(endpoint) as host, ControllerLink("nao", endpoint, "person") as person:
        person.wait_robot(timeout=TIMEOUT)
        asked = threading.Thread(target=lambda: person.query("stop", payload))
        asked.start()
        seqs = iter(range(1 << 30))
        until(lambda: host.exchange(sensors(next(seqs))) or not host.guard.armed, "the stop")
        asked.join()
        assert host.guard.status.reason == "stop"


def test_a_refused_frame_leaves_the_valid_one_before_it_in_force(endpoint: str) -> None:
    """And what is refused or clipped is told, also of a frame that another one overtook in the same cycle."""
    with hosted(endpoint) as host, ControllerLink("nao", endpoint, "hasty") as link:
        link.wait_robot(timeout=TIMEOUT)
        link.acquire()
        good = ActuatorFrame(reply_to=0, position=STAND, stiffness=(1.0,) * N_JOINTS)
        link.send(msgspec.structs.replace(good, position=(9.0, *STAND[1:])))
        link.send(good)
        link.send(msgspec.structs.replace(good, stiffness=(7.0,) * N_JOINTS))
        commands: list[ActuatorFrame] = []
        until(lambda: commands.extend(host.link.commands()) or len(commands) == 3)
        accepted = host.admit(commands, 0)
        assert accepted is not None and accepted.position == host.guard.check(good, 0).position
        host.link.commands()  # tells
        told: set[str] = set()
        until(lambda: told.update(notice.code for notice in link.notices()) or len(told) == 2)
        assert told == {"clipped", "frame-refused"} and host.link.refused == 1


def test_the_guard_answers_as_soon_as_the_robot_is_there(endpoint: str) -> None:
    """Its token comes last; what it serves is served then."""
    info = robot_info(BODY, robot="nao", side="lola", mode="real-time", software="")
    with RobotLink(info, endpoint, announced=False) as link, ControllerLink("nao", endpoint, "early") as early:
        assert early.wait_robot(stop=lambda: True) is None
        with pytest.raises(LinkError):
            early.wait_robot(timeout=0.3)
        RobotHost(link, Guard(BODY))
        link.announce()
        early.wait_robot(timeout=TIMEOUT)
        assert early.query("guard")
