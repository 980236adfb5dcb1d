"""Listens to a robot and its walker, for people: keeps the newest of each message and all notices."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, Final

import zenoh

from bridge.errors import FrameError
from bridge.link import keys
from bridge.link.session import subscribe, try_client
from bridge.messages import Notice, SensorFrame, TruthFrame, WalkTelemetry, decode
from bridge.messages.codec import M
from bridge.messages.guard import GuardStatus
from bridge.types import Closing

_MAX_NOTICES: Final = 1000
"""Notices kept until the next read; of a flood of more the oldest are dropped."""

MAX_TELEMETRY_AGE: Final = 10
"""Cycles since the frame of the newest telemetry, beyond which its walker counts as lost."""


class Subscription:
    """Messages of some topics of a robot, from its appearance on.

    Args:
        robot: Id of the robot.
        connect: Zenoh endpoint of the robot.
        kinds: Of the messages.
        receive: Takes the kind and the payload of each message, on a thread of the link.
    """

    def __init__(
        self,
        robot: str,
        connect: str,
        kinds: Iterable[type[Any]],
        receive: Callable[[type[Any], bytes], None],
    ) -> None:
        self._robot, self._endpoint = robot, connect
        self._kinds, self._receive = tuple(kinds), receive
        self._session: zenoh.Session | None = None

    def connect(self) -> bool:
        """Try to connect, unless that is done; False while no robot is there."""
        if self._session is None and (session := try_client(self._endpoint)) is not None:
            self._session = session
            self._subscribers = [
                subscribe(session, keys.topic_key(self._robot, kind), partial(self._receive, kind))
                for kind in self._kinds
            ]
        return self._session is not None

    def close(self) -> None:
        """Leave the network."""
        if self._session is not None:
            self._session.close()


class Monitor(Closing):
    """Open ear on `nao/<robot>`; close it, or use it as a context manager.

    Args:
        robot: id of the robot.
        connect: Zenoh endpoint of the robot.
    """

    def __init__(self, robot: str, connect: str) -> None:
        self._newest: dict[type[Any], bytes] = {}
        self._notices: deque[bytes] = deque(maxlen=_MAX_NOTICES)
        kinds = (SensorFrame, TruthFrame, WalkTelemetry, GuardStatus, Notice)
        self._subscription = Subscription(robot, connect, kinds, self._store)

    def connect(self) -> bool:
        """Try to connect, unless that is done; False while no robot is there."""
        return self._subscription.connect()

    def _store(self, kind: type[Any], payload: bytes) -> None:
        if kind is Notice:
            self._notices.append(payload)
        else:
            self._newest[kind] = payload

    def _get(self, kind: type[M]) -> M | None:
        payload = self._newest.get(kind)
        return _decoded(payload, kind) if payload is not None else None

    @property
    def sensors(self) -> SensorFrame | None:
        """The newest sensor frame."""
        return self._get(SensorFrame)

    @property
    def truth(self) -> TruthFrame | None:
        """The newest ground truth."""
        return self._get(TruthFrame)

    @property
    def telemetry(self) -> WalkTelemetry | None:
        """The newest word of the walker."""
        return self._get(WalkTelemetry)

    @property
    def status(self) -> GuardStatus | None:
        """The newest report of the robot's state."""
        return self._get(GuardStatus)

    @property
    def walk(self) -> WalkTelemetry | None:
        """The walker's newest word, if the robot follows it; see `walk_in_force`."""
        return walk_in_force(self.status, self.telemetry, self.sensors)

    def take_notices(self) -> list[Notice]:
        """The notices of the robot side since the last call, oldest first."""
        decoded = (_decoded(self._notices.popleft(), Notice) for _ in range(len(self._notices)))
        return [notice for notice in decoded if notice is not None]

    def close(self) -> None:
        """Leave the network."""
        self._subscription.close()


def walk_in_force(
    status: GuardStatus | None, telemetry: WalkTelemetry | None, frame: SensorFrame | None
) -> WalkTelemetry | None:
    """The walker's telemetry if it describes the robot: commands are in force, and its frame is recent.

    After an emergency stop, a reset or the walker's end the last telemetry describes a walk that is over.
    """
    if status is None or telemetry is None or frame is None or not status.under_command:
        return None
    return telemetry if 0 <= frame.seq - telemetry.seq <= MAX_TELEMETRY_AGE else None


def _decoded(payload: bytes, kind: type[M]) -> M | None:
    try:
        return decode(payload, kind)
    except FrameError:
        return None  # a stranger on the key
