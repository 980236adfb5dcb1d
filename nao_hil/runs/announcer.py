"""Sentences for those who watch a robot, as notices of it."""

from __future__ import annotations

from typing import Final

import zenoh

from bridge.link import keys
from bridge.link.session import open_client
from bridge.messages import Notice, encode

CAPTION: Final = "caption"
"""Code of a line of the demo."""
WALKER_ENDED: Final = "walker-ended"
"""Code of the report that `nao-hil up` lost its walker."""
CONNECT_TIMEOUT: Final = 10.0
"""s; the robot is there already."""


class Announcer:
    """Publishes notices; connects with the first one.

    Args:
        robot: Id of the robot.
        endpoint: Zenoh endpoint of the robot.
    """

    def __init__(self, robot: str, endpoint: str) -> None:
        self._key, self._endpoint = keys.topic_key(robot, Notice), endpoint
        self._session: zenoh.Session | None = None

    def announce(self, code: str, text: str, seq: int) -> None:
        """Publish a sentence: the terminal, the page and the recording have it.

        Args:
            code: Of the notice.
            text: The sentence.
            seq: Number of the newest sensor frame.

        Raises:
            LinkError: no robot is there.
        """
        if self._session is None:
            self._session = open_client(self._endpoint, CONNECT_TIMEOUT, "controller")
        self._session.put(self._key, encode(Notice(seq=seq, level="info", code=code, text=text)))

    def close(self) -> None:
        """Leave the network."""
        if self._session is not None:
            self._session.close()
