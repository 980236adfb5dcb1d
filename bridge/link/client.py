"""The common part of all clients of a robot's queries."""

from __future__ import annotations

from types import TracebackType
from typing import Literal, TypeVar

from bridge.errors import NaoHilError
from bridge.link import keys
from bridge.link.query import ask
from bridge.link.session import open_client, other_robots, require_seconds

C = TypeVar("C", bound="Client")


class Client:
    """Asks one robot; close it, or use it as a context manager.

    Args:
        robot: id of the robot.
        connect: Zenoh endpoint of the robot.
        connect_timeout: s to wait for somebody to listen there.
        role: whose certificate an encrypted link is opened with.

    Raises:
        ConfigurationError: bad id, endpoint or time.
        RobotSilent: nobody listens there.
    """

    def __init__(
        self, robot: str, connect: str, connect_timeout: float, role: Literal["controller", "world"]
    ) -> None:
        self._robot, self._endpoint = keys.check_name("Robot id", robot), connect
        require_seconds("connect_timeout", connect_timeout)
        self._session = open_client(connect, connect_timeout, role)

    def _ask(self, suffix: str, payload: bytes, timeout: float, refused: type[NaoHilError]) -> bytes | None:
        """As `ask`, of a key below the robot's."""
        return ask(self._session, keys.key(self._robot, suffix), payload, timeout, refused)

    def _other_robots(self) -> str:
        """Clause that names another robot at this address, for sentences about one that does not answer."""
        return other_robots(self._session, self._robot)

    def close(self) -> None:
        """Leave the network."""
        self._session.close()

    def __enter__(self: C) -> C:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
