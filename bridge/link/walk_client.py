"""Walk commands from outside: for people's tools, viewers and scripts."""

from __future__ import annotations

from typing import Any

from bridge.errors import LinkError, WalkRefused
from bridge.link import keys
from bridge.link.client import Client
from bridge.messages import decode, encode
from bridge.messages.walk import COMMAND, TorsoName, WalkCommand, WalkStatus
from bridge.types import Vec3


class WalkClient(Client):
    """Commands the walker of one robot; close it, or use it as a context manager.

    Example:
        with nao_hil.WalkClient() as walker:
            print(walker.walk((0.015, 0.0, 0.0), distance=0.1).text)

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
        connect_timeout: float = 10.0,
    ) -> None:
        super().__init__(robot, connect, connect_timeout, "controller")

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
            WalkRefused: the walker cannot; its own sentence, which names the bound.
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
            name: `get-up`, or of a motion that comes with the package, as `sit-down`.

        Raises:
            WalkRefused: no such motion, or none for this body or for how it lies.
            LinkError: no walker there serves.
        """
        return self.send(WalkCommand(op="motion", motion=name))

    def set(self, **changes: Any) -> WalkStatus:
        """Change `velocity`, `gait`, `torso` or `admittance` without beginning a walk. Raises as `walk`."""
        return self.send(WalkCommand(op="set", **changes))

    def take(self) -> WalkStatus:
        """Have a walker that stands by take the robot; answered with its first cycle. Raises as `walk`."""
        return self.send(WalkCommand(op="take"))

    def release(self) -> WalkStatus:
        """Have a walker that stands give the robot back and stand by; answered then. Raises as `walk`."""
        return self.send(WalkCommand(op="release"))

    def status(self) -> WalkStatus:
        """State of the walker. Raises as `walk`."""
        return self.send(WalkCommand(op="status"))

    def send(self, command: WalkCommand, timeout: float = 10.0) -> WalkStatus:
        """Send any command; a new design of the torso controller takes a second or two.

        Raises:
            WalkRefused: the walker refused; its own sentence.
            LinkError: nobody answered.
        """
        reply = self._ask(COMMAND, encode(command), timeout, WalkRefused)
        if reply is not None:
            return decode(reply, WalkStatus)
        if others := self._other_robots():
            raise LinkError(f"There is no robot `{self._robot}` at {self._endpoint}{others}.")
        raise LinkError(
            f"No walker of robot `{self._robot}` at {self._endpoint} takes commands; start one with "
            "`nao-hil walk --serve`."
        )
