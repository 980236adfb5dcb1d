"""Records all messages of a robot and its controller on the wire; for any robot, emulated or real."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Final

import msgspec
import zenoh

from bridge.errors import FrameError
from bridge.link import keys
from bridge.link.mailbox import Mailbox
from bridge.link.session import Search, check_endpoint, subscribe, try_client
from bridge.messages import Info, SensorFrame, TruthFrame, decode
from bridge.messages.topics import Message
from bridge.recording.canonical import RECORDED
from bridge.recording.recorder import Recorder
from bridge.types import Closing

_QUEUE_SIZE: Final = 8192
"""Messages that may wait for the disk: some twenty seconds of a robot's."""
_QUERY_TIMEOUT: Final = 5.0
"""Patience with a query, s."""
_RETRY_INTERVAL: Final = 0.05
"""s between two attempts to find a robot."""
_KINDS: Final = {topic: kind for kind, topic in RECORDED.items()}


class Capture(Closing):
    """Records a robot from the wire; close it, or use it as a context manager.

    Actuator frames are recorded as the controller sent them, before the robot's guard. A frame that a robot in
    lockstep repeats is recorded once.

    Args:
        robot: id of the robot.
        connect: Zenoh endpoint of the robot.

    Raises:
        ConfigurationError: bad id or endpoint.
    """

    def __init__(self, robot: str, connect: str) -> None:
        self._robot = keys.check_name("Robot id", robot)
        self._endpoint = check_endpoint(connect)
        self._session: zenoh.Session | None = None
        self._queue: Mailbox[tuple[str, bytes]] = Mailbox(_QUEUE_SIZE)
        self._newest: dict[str, int] = {}
        self.counts = dict.fromkeys(_KINDS, 0)
        """Messages recorded on each topic."""
        self.refused = 0
        """Messages of another form than their key's."""
        self.seconds = 0.0
        """Robot time recorded."""
        self._since: float | None = None

    def wait_robot(self, stop: Callable[[], bool]) -> Info | None:
        """Wait until the robot answers and listen from then on; None when `stop()` became true."""
        search = Search(self._robot, self._endpoint)
        while not stop():
            info = self._ask()
            if info is not None:
                return info
            search.failed(self._session)
            time.sleep(_RETRY_INTERVAL)
        return None

    def _ask(self) -> Info | None:
        if self._session is None:
            self._session = try_client(self._endpoint)
        if self._session is None:
            return None
        for reply in self._session.get(keys.key(self._robot, keys.INFO), timeout=_QUERY_TIMEOUT):
            if reply.ok is not None:
                self._subscribers = [
                    subscribe(self._session, keys.key(self._robot, topic), partial(self._enqueue, topic))
                    for topic in _KINDS
                ]
                return decode(reply.ok.payload.to_bytes(), Info)
        return None

    def _enqueue(self, topic: str, payload: bytes) -> None:
        self._queue.put((topic, payload))

    def record(self, recorder: Recorder, timeout: float) -> None:
        """Write the waiting messages, after up to `timeout` s for the first one."""
        first = self._queue.take(timeout)
        for topic, payload in ([first] if first is not None else []) + self._queue.drain():
            try:
                message = decode(payload, _KINDS[topic])
            except FrameError:
                self.refused += 1  # a stranger on the key
            else:
                self._write(recorder, topic, message)

    def _write(self, recorder: Recorder, topic: str, message: Message) -> None:
        if isinstance(message, (SensorFrame, TruthFrame)):
            if self._newest.get(topic) == message.seq:
                return
            self._newest[topic] = message.seq
        if isinstance(message, SensorFrame):
            self._count_time(message.time)
        recorder.write(message)
        self.counts[topic] += 1

    def _count_time(self, now: float) -> None:
        if self._since is not None and now > self._since:
            self.seconds += now - self._since
        self._since = now

    def close(self) -> None:
        """Leave the network."""
        if self._session is not None:
            self._session.close()


def described(info: Info) -> dict[str, Any]:
    """Configuration record of a recording from the wire: the known facts of the robot."""
    known = msgspec.to_builtins(info)
    return {"robot": known.pop("body"), "name": known.pop("robot")} | {
        key: known[key] for key in ("side", "mode", "cycle", "software")
    }


def free_name(folder: Path, robot: str) -> Path:
    """A file for a recording that is not there yet, named by robot and time in UTC."""
    stem = f"{robot}-{time.strftime('%Y%m%dT%H%M%SZ', time.gmtime())}"
    names = (folder / f"{stem}{suffix}.mcap" for suffix in ("", *(f"-{n}" for n in range(2, 1000))))
    return next(file for file in names if not file.exists())
