"""The controller side of the link: finds the robot, asks for the lease, receives frames, sends commands."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final, Literal

import msgspec
import zenoh

from bridge.errors import FrameError, LeaseRefused, LinkError, RobotSilent
from bridge.link import keys
from bridge.link.certificates import check_certificates
from bridge.link.mailbox import Mailbox
from bridge.link.query import ask, serve_query
from bridge.link.seal import KeyPair, Seal
from bridge.link.session import Search, check_endpoint, declare_publishers, other_robots, subscribe, try_client
from bridge.messages import (
    ActuatorFrame,
    Info,
    LeaseReply,
    LeaseRequest,
    Notice,
    SensorFrame,
    decode,
    encode,
)
from bridge.messages.guard import GuardStatus
from bridge.messages.topics import Message
from bridge.messages.walk import UpperBody
from bridge.types import Closing

_QUEUE_SIZE: Final = 64
_QUERY_TIMEOUT: Final = 5.0
"""s a query may take, to a robot that is starved or stands still for a while."""
_RETRY_INTERVAL: Final = 0.05
"""s between two attempts to find the robot."""
_WORLD_LOOKS: Final = 30
"""Looks, `_RETRY_INTERVAL` apart, within which the robots of one world announce themselves, one after another;
a time would also pass while this process or the whole machine stands still."""


class ControllerLink(Closing):
    """Link of a controller; close it, or use it as a context manager.

    Making it does not connect: `wait_robot` does, and from then on the link connects again by itself whenever
    the robot is back.

    Args:
        robot: id of the robot.
        connect: Zenoh endpoint of the robot.
        name: of this controller.
        direct: it serves another robot's protocol, see `LeaseRequest`.

    Raises:
        ConfigurationError: bad id, name or endpoint.
    """

    def __init__(
        self,
        robot: str = keys.DEFAULT_ROBOT,
        connect: str = keys.DEFAULT_ENDPOINT,
        name: str = "walker",
        *,
        direct: bool = False,
    ) -> None:
        self.robot = keys.check_name("Robot id", robot)
        self.name = keys.check_name("Controller name", name)
        self.endpoint = check_endpoint(connect)
        self._direct = direct
        self.lease = 0
        """Number of the lease; 0: none is held."""
        self._asked = False
        """The robot may have granted the lease."""
        self._keys = KeyPair()
        self._seal: Seal | None = None
        self._alive = threading.Event()
        self._sensors: Mailbox[bytes] = Mailbox(_QUEUE_SIZE)
        self._notices: Mailbox[bytes] = Mailbox(_QUEUE_SIZE)
        self._upper: Mailbox[bytes] = Mailbox(1)
        self._session: zenoh.Session | None = None
        self._served: dict[str, Callable[[bytes], bytes]] = {}
        self._queryables: list[Any] = []

    def serve(self, suffix: str, answer: Callable[[bytes], bytes]) -> None:
        """Answer queries on `suffix` as long as the link is open; before `wait_robot`.

        Args:
            suffix: key below the robot's.
            answer: called in a thread of its own with the query's payload; its error is the reply.
        """
        self._served[suffix] = answer

    def _connect(self) -> bool:
        """Try to connect once, if there is no connection yet; whether there is one."""
        if self._session is None:
            self._session = try_client(self.endpoint, "controller")
            if self._session is not None:
                self._declare(self._session)
        return self._session is not None

    def _declare(self, session: zenoh.Session) -> None:
        key = self._key
        self._subscribers = [
            subscribe(session, keys.topic_key(self.robot, kind), mailbox.put)
            for kind, mailbox in (
                (SensorFrame, self._sensors),
                (Notice, self._notices),
                (UpperBody, self._upper),
            )
        ]
        self._publishers = declare_publishers(session, self.robot, "controller")
        self._declare_token(session)
        self._robot_token = session.liveliness().declare_subscriber(
            key(keys.ALIVE_ROBOT), self._on_robot, history=True
        )
        self._queryables = [
            serve_query(session, key(suffix), partial(_answer, answer))
            for suffix, answer in self._served.items()
        ]

    def _declare_token(self, session: zenoh.Session) -> None:
        suffix = keys.alive_controller(self.name, self._keys.public)
        self._token = session.liveliness().declare_token(self._key(suffix))

    def _key(self, suffix: str) -> str:
        return keys.key(self.robot, suffix)

    def _on_robot(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.DELETE:
            self._alive.clear()
            self.lease, self._asked = 0, False
            self._sensors.wake()
        else:
            self._alive.set()

    @property
    def robot_alive(self) -> bool:
        """Whether the robot's liveliness token is there."""
        return self._alive.is_set()

    def wait_robot(self, stop: Callable[[], bool] = lambda: False, timeout: float | None = None) -> Info | None:
        """Wait until the robot answers; its `Info`, or None after `stop()` is true.

        Without a `timeout` the log names a robot that is missing, and those that are there.

        Raises:
            LinkError: no such robot within `timeout` s; sooner if there is another one.
            FrameError: it speaks another version of the contract.
            ConfigurationError: the certificates cannot be used, for example because they expired meanwhile.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        looks = 0
        search = Search(self.robot, self.endpoint)
        while not stop():
            if not self._connect():
                time.sleep(_RETRY_INTERVAL)
            elif self._alive.wait(_RETRY_INTERVAL):
                payload = self._get(keys.INFO, b"")
                if payload is not None:
                    return decode(payload, Info)
            else:
                check_certificates(self.endpoint, "controller")
                if deadline is not None and (others := self._other_robots()):
                    looks += 1
                    if looks < _WORLD_LOOKS and time.monotonic() < deadline:
                        continue
                    raise LinkError(f"There is no robot `{self.robot}` at {self.endpoint}{others}.")
            if deadline is None:
                search.failed(self._session)
            elif time.monotonic() > deadline:
                raise LinkError(
                    f"No robot `{self.robot}` answered at {self.endpoint} within {timeout:g} s; start one with "
                    "`nao-hil emulate`, or give its address with --connect."
                )
        return None

    def _other_robots(self) -> str:
        return other_robots(self._session, self.robot) if self._session is not None else ""

    def acquire(self) -> None:
        """Ask for the lease, which the actuator frames then carry; sensor frames from before are dropped.

        Raises:
            LeaseRefused: another controller holds the robot; names it.
            RobotSilent: no answer.
            LinkError: the robot's reason for an error reply.
        """
        reply = self._ask("status")
        if not reply.key:
            raise LeaseRefused(reply.message)
        if self._seal is None or self._seal.peer != reply.key:  # the first time, or the robot was restarted
            self._seal = self._keys.seal(reply.key)
        self._sensors.drain()
        self._asked = True
        reply = self._ask("acquire")
        if not reply.granted:
            raise LeaseRefused(reply.message)
        self.lease = reply.lease

    def release(self) -> None:
        """Give the lease back, if it may be held and the robot is there."""
        self.lease = 0  # before the robot answers: no further command carries it
        if self._asked:
            with contextlib.suppress(RobotSilent):
                self._ask("release")
                self._asked = False

    def abandon(self) -> None:
        """Leave the robot without giving it back, as a dead controller does: its guard's watchdog counts."""
        self.lease = 0
        if self._session is not None and self._asked:
            self._token.undeclare()
            self._keys, self._seal = KeyPair(), None
            self._declare_token(self._session)
            self._asked = False

    def _ask(self, op: Literal["acquire", "release", "status"]) -> LeaseReply:
        request = LeaseRequest(op=op, controller=self.name, key=self._keys.public, direct=self._direct)
        return decode(self.query(keys.LEASE, encode(request)), LeaseReply)

    def query(self, suffix: str, payload: bytes = b"") -> bytes:
        """Any query of the contract.

        Raises:
            RobotSilent: no answer.
            LinkError: an error reply, whose sentence it carries.
        """
        answer = self._get(suffix, payload)
        if answer is None:
            raise RobotSilent(f"Robot `{self.robot}` at {self.endpoint} does not answer `{suffix}`.")
        return answer

    def _get(self, suffix: str, payload: bytes) -> bytes | None:
        if self._session is None:
            return None
        return ask(self._session, self._key(suffix), payload, _QUERY_TIMEOUT, LinkError, self._seal)

    def held(self) -> tuple[float, ...]:
        """25 joint angles commanded last, rad, a safe first command.

        Empty: the joints have been left alone, or the robot has no guard that answers.
        """
        try:
            return decode(self.query(keys.GUARD), GuardStatus).position
        except LinkError:
            return ()

    def next(self, timeout: float) -> SensorFrame | None:
        """The next sensor frame in order; None after `timeout` s or without the robot.

        Raises:
            FrameError: the robot sent something else.
        """
        payload = self._sensors.take(timeout)
        return decode(payload, SensorFrame) if payload is not None else None

    def latest(self, timeout: float) -> SensorFrame | None:
        """The newest sensor frame, older ones dropped; None after `timeout` s or without the robot.

        Raises:
            FrameError: the robot sent something else.
        """
        payload = self._sensors.take(timeout)
        for newer in self._sensors.drain():
            payload = newer
        return decode(payload, SensorFrame) if payload is not None else None

    def wake(self) -> None:
        """End a `next` or `latest` without a frame; a signal handler may call this."""
        self._sensors.wake()

    def send(self, frame: ActuatorFrame) -> None:
        """Publish an actuator frame with lease, seal and present wall clock; `acquire` comes first."""
        payload = encode(msgspec.structs.replace(frame, lease=self.lease, wall=time.time_ns()))
        if self._session is not None and self._seal is not None:
            put = self._publishers[ActuatorFrame].put
            key = keys.topic_key(self.robot, ActuatorFrame)
            self._seal.send(key, payload, lambda attachment: put(payload, attachment=attachment))

    def publish(self, message: Message) -> None:
        """Publish a message of one of a controller's `TOPICS`; nothing happens without a connection."""
        if self._session is not None:
            self._publishers[type(message)].put(encode(message))

    def upper_body(self) -> UpperBody | None:
        """The newest such command since the last call, or None; never waits.

        Raises:
            FrameError: another message.
        """
        payloads = self._upper.drain()
        return decode(payloads[-1], UpperBody) if payloads else None

    def notices(self) -> list[Notice]:
        """The robot's notices since the last call; never waits."""
        notices = []
        for payload in self._notices.drain():
            try:
                notices.append(decode(payload, Notice))
            except FrameError:
                continue  # from another program; the robot side sends only valid ones
        return notices

    def close(self) -> None:
        """Leave the network; the token disappears, and with it the lease."""
        if self._session is not None:
            self._session.close()


def _answer(answer: Callable[[bytes], bytes], payload: bytes, _: bytes) -> bytes:
    """Answer of a query that takes no seal."""
    return answer(payload)
