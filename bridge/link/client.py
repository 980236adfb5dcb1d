"""Clients of a robot's queries: the guard, the walker, and the emulated world. None needs the lease."""

from __future__ import annotations

import time
from typing import Any, ClassVar, Final, Literal

from bridge.errors import FrameError, LinkError, NaoHilError, RobotSilent, WalkRefused
from bridge.link import keys
from bridge.link.query import ask
from bridge.link.session import open_client, other_robots, require_seconds, robots
from bridge.messages import Info, LeaseReply, LeaseRequest, decode, encode
from bridge.messages.codec import M
from bridge.messages.guard import ArmRequest, GuardStatus, StopRequest
from bridge.messages.walk import WALK_COMMAND, TorsoName, WalkCommand, WalkStatus
from bridge.messages.world import WORLD_COMMAND, WorldCommand, require_command
from bridge.messages.world_state import WorldReply
from bridge.types import Closing, Vec3


class Client(Closing):
    """Asks one robot; close it, or use it as a context manager.

    Args:
        robot: id of the robot.
        connect: Zenoh endpoint of the robot.
        connect_timeout: s to wait for a listener there; None: `CONNECT_TIMEOUT`.

    Raises:
        ConfigurationError: bad id, endpoint or time.
        RobotSilent: no listener there.
    """

    ROLE: ClassVar[Literal["controller", "world"]] = "controller"
    """Whose certificate an encrypted link is opened with."""
    CONNECT_TIMEOUT: ClassVar[float] = 10.0

    def __init__(
        self,
        robot: str = keys.DEFAULT_ROBOT,
        connect: str = keys.DEFAULT_ENDPOINT,
        connect_timeout: float | None = None,
    ) -> None:
        self._robot, self._endpoint = keys.check_name("Robot id", robot), connect
        timeout = self.CONNECT_TIMEOUT if connect_timeout is None else connect_timeout
        require_seconds("connect_timeout", timeout)
        self._session = open_client(connect, timeout, self.ROLE)

    def _ask(self, suffix: str, payload: bytes, timeout: float, refused: type[NaoHilError]) -> bytes | None:
        """As `ask`, of a key below the robot's."""
        return ask(self._session, keys.key(self._robot, suffix), payload, timeout, refused)

    def _other_robots(self) -> str:
        """Clause that names another robot at this address."""
        return other_robots(self._session, self._robot)

    def close(self) -> None:
        """Leave the network."""
        self._session.close()


_ANSWER_TIMEOUT: Final = 5.0
"""s to wait for an answer."""
_RETRY_INTERVAL: Final = 0.05
"""s between two attempts."""


class GuardClient(Client):
    """Asks the guard of one robot; close it, or use it as a context manager."""

    CONNECT_TIMEOUT = 5.0

    def status(self) -> GuardStatus:
        """State of the guard.

        Raises:
            LinkError: no answer, or the robot's own sentence.
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
        """Name of the controller that holds the robot; empty: none does. Raises as `status`."""
        request = LeaseRequest(op="status", controller="guard-client")
        return self._query(keys.LEASE, encode(request), LeaseReply).holder

    def _query(self, suffix: str, payload: bytes, kind: type[M]) -> M:
        """Ask until an answer comes: a robot that has just begun serves its keys one after the other."""
        deadline = time.monotonic() + _ANSWER_TIMEOUT
        while time.monotonic() < deadline:
            reply = self._ask(suffix, payload, _ANSWER_TIMEOUT, LinkError)
            if reply is not None:
                return decode(reply, kind)
            if others := self._other_robots():
                raise RobotSilent(f"There is no robot `{self._robot}` at {self._endpoint}{others}.")
            time.sleep(_RETRY_INTERVAL)
        raise RobotSilent(f"No robot `{self._robot}` at {self._endpoint} answered `{suffix}`.")


def link_robots(connect: str = keys.DEFAULT_ENDPOINT, connect_timeout: float = 5.0) -> list[str]:
    """Ids of all robots of a link.

    Args:
        connect: Zenoh endpoint of one of them.
        connect_timeout: s to wait for a listener there.

    Raises:
        ConfigurationError: bad endpoint.
        RobotSilent: no robot there.
    """
    with open_client(connect, connect_timeout, Client.ROLE) as session:
        names = robots(session)
    if not names:
        raise RobotSilent(f"No robot is at {connect}; start one there.")
    return names


class WalkClient(Client):
    """Commands the walker of one robot; close it, or use it as a context manager.

    Example:
        ```python
        with nao_hil.WalkClient() as walker:
            print(walker.walk((0.015, 0.0, 0.0), distance=0.1).text)
        ```
    """

    def walk(
        self,
        velocity: Vec3 | None = None,
        *,
        steps: int | None = None,
        distance: float | None = None,
        target: Vec3 | None = None,
        gait: str | None = None,
        torso: TorsoName | None = None,
        admittance: bool | None = None,
        hold: float | None = None,
        at: int | None = None,
    ) -> WalkStatus:
        """Walk; the fields of `bridge.messages.walk.WalkCommand`.

        Raises:
            WalkRefused: the walker's own sentence, which names the bound.
            LinkError: no walker there serves.
        """
        return self.send(
            WalkCommand(
                op="walk",
                velocity=velocity,
                steps=steps,
                distance=distance,
                target=target,
                gait=gait,
                torso=torso,
                admittance=admittance,
                hold=hold,
                at=at,
            )
        )

    def stop(self) -> WalkStatus:
        """Close the feet and stand; answered at once. Raises as `walk`."""
        return self.send(WalkCommand(op="stop"))

    def motion(self, name: str) -> WalkStatus:
        """Close the feet, then play a motion; answered at once.

        Args:
            name: `get-up`, or a motion of the package, for example `sit-down`.

        Raises:
            WalkRefused: no such motion, or none for this body or for how it lies.
            LinkError: no walker serves the robot.
        """
        return self.send(WalkCommand(op="motion", motion=name))

    def set(self, **changes: Any) -> WalkStatus:
        """Change `velocity`, `gait`, `torso` or `admittance` without beginning a walk. Raises as `walk`."""
        return self.send(WalkCommand(op="set", **changes))

    def take(self) -> WalkStatus:
        """Have an idle walker take the robot; answered with its first cycle. Raises as `walk`."""
        return self.send(WalkCommand(op="take"))

    def release(self) -> WalkStatus:
        """Have a standing walker give the robot back; answered after that. Raises as `walk`."""
        return self.send(WalkCommand(op="release"))

    def status(self) -> WalkStatus:
        """State of the walker. Raises as `walk`."""
        return self.send(WalkCommand(op="status"))

    def send(self, command: WalkCommand, timeout: float = 10.0) -> WalkStatus:
        """Send any command; a new design of the torso controller takes a second or two.

        Raises:
            WalkRefused: the walker refused; its own sentence.
            LinkError: no answer.
        """
        reply = self._ask(WALK_COMMAND, encode(command), timeout, WalkRefused)
        if reply is not None:
            return decode(reply, WalkStatus)
        if others := self._other_robots():
            raise LinkError(f"There is no robot `{self._robot}` at {self._endpoint}{others}.")
        raise LinkError(
            f"No walker of robot `{self._robot}` at {self._endpoint} takes commands; start one with "
            "`nao-hil walk --serve`."
        )


class WorldClient(Client):
    """Commands the world of one emulated robot; close it, or use it as a context manager.

    Example:
        ```python
        from bridge.messages.world import Push
        with nao_hil.WorldClient() as world:
            print(world.send(Push(impulse=(0.0, 1.5, 0.0), duration=0.1)).text)
        ```
    """

    ROLE = "world"

    def send(self, command: WorldCommand, timeout: float = 10.0) -> WorldReply:
        """Carry out a command; the state of the world after it.

        Args:
            command: To carry out.
            timeout: s to wait; a `Step` is answered when its cycles have run.

        Raises:
            FrameError: no command, or the robot refused it; its own sentence.
            LinkError: no answer: no robot there, or one that has no world.
        """
        require_command(command)
        reply = self._ask(WORLD_COMMAND, encode(command), timeout, FrameError)
        if reply is not None:
            return decode(reply, WorldReply)
        others = self._other_robots()
        raise LinkError(f"No emulated robot `{self._robot}` at {self._endpoint} answered{others}.")
