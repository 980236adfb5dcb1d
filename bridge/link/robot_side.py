"""The robot side of the link: publishes frames, hands out the lease, takes actuator frames.

Actuator frames are decoded, and held against the lease, where they arrive, in Zenoh's receiving thread: the
last frame before a release is still the holder's. All publications are made by the loop's thread or a query's.
"""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable
from typing import Any, Final

import msgspec
import zenoh
from zenoh.handlers import Callback

from bridge.errors import FrameError, LeaseRefused
from bridge.link import keys
from bridge.link.lease import Holder, LeaseBook
from bridge.link.mailbox import Mailbox
from bridge.link.query import RateLimit, serve_query
from bridge.link.session import declare_publishers, open_robot, subscribe
from bridge.messages import (
    ActuatorFrame,
    Info,
    LeaseRequest,
    LedFrame,
    Notice,
    SensorFrame,
    WalkTelemetry,
    decode,
    encode,
)
from bridge.messages.topics import Message
from bridge.types import Closing

_QUEUE_SIZE: Final = 64
MAX_RATE: Final = 5000.0
"""1/s; actuator frames taken in the long run, several times the rate of lockstep."""
MAX_BURST: Final = 1000
"""Actuator frames taken at once, after an outage of the network."""
NOTICE_INTERVAL: Final = 1.0
"""s; the same kind of notice is published once per interval."""


class RobotLink(Closing):
    """Open link of a robot side; close it, or use it as a context manager.

    Args:
        info: of the robot; its `robot` is the id in every key.
        listen: Zenoh endpoint to listen on.
        announced: other parties see the robot at once; False: from `announce` on.
        beside: another robot's link of this process, whose endpoint this one shares; it is closed last.

    Raises:
        ConfigurationError: bad id or endpoint.
        LinkError: the endpoint cannot be listened on.
    """

    def __init__(
        self,
        info: Info,
        listen: str = keys.DEFAULT_ENDPOINT,
        *,
        announced: bool = True,
        beside: RobotLink | None = None,
    ) -> None:
        keys.check_name("Robot id", info.robot)
        self.info = info
        self.leases = LeaseBook(first=secrets.randbits(47))
        self._refused = 0
        self._rate = RateLimit(MAX_RATE, MAX_BURST)
        self._seq = 0
        self._notice_times: dict[str, float] = {}
        self._complaints: dict[str, str] = {}
        self._lock = threading.Lock()
        self._alive: zenoh.LivelinessToken | None = None
        self._shares = beside is not None
        self._session: zenoh.Session = open_robot(listen) if beside is None else beside._session
        try:
            self._declare()
            if announced:
                self.announce()
        except BaseException:
            self.close()
            raise

    def _declare(self) -> None:
        session, key = self._session, self._key
        self._publishers = declare_publishers(session, self.info.robot, "robot")
        self._actuators: Mailbox[ActuatorFrame] = Mailbox(_QUEUE_SIZE)
        self._telemetry: Mailbox[bytes] = Mailbox(_QUEUE_SIZE)
        self._leds: Mailbox[bytes] = Mailbox(1)
        self._subscribers = [
            subscribe(session, keys.topic_key(self.info.robot, kind), callback)
            for kind, callback in (
                (WalkTelemetry, self._telemetry.put),
                (LedFrame, self._leds.put),
            )
        ]
        self._actuators_key = keys.topic_key(self.info.robot, ActuatorFrame)
        self._subscribers.append(
            session.declare_subscriber(self._actuators_key, Callback(self._on_actuators, indirect=False))
        )
        self._tokens = session.liveliness().declare_subscriber(
            key(keys.ALIVE_CONTROLLERS), self._on_token, history=True
        )
        self._queryables: list[Any] = []
        self.serve(keys.INFO, lambda _: encode(self.info))
        self._queryables.append(serve_query(session, key(keys.LEASE), self._on_lease))

    def announce(self) -> None:
        """Declare the robot's liveliness token, once, after all its queries are served."""
        if self._alive is None:
            self._alive = self._session.liveliness().declare_token(self._key(keys.ALIVE_ROBOT))

    def _key(self, suffix: str) -> str:
        return keys.key(self.info.robot, suffix)

    @property
    def holder(self) -> Holder | None:
        """The controller that holds the robot."""
        return self.leases.holder

    def publish(self, message: Message) -> None:
        """Publish a message of one of the robot's `TOPICS`; a sensor frame gets the present wall clock."""
        if isinstance(message, SensorFrame):
            self._seq = message.seq
            message = msgspec.structs.replace(message, wall=time.time_ns())
        self._publishers[type(message)].put(encode(message))

    @property
    def refused(self) -> int:
        """Rejected actuator payloads: garbage, wrong lease, or refused by the guard."""
        return self._refused

    def commands(self) -> list[ActuatorFrame]:
        """The holder's actuator frames since the last call, in order; never waits."""
        self._publish_complaints()
        return self._actuators.drain()

    def wait_command(self, timeout: float) -> ActuatorFrame | None:
        """The holder's next actuator frame; None after `timeout` s, at a granted lease, or at `wake`."""
        self._publish_complaints()
        return self._actuators.take(timeout)

    def wake(self) -> None:
        """End a `wait_command` without a command; any thread may call this."""
        self._actuators.wake()

    def telemetry(self) -> list[WalkTelemetry]:
        """The walker's telemetry since the last call, in order; never waits."""
        messages = []
        for payload in self._telemetry.drain():
            try:
                messages.append(decode(payload, WalkTelemetry))
            except FrameError as error:
                self.notice("telemetry-refused", str(error))
        return messages

    def leds(self) -> LedFrame | None:
        """The newest lights since the last call, or None; never waits."""
        try:
            return decode(payload, LedFrame) if (payload := next(iter(self._leds.drain()), None)) else None
        except FrameError as error:
            self.notice("leds-refused", str(error))
            return None

    def notice(self, code: str, text: str) -> None:
        """Publish a warning of one sentence; one of each code per `NOTICE_INTERVAL`."""
        now = time.monotonic()
        with self._lock:
            if now - self._notice_times.get(code, -NOTICE_INTERVAL) < NOTICE_INTERVAL:
                return
            self._notice_times[code] = now
        self.publish(Notice(seq=self._seq, level="warning", code=code, text=text))

    def require_lease(self, lease: int, command: str) -> None:
        """Accept a sign of life of the holder, or refuse a command with another number; any thread may call it.

        Raises:
            LeaseRefused: names the command and the holder.
        """
        if not self.leases.keepalive(lease, time.monotonic()):
            raise self._refusal(command)

    def _require_seal(self, key: str, payload: bytes, attachment: bytes, command: str) -> None:
        """Refuse a message that the holder did not seal, or a second copy of one.

        Raises:
            LeaseRefused: names the command and the holder.
        """
        holder = self.leases.holder
        if holder is None:
            raise self._refusal(command)
        if not holder.seal.opens(key, payload, attachment):
            raise LeaseRefused(
                f"{command} was refused: controller `{holder.name}` holds the robot, and the seal is not of "
                "its key, or not a new one; seal with the key of the lease, or ask for the lease."
            )

    def _refusal(self, command: str) -> LeaseRefused:
        holder = self.leases.holder
        who = f"controller `{holder.name}` holds the robot" if holder else "no controller holds the robot"
        return LeaseRefused(f"{command} without the lease was refused: {who}; ask for the lease.")

    def refuse(self, code: str, text: str) -> None:
        """Count a rejected actuator frame; the next notice gives its sender the reason."""
        with self._lock:
            self._refused += 1
            self._complaints[code] = text

    def _publish_complaints(self) -> None:
        """Publish the complaints of the receiving thread."""
        with self._lock:
            complaints, self._complaints = self._complaints, {}
        for code, text in complaints.items():
            self.notice(code, text)

    def serve(self, suffix: str, answer: Callable[[bytes], bytes], *, sealed: bool = False) -> None:
        """Answer queries on `suffix`; an error of `answer` becomes an error reply with one sentence.

        Args:
            suffix: key below the robot's.
            answer: called in a thread of its own with the query's payload (empty when there is none).
            sealed: the holder of the lease only may ask.
        """
        key = self._key(suffix)

        def checked(payload: bytes, attachment: bytes) -> bytes:
            if sealed:
                self._require_seal(key, payload, attachment, f"A `{suffix}` command")
            return answer(payload)

        self._queryables.append(serve_query(self._session, key, checked))

    def _on_actuators(self, sample: zenoh.Sample) -> None:
        payload, attachment = sample.payload.to_bytes(), sample.attachment
        if not self._rate.admits(time.monotonic()):
            self.refuse(
                "flood", f"Actuator frames come faster than {MAX_RATE:g} per second; the rest is dropped."
            )
            return
        try:
            frame = decode(payload, ActuatorFrame)
        except FrameError as error:
            self.refuse("frame-refused", str(error))
            return
        try:
            seal = attachment.to_bytes() if attachment else b""
            self._require_seal(self._actuators_key, payload, seal, "An actuator frame")
            self.require_lease(frame.lease, "An actuator frame")
        except LeaseRefused as error:
            self.refuse("no-lease", str(error))
            return
        self._actuators.put(frame)

    def _on_lease(self, payload: bytes, attachment: bytes) -> bytes:
        request = decode(payload, LeaseRequest)
        if request.op == "status":
            return encode(self.leases.status())
        seal = self.leases.seal(request.key)
        if not seal.opens(self._key(keys.LEASE), payload, attachment):
            raise LeaseRefused(
                f"The request to {request.op} was refused: its seal is not of its key, or not a new one."
            )
        if request.op == "acquire":
            reply = self.leases.acquire(request.controller, seal, time.monotonic(), direct=request.direct)
            if reply.granted:
                self._actuators.wake()
        else:
            reply = self.leases.release(seal)
        return encode(reply)

    def _on_token(self, sample: zenoh.Sample) -> None:
        if sample.kind != zenoh.SampleKind.DELETE:
            return
        name, _, public = str(sample.key_expr).rpartition("/")[2].rpartition(".")
        ended = self.leases.on_token_lost(public)
        if ended and not self._session.is_closed():  # a session that closes loses every token
            self.notice("controller-gone", f"Controller `{name}` is gone; the robot is free.")

    def close(self) -> None:
        """Leave the network; further calls do nothing."""
        if not self._shares:
            self._session.close()
        elif self._alive is not None:
            self._alive.undeclare()
            self._alive = None
