"""One driver of one walker, from the terminal or from the page."""

from __future__ import annotations

import time
from typing import Final, Protocol

from bridge.errors import LinkError, WalkRefused
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.types import Vec3
from nao_hil.drive.driver import Driver, DriveTarget
from walker.gaits import GAITS, gait_parameters

KEEPALIVE_INTERVAL: Final = 1.0
"""s between two signs of life of the driver."""


class Walker(Protocol):
    """A client that takes commands: `bridge.link.client.WalkClient`."""

    def send(self, command: WalkCommand) -> WalkStatus:
        """Carry out a command."""

    def status(self) -> WalkStatus:
        """State of the walker."""

    def stop(self) -> WalkStatus:
        """Let it close its feet."""


class Session:
    """Drives a walker by keys and a stick.

    Args:
        walker: The walker to drive.

    Raises:
        LinkError: no walker there takes commands.
        WalkRefused: the walker has no robot.
    """

    def __init__(self, walker: Walker) -> None:
        self._walker = walker
        speeds = {gait: gait_parameters(gait).periodic_step.velocity for gait in GAITS}
        self.driver = Driver({gait: speed for gait, speed in speeds.items() if speed > 0.0})
        self.status: WalkStatus = walker.status()
        self.target = self.driver.at_rest(self.status)
        self.commands = self.refused = 0
        """Sent, and refused of them."""
        self.reply = ""
        """Reply of the walker to the last command."""
        self._last_sent = time.monotonic()

    def take(self, keys: list[str], stick: float | None = None) -> None:
        """Carry out the input, send a keepalive if one is due, and read the robot's state.

        Args:
            keys: As in `nao_hil.drive.driver.HELP`.
            stick: Deflection forwards, -1..1; None: not moved.

        Raises:
            LinkError: the walker does not answer.
        """
        if (keys or stick is not None) and not any(self.driver.velocity(self.target)):
            self.status = self._walker.status()
            if self.status.state == "walk":  # ordered by another driver
                self.target = self.driver.under_way(self.status)
        for key in keys:
            self._turn(self.driver.press(self.target, key), key)
        if stick is not None:
            self._turn(self.driver.stick(self.target, stick))
        again = self.driver.keepalive(self.target)
        if again is not None and time.monotonic() - self._last_sent > KEEPALIVE_INTERVAL:
            if not self._send(again):  # after a fall, for one: a new order is needed
                self.target = self.driver.press(self.target, "x")
        else:
            self.status = self._walker.status()

    def steer(self, velocity: Vec3) -> None:
        """Walk at a velocity, m/s, m/s, rad/s; zeros stop. Raises as `take`."""
        self._turn(self.driver.steer(self.target, velocity), "" if any(velocity) else "x")

    def _turn(self, target: DriveTarget, key: str = "") -> None:
        command = self.driver.command(self.target, target, key)
        if command is None or self._send(command):
            self.target = target  # a target that the walker refused is dropped

    def _send(self, command: WalkCommand) -> bool:
        self.commands += 1
        self._last_sent = time.monotonic()
        try:
            self.status = self._walker.send(command)
        except WalkRefused as refusal:
            self.refused += 1
            self.reply = str(refusal)
            return False
        self.reply = self.status.text
        return True

    def end(self) -> None:
        """Leave the robot standing."""
        try:
            self.status = self._walker.stop()
        except (LinkError, WalkRefused):
            self.reply = "The walker does not answer any more."
