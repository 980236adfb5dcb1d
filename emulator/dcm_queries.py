"""The `dcm/` queries: decode and check in the thread they come in, carry out at a cycle boundary."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from bridge.dcm import Dcm
from bridge.dcm.requests import alias_request, set_alias_request, set_request
from bridge.errors import DcmRefused
from bridge.messages import SensorFrame, decode, encode
from bridge.messages import dcm as wire
from emulator.boundary import BoundaryQueue

Handler = Callable[[bytes], bytes]


class RobotWithDcm(Protocol):
    """Interface of a robot for the queries."""

    @property
    def dcm(self) -> Dcm:
        """Its DCM, a new one after each reset."""

    @property
    def frame(self) -> SensorFrame:
        """The present boundary's sensor frame."""


class DcmQueries:
    """Handlers of the `dcm/` queries of one robot.

    Args:
        robot: touched at cycle boundaries only.
        boundary: where work waits for them.
        require_lease: raises `LeaseRefused` unless the number is the lease's; the second argument says what
            is refused.
    """

    def __init__(
        self, robot: RobotWithDcm, boundary: BoundaryQueue, require_lease: Callable[[int, str], None]
    ) -> None:
        self._robot, self._boundary = robot, boundary
        self._require_lease = require_lease

    def handlers(self) -> dict[str, Handler]:
        """Handler of each key below the robot's: payload in, reply out; a `NaoHilError` is a refusal."""
        return {
            wire.CREATE_ALIAS: self._create_alias,
            wire.SET: self._set,
            wire.SET_ALIAS: self._set_alias,
            wire.GET_TIME: self._get_time,
            wire.GET_PREFIX: self._get_prefix,
            wire.READ: self._read,
            wire.PREFERENCES: _refusal("preferences", "the emulated robot has no preference files"),
            wire.SPECIAL: _refusal("special", "there are no boards to reset or program"),
            wire.CALIBRATION: _refusal("calibration", "the emulated joints have no offsets to calibrate"),
        }

    def _create_alias(self, payload: bytes) -> bytes:
        message = decode(payload, wire.DcmCommand)
        request = alias_request(message.command)
        return self._commanded(message, wire.CREATE_ALIAS, lambda dcm: dcm.create_alias(request))

    def _set(self, payload: bytes) -> bytes:
        message = decode(payload, wire.DcmCommand)
        request = set_request(message.command)
        return self._commanded(message, wire.SET, lambda dcm: dcm.set(request))

    def _set_alias(self, payload: bytes) -> bytes:
        message = decode(payload, wire.DcmCommand)
        request = set_alias_request(message.command)
        return self._commanded(message, wire.SET_ALIAS, lambda dcm: dcm.set_alias(request))

    def _get_time(self, payload: bytes) -> bytes:
        offset = decode(payload, wire.DcmTime).offset if payload else 0
        return self._done(lambda: self._robot.dcm.clock.shown(offset))

    def _get_prefix(self, payload: bytes) -> bytes:
        if payload:
            decode(payload, wire.DcmCall)
        return self._done(lambda: self._robot.dcm.prefixes())

    def _read(self, payload: bytes) -> bytes:
        names = decode(payload, wire.DcmRead).names
        return self._done(lambda: self._robot.dcm.read(names, self._robot.frame.position))

    def _commanded(self, message: wire.DcmCommand, key: str, command: Callable[[Dcm], Any]) -> bytes:
        def work() -> Any:
            self._require_lease(message.lease, f"A `{key}` command")
            return command(self._robot.dcm)

        return self._done(work)

    def _done(self, work: Callable[[], Any]) -> bytes:
        return encode(wire.DcmReply(result=self._boundary.call(work)))


def _refusal(method: str, reason: str) -> Handler:
    def refuse(payload: bytes) -> bytes:
        if payload:
            decode(payload, wire.DcmCall)
        raise DcmRefused(f"{method} is not emulated: {reason}.")

    return refuse
