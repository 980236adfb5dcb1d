"""The robots of a link, each with its body and its newest ground truth."""

from __future__ import annotations

import threading
import time
from collections import deque
from typing import Any, Final, NamedTuple

import zenoh

from bridge.body import Body, body_of
from bridge.errors import FrameError, LinkError, NaoHilError
from bridge.link import keys
from bridge.link.query import ask
from bridge.link.session import robots, subscribe, try_client
from bridge.messages import Info, TruthFrame, decode

_ANSWER_TIMEOUT: Final = 5.0
"""s to wait for a robot's answer."""


class LinkRobot(NamedTuple):
    """A robot of a link."""

    body: Body
    newest: deque[tuple[float, bytes]]
    """Arrival (s since 1970) and payload of its newest ground truth; empty: none yet, as of a real robot."""

    @property
    def truth(self) -> TruthFrame | None:
        """The newest ground truth."""
        seen = self.seen
        return None if seen is None else seen[1]

    @property
    def seen(self) -> tuple[float, TruthFrame] | None:
        """Arrival of the newest ground truth, s since 1970, and itself."""
        if not self.newest:
            return None
        moment, payload = self.newest[0]
        try:
            return moment, decode(payload, TruthFrame)
        except FrameError:  # a stranger on the key
            return None


class LinkRobots:
    """The robots of a link, by their names, each with its newest ground truth.

    Args:
        connect: Zenoh endpoint of the link.
    """

    def __init__(self, connect: str) -> None:
        self._endpoint = connect
        self._lock = threading.Lock()
        self._session: zenoh.Session | None = None
        self._subscribers: dict[str, Any] = {}
        self._known: dict[str, LinkRobot] = {}
        self.found: dict[str, LinkRobot] = {}
        """At the last `update`."""

    def update(self) -> dict[str, LinkRobot]:
        """Look for robots that came or went.

        Raises:
            ConfigurationError: not an endpoint.
        """
        with self._lock:
            if self._session is None:
                self._session = try_client(self._endpoint)
            if self._session is not None:
                names = robots(self._session)
                known = {name: robot for name, robot in self.found.items() if name in names}
                new = {name: self._subscribe(self._session, name) for name in names if name not in known}
                known |= {name: robot for name, robot in new.items() if robot is not None}
                self.found = {name: known[name] for name in names if name in known}
            return self.found

    def _subscribe(self, session: zenoh.Session, name: str) -> LinkRobot | None:
        """A new robot and the subscription to its ground truth; None: it gives no `Info`."""
        try:
            answer = ask(session, keys.key(name, keys.INFO), b"", _ANSWER_TIMEOUT, LinkError)
            if answer is None:
                return None
            info = decode(answer, Info)
            robot = LinkRobot(body_of(info.body, info.sheet), deque(maxlen=1))
        except NaoHilError:
            return None
        if name in self._known and self._known[name].body == robot.body:
            return self._known[name]  # back after an outage; its readers hold this one
        self._known[name] = robot

        def receive(payload: bytes) -> None:
            robot.newest.append((time.time(), payload))

        self._subscribers[name] = subscribe(session, keys.topic_key(name, TruthFrame), receive)
        return robot

    def close(self) -> None:
        """Leave the network."""
        if self._session is not None:
            self._session.close()
