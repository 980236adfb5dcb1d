"""The guard from outside: its state, the emergency stop, and arming. Needs no lease."""

from __future__ import annotations

import time
from typing import Final, Literal

from bridge.errors import LinkError, RobotSilent
from bridge.link import keys
from bridge.link.client import Client
from bridge.messages import Info, LeaseReply, LeaseRequest, decode, encode
from bridge.messages.codec import M
from bridge.messages.guard import ArmRequest, GuardStatus, StopRequest

_TIMEOUT: Final = 2.0
"""s until nobody answers."""
_RETRY: Final = 0.05
"""s between two attempts."""


class GuardClient(Client):
    """Asks the guard of one robot; close it, or use it as a context manager.

    Args:
        robot: id of the robot.
        connect: Zenoh endpoint of the robot.
        connect_timeout: s to wait for somebody to listen there.

    Raises:
        ConfigurationError: bad id or endpoint.
        RobotSilent: nobody listens there.
    """

    def __init__(
        self,
        robot: str = keys.DEFAULT_ROBOT,
        connect: str = keys.DEFAULT_ENDPOINT,
        connect_timeout: float = 3.0,
    ) -> None:
        super().__init__(robot, connect, connect_timeout, "controller")

    def status(self) -> GuardStatus:
        """State of the guard.

        Raises:
            LinkError: nobody answered, or the robot could not; its own sentence.
        """
        return self._query(keys.GUARD, b"", GuardStatus)

    def stop(self, how: Literal["crouch", "limp"] = "crouch", who: str = "") -> GuardStatus:
        """Emergency stop; from then on no command is taken until `arm`. Raises as `status`."""
        return self._query(keys.STOP, encode(StopRequest(how=how, who=who)), GuardStatus)

    def arm(self, who: str = "") -> GuardStatus:
        """Let commands be taken. Raises as `status`."""
        return self._query(keys.ARM, encode(ArmRequest(who=who)), GuardStatus)

    def info(self) -> Info:
        """Description of the robot. Raises as `status`."""
        return self._query(keys.INFO, b"", Info)

    def holder(self) -> str:
        """Name of the controller that holds the robot; empty: nobody does. Raises as `status`."""
        request = LeaseRequest(op="status", controller="guard-client")
        return self._query(keys.LEASE, encode(request), LeaseReply).holder

    def _query(self, suffix: str, payload: bytes, kind: type[M]) -> M:
        """Ask until somebody answers: a robot that has just begun serves its keys one after the other."""
        deadline = time.monotonic() + _TIMEOUT
        while time.monotonic() < deadline:
            reply = self._ask(suffix, payload, _TIMEOUT, LinkError)
            if reply is not None:
                return decode(reply, kind)
            if others := self._other_robots():
                raise RobotSilent(f"There is no robot `{self._robot}` at {self._endpoint}{others}.")
            time.sleep(_RETRY)
        raise RobotSilent(f"No robot `{self._robot}` at {self._endpoint} answered `{suffix}`.")
