"""The guard from outside: its state, the emergency stop, and arming. Needs no lease."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Final, Literal

from bridge.errors import LinkError, RobotSilent
from bridge.guard.messages import ArmRequest, GuardStatus, StopRequest
from bridge.link import keys
from bridge.link.session import open_client
from bridge.messages import Info, LeaseReply, LeaseRequest, M, decode, encode

_ANSWER: Final = 2.0
"""s until nobody answers."""
_AGAIN: Final = 0.05
"""s between two attempts."""


class GuardClient:
    """Asks the guard of one robot; close it, or use it as a context manager.

    Args:
        robot: id of the robot.
        connect: Zenoh endpoint of the robot.
        patience: s to wait for somebody to listen there.

    Raises:
        ConfigurationError: bad id or endpoint.
        RobotSilent: nobody listens there.
    """

    def __init__(
        self,
        robot: str = keys.DEFAULT_ROBOT,
        connect: str = keys.DEFAULT_ENDPOINT,
        patience: float = 3.0,
    ) -> None:
        self._robot, self._endpoint = keys.check_name("Robot id", robot), connect
        self._session = open_client(connect, patience, "controller")

    def status(self) -> GuardStatus:
        """What the guard does.

        Raises:
            LinkError: nobody answered, or the robot could not; its own sentence.
        """
        return self._ask(keys.GUARD, b"", GuardStatus)

    def stop(self, how: Literal["crouch", "limp"] = "crouch", who: str = "") -> GuardStatus:
        """Emergency stop; from then on no command is taken until `arm`. Raises as `status`."""
        return self._ask(keys.STOP, encode(StopRequest(how=how, who=who)), GuardStatus)

    def arm(self, who: str = "") -> GuardStatus:
        """Let commands be taken. Raises as `status`."""
        return self._ask(keys.ARM, encode(ArmRequest(who=who)), GuardStatus)

    def info(self) -> Info:
        """What the robot is. Raises as `status`."""
        return self._ask(keys.INFO, b"", Info)

    def holder(self) -> str:
        """Name of the controller that holds the robot; empty: nobody does. Raises as `status`."""
        request = LeaseRequest(op="status", controller="guard-client")
        return self._ask(keys.LEASE, encode(request), LeaseReply).holder

    def _ask(self, suffix: str, payload: bytes, kind: type[M]) -> M:
        """Ask until somebody answers: a robot that has just begun serves its keys one after the other."""
        deadline = time.monotonic() + _ANSWER
        while time.monotonic() < deadline:
            for reply in self._session.get(keys.key(self._robot, suffix), payload=payload, timeout=_ANSWER):
                if reply.ok is not None:
                    return decode(reply.ok.payload.to_bytes(), kind)
                if reply.err is not None:
                    text = reply.err.payload.to_bytes().decode(errors="replace")
                    if text and text != "Timeout":  # Zenoh's own word for no answer
                        raise LinkError(text)
            time.sleep(_AGAIN)
        raise RobotSilent(f"No robot `{self._robot}` at {self._endpoint} answered `{suffix}`.")

    def close(self) -> None:
        """Leave the network."""
        self._session.close()

    def __enter__(self) -> GuardClient:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
