"""A recording back on the wire: a robot that can be listened to and takes no commands."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.body import sheet_of
from bridge.body.quantities import absent_joints
from bridge.link import keys
from bridge.link.query import serve_query
from bridge.link.session import open_robot
from bridge.messages import Info, LeaseReply, LeaseRequest, SensorFrame, decode, encode
from bridge.recording.canonical import RECORDED
from bridge.recording.playback import read_recording, recorded_body
from bridge.types import Closing
from nao_hil import __version__

SIDE: Final = "replay"
"""`Info.side` of a recording that is played back."""
_NO: Final = "A recording is played back here; it takes no commands."


class Replay(Closing):
    """The robot side of a recording; close it, or use it as a context manager.

    Args:
        path: the recording.
        robot: id under which it appears.
        listen: Zenoh endpoint.
        body: of the robot; None: the recording's.

    Raises:
        ConfigurationError: not a recording, no body known, bad id or endpoint.
        LinkError: the endpoint cannot be listened on.
    """

    def __init__(self, path: Path, robot: str, listen: str, body: str | None = None) -> None:
        self._path = path
        keys.check_name("Robot id", robot)
        read_recording(path)  # a wrong file is reported before anything listens
        sheet = recorded_body(path, body)
        self.info = Info(
            robot=robot,
            body=sheet.name,
            sheet=sheet_of(sheet),
            side=SIDE,
            mode="real-time",
            cycle=sheet.cycle,
            absent=absent_joints(sheet),
            boot=secrets.randbits(47),
            software=f"nao-hil {__version__}",
        )
        self.position = 0.0
        """Robot time of the newest frame, s."""
        self._session = open_robot(listen)
        key = {topic: keys.key(robot, topic) for topic in RECORDED.values()}
        self._publishers = {topic: self._session.declare_publisher(name) for topic, name in key.items()}
        self._queries: list[Any] = [
            serve_query(self._session, keys.key(robot, keys.INFO), lambda *_: encode(self.info)),
            serve_query(self._session, keys.key(robot, keys.LEASE), self._refuse),
        ]
        self._alive = self._session.liveliness().declare_token(keys.key(robot, keys.ALIVE_ROBOT))

    @staticmethod
    def _refuse(payload: bytes, _: bytes) -> bytes:
        decode(payload, LeaseRequest)
        return encode(LeaseReply(granted=False, lease=0, holder="", message=_NO))

    def play(
        self,
        stop: Callable[[float], bool],
        *,
        speed: float = 1.0,
        begin: float = 0.0,
        end: float = float("inf"),
    ) -> int:
        """Publish the messages of a stretch of time at their recorded pace.

        Args:
            stop: waits so many seconds, or less; true when the replay is to end.
            speed: robot time per wall-clock time.
            begin: robot time to begin at, s.
            end: robot time to end at, s.

        Returns:
            Sensor frames published.

        Raises:
            ConfigurationError: the recording is damaged.
        """
        frames, origin, first = 0, time.monotonic(), None
        for topic, when, message in read_recording(self._path):
            if when < begin:
                continue
            if when > end:
                break
            first = when if first is None else first
            wait = origin + (when - first) / speed - time.monotonic()
            if stop(max(wait, 0.0)):
                break
            if isinstance(message, SensorFrame):
                frames, self.position = frames + 1, when
                message = msgspec.structs.replace(message, wall=time.time_ns())
            self._publishers[topic].put(encode(message))
        return frames

    def close(self) -> None:
        """Leave the network."""
        self._session.close()
