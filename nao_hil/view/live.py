"""Running robots as the page has them: their messages, and the commands to them."""

from __future__ import annotations

import contextlib
import itertools
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from operator import itemgetter
from typing import Any, Final, TypeVar

from bridge.errors import FrameError, LinkError, NaoHilError
from bridge.link import keys
from bridge.link.client import GuardClient, WalkClient, WorldClient
from bridge.link.mailbox import Mailbox
from bridge.link.query import ask
from bridge.link.session import in_order, open_client
from bridge.messages import ActuatorFrame, Info, SensorFrame, TruthFrame, WalkTelemetry, decode, encode
from bridge.messages.guard import GuardStatus, StopRequest
from bridge.messages.topics import TOPICS, Message
from bridge.messages.world import WorldCommand
from bridge.messages.world_state import WorldReply
from nao_hil.runs.monitor import Subscription

FRAMES: Final = (SensorFrame, ActuatorFrame, TruthFrame, WalkTelemetry)
"""Kinds that come in each cycle."""
MAX_MESSAGES: Final = 2000
"""Messages of other kinds that wait for the page; older ones are lost to it."""
MAX_FRAMES: Final = 400
"""Messages of these kinds, of a second, that wait; a page that is further behind skips the older ones alone."""
ANSWER_TIMEOUT: Final = 5.0
"""s to wait for a robot's answer."""
MAX_ROBOTS: Final = 32
"""Emergency stops that are sent at a time."""


class Subscriber:
    """Receives everything that a robot publishes, in order; sends nothing.

    Args:
        robot: Id of the robot.
        connect: Zenoh endpoint of the robot.
    """

    def __init__(self, robot: str, connect: str) -> None:
        self._frames: Mailbox[tuple[int, type[Any], bytes]] = Mailbox(MAX_FRAMES)
        self._others: Mailbox[tuple[int, type[Any], bytes]] = Mailbox(MAX_MESSAGES)
        self._numbers = itertools.count()
        self._subscription = Subscription(keys.check_name("Robot id", robot), connect, TOPICS, self._enqueue)

    def take(self) -> Iterator[Message]:
        """Messages since the last call; tries to connect until that is done.

        Raises:
            ConfigurationError: not an endpoint.
        """
        if not self._subscription.connect():
            return
        for _, kind, payload in sorted([*self._others.drain(), *self._frames.drain()], key=itemgetter(0)):
            # Not decoded all at once: a frame takes several times the memory of its message.
            with contextlib.suppress(FrameError):  # a stranger on the key
                yield decode(payload, kind)

    def _enqueue(self, kind: type[Any], payload: bytes) -> None:
        (self._frames if kind in FRAMES else self._others).put((next(self._numbers), kind, payload))

    def close(self) -> None:
        """Leave the network."""
        self._subscription.close()


def stop_all(names: Iterable[str], connect: str) -> str:
    """Emergency stop of several robots at once, each told whatever the others answer.

    Args:
        names: Of the robots.
        connect: Zenoh endpoint of the link.

    Returns:
        The answer of each robot.

    Raises:
        LinkError: names the robots that did not answer.
    """
    request = encode(StopRequest(how="crouch", who="page"))
    with open_client(connect, ANSWER_TIMEOUT, "controller") as session:

        def stop(name: str) -> str:
            answer = ask(session, keys.key(name, keys.STOP), request, ANSWER_TIMEOUT, LinkError)
            if answer is None:
                raise LinkError("no answer")
            return decode(answer, GuardStatus).text

        with ThreadPoolExecutor(MAX_ROBOTS) as workers:
            waiting = {name: workers.submit(stop, name) for name in names}
    failed = {name: error for name, answer in waiting.items() if (error := answer.exception())}
    if failed or not waiting:
        reasons = "; ".join(f"`{name}`: {error}" for name, error in failed.items()) or "no robot is there"
        raise LinkError(f"The EMERGENCY STOP DID NOT REACH ALL ROBOTS ({reasons}). Stop them by hand.")
    return " ".join(f"{name}: {waiting[name].result()}" for name in in_order(waiting))


C = TypeVar("C")


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
