"""A running robot as the page has it: its messages, and the commands to it."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Final, Protocol, TypeVar

import zenoh

from bridge.errors import FrameError, NaoHilError
from bridge.link import keys
from bridge.link.client import GuardClient, WalkClient, WorldClient
from bridge.link.mailbox import Mailbox
from bridge.link.session import subscribe, try_client
from bridge.messages import ActuatorFrame, Info, Notice, SensorFrame, TruthFrame, WalkTelemetry, decode
from bridge.messages.guard import GuardStatus
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.messages.world import WorldCommand
from bridge.messages.world_state import WorldReply
from bridge.recording.canonical import Recordable

Published = Recordable | GuardStatus
KINDS: Final[dict[str, Any]] = {
    keys.GUARD: GuardStatus,
    keys.SENSORS: SensorFrame,
    keys.ACTUATORS: ActuatorFrame,
    keys.TRUTH: TruthFrame,
    keys.TELEMETRY: WalkTelemetry,
    keys.NOTICES: Notice,
}
FRAMES: Final = (keys.SENSORS, keys.ACTUATORS, keys.TRUTH, keys.TELEMETRY)
MAX_MESSAGES: Final = 2000
"""Messages that wait for the page; older ones are lost to it."""
MAX_FRAMES: Final = 400
"""Messages, of a second, that a page processes; one that is further behind skips the frames before."""
ANSWER_TIMEOUT: Final = 2.0
"""s to wait for a robot's answer."""


class Subscriber:
    """Receives everything that a robot publishes, in order; sends nothing.

    Args:
        robot: Id of the robot.
        connect: Zenoh endpoint of the robot.
    """

    def __init__(self, robot: str, connect: str) -> None:
        self._robot, self._endpoint = keys.check_name("Robot id", robot), connect
        self._session: zenoh.Session | None = None
        self._subscribers: list[Any] = []
        self._mailbox: Mailbox[tuple[str, bytes]] = Mailbox(MAX_MESSAGES)

    def take(self) -> Iterator[Published]:
        """Messages since the last call; tries to connect until that is done.

        Raises:
            ConfigurationError: not an endpoint.
        """
        if self._session is None:
            self._session = try_client(self._endpoint)
            if self._session is None:
                return
            self._subscribers = [
                subscribe(self._session, keys.key(self._robot, suffix), partial(self._enqueue, suffix))
                for suffix in KINDS
            ]
        waiting = self._mailbox.drain()
        for i, (suffix, payload) in enumerate(waiting):
            # Not decoded all at once: a frame takes several times the memory of its message.
            if suffix not in FRAMES or len(waiting) - i <= MAX_FRAMES:
                with contextlib.suppress(FrameError):  # a stranger on the key
                    yield decode(payload, KINDS[suffix])

    def _enqueue(self, suffix: str, payload: bytes) -> None:
        self._mailbox.put((suffix, payload))

    def close(self) -> None:
        """Leave the network."""
        if self._session is not None:
            self._session.close()


class _Client(Protocol):
    def close(self) -> None: ...


C = TypeVar("C", bound=_Client)


class Commands:
    """The commands of the page's buttons: each kind over its own client, opened at its first use.

    Args:
        robot: Id of the robot.
        connect: Zenoh endpoint of the robot.
    """

    def __init__(self, robot: str, connect: str) -> None:
        self._robot, self._endpoint = robot, connect
        self._lock = threading.Lock()
        self._clients: dict[str, Any] = {}

    def _client(self, name: str, make: Callable[[], C]) -> C:
        with self._lock:
            if name not in self._clients:
                self._clients[name] = make()
            client: C = self._clients[name]
            return client

    def _guard(self) -> GuardClient:
        return self._client("guard", lambda: GuardClient(self._robot, self._endpoint, ANSWER_TIMEOUT))

    def info(self) -> Info | None:
        """The robot's `Info`; None without an answer."""
        try:
            return self._guard().info()
        except NaoHilError:
            return None

    def world(self, command: WorldCommand) -> WorldReply:
        """Carry out a world command.

        Raises:
            FrameError: refused; the robot's own sentence.
            LinkError: no answer.
        """
        return self._client("world", lambda: WorldClient(self._robot, self._endpoint)).send(command)

    def walk(self, command: WalkCommand) -> WalkStatus:
        """Carry out a walk command.

        Raises:
            WalkRefused: the walker's own sentence.
            LinkError: no walker takes commands.
        """
        return self.walker().send(command)

    def walker(self) -> WalkClient:
        """The client of the walker. Raises RobotSilent without an answer."""
        return self._client("walk", lambda: WalkClient(self._robot, self._endpoint, ANSWER_TIMEOUT))

    def guard(self) -> GuardStatus:
        """Status of the guard. Raises LinkError without an answer."""
        return self._guard().status()

    def stop(self) -> GuardStatus:
        """Emergency stop: crouch, then go limp. Raises LinkError without an answer."""
        return self._guard().stop("crouch", "page")

    def limp(self) -> GuardStatus:
        """Take the stiffness from all joints at once. Raises as `stop`."""
        return self._guard().stop("limp", "page")

    def arm(self) -> GuardStatus:
        """Let commands reach the motors again. Raises as `stop`."""
        return self._guard().arm("page")

    def close(self) -> None:
        """Leave the network."""
        for client in self._clients.values():
            client.close()
