"""Listens to a robot and its walker, for people: keeps the newest of each message and all notices."""

from __future__ import annotations

from collections import deque
from functools import partial
from typing import Final

import zenoh

from bridge.errors import FrameError
from bridge.link import keys
from bridge.link.session import subscribe, try_client
from bridge.messages import Notice, SensorFrame, TruthFrame, WalkTelemetry, decode
from bridge.messages.codec import M
from bridge.messages.guard import GuardStatus

_MAX_NOTICES: Final = 1000
"""Notices kept until the next read; of a flood of more the oldest are dropped."""

MAX_TELEMETRY_AGE: Final = 10
"""Cycles since the frame of the newest telemetry, beyond which its walker counts as lost."""


class Monitor:
    """Open ear on `nao/<robot>`; close it, or use it as a context manager.

    Args:
        robot: id of the robot.
        connect: Zenoh endpoint of the robot.
    """

    def __init__(self, robot: str, connect: str) -> None:
        self._robot, self._endpoint = robot, connect
        self._newest: dict[str, bytes] = {}
        self._notices: deque[bytes] = deque(maxlen=_MAX_NOTICES)
        self._session: zenoh.Session | None = None

    def connect(self) -> bool:
        """Try to connect, unless connected; False while there is no robot."""
        if self._session is None:
            self._session = try_client(self._endpoint)
            if self._session is not None:
                self._subscribers = [
                    subscribe(self._session, keys.key(self._robot, suffix), partial(self._store, suffix))
                    for suffix in (keys.SENSORS, keys.TRUTH, keys.TELEMETRY, keys.GUARD)
                ]
                notices = keys.key(self._robot, keys.NOTICES)
                self._subscribers.append(subscribe(self._session, notices, self._notices.append))
        return self._session is not None

    def _store(self, suffix: str, payload: bytes) -> None:
        self._newest[suffix] = payload

    def _get(self, suffix: str, kind: type[M]) -> M | None:
        payload = self._newest.get(suffix)
        return _decoded(payload, kind) if payload is not None else None

    @property
    def sensors(self) -> SensorFrame | None:
        """The newest sensor frame."""
        return self._get(keys.SENSORS, SensorFrame)

    @property
    def truth(self) -> TruthFrame | None:
        """The newest ground truth."""
        return self._get(keys.TRUTH, TruthFrame)

    @property
    def telemetry(self) -> WalkTelemetry | None:
        """The newest word of the walker."""
        return self._get(keys.TELEMETRY, WalkTelemetry)

    @property
    def status(self) -> GuardStatus | None:
        """The newest report of the robot's state."""
        return self._get(keys.GUARD, GuardStatus)

    @property
    def walk(self) -> WalkTelemetry | None:
        """The walker's newest word, if the robot follows it; see `walk_in_force`."""
        return walk_in_force(self.status, self.telemetry, self.sensors)

    def take_notices(self) -> list[Notice]:
        """The notices of the robot side since the last call, oldest first."""
        found = (_decoded(self._notices.popleft(), Notice) for _ in range(len(self._notices)))
        return [notice for notice in found if notice is not None]

    def close(self) -> None:
        """Leave the network."""
        if self._session is not None:
            self._session.close()

    def __enter__(self) -> Monitor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


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
