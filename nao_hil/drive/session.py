"""One driver of one walker, from the terminal or from the page."""

from __future__ import annotations

import time
from typing import Final, Protocol

import msgspec

from bridge.errors import LinkError, WalkRefused
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.types import Vec3
from nao_hil.drive.driver import HOLD, LEARNED_SPEED, Driver, DriveTarget
from walker.gaits import GAITS, gait_parameters

KEEPALIVE_INTERVAL: Final = 1.0
"""s between two signs of life of the driver."""
RESTING: Final = ("stand", "fallen", "motion", "rest")
"""States of a walker without a walk."""


class Walker(Protocol):
    """A client that takes commands: `bridge.link.client.WalkClient`."""

    def send(self, command: WalkCommand) -> WalkStatus:
        """Carry out a command."""

    def status(self) -> WalkStatus:
        """State of the walker."""


class Session:
    """Drives a walker by keys and a stick.

    Raises:
        LinkError: no walker there takes commands.
        WalkRefused: the walker has no robot.
    """

    def __init__(self, walker: Walker) -> None:
        self._walker = walker
        speeds = {gait: gait_parameters(gait).periodic_step.velocity for gait in GAITS}
        self.status: WalkStatus = walker.status()
        speeds.setdefault(self.status.gait, LEARNED_SPEED)
        self.driver = Driver({gait: speed for gait, speed in speeds.items() if speed > 0.0})
        self.target = self.driver.at_rest(self.status)
        self.commands = self.refused = 0
        """Sent, and refused of them."""
        self.reply = ""
        """Reply of the walker to the last command."""
        self._last_sent = time.monotonic()
        self.walks = False
        """Whether this driver's walk may be under way."""
        self._rests = False
        """Whether it was over at the last keepalive."""

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
        if self.walks and time.monotonic() - self._last_sent > KEEPALIVE_INTERVAL:
            self._keep_alive()
        else:
            self.status = self._walker.status()

    def _keep_alive(self) -> None:
        """Extend the walk; one that has ended, by its bounds, a fall or another's order, is not begun again.

        Between two gaits the robot stands for a moment; so the walk is over at the second look.
        """
        self._last_sent = time.monotonic()
        try:
            self.status = self._walker.send(WalkCommand(op="set", hold=HOLD))
            rests = self.status.state in RESTING
        except WalkRefused:  # the walker has lost its robot
            rests = True
        if rests and self._rests:
            self.target, self.walks = self.driver.at_rest(self.status), False
        self._rests = rests

    def order(self, command: WalkCommand) -> str:
        """Carry out a command of another form; a walk is kept alive, whatever its bounds.

        Returns:
            The walker's sentence.

        Raises:
            LinkError: the walker does not answer.
            WalkRefused: the walker's own sentence.
        """
        if command.op == "walk":
            command = msgspec.structs.replace(command, hold=HOLD)
        self.status = self._walker.send(command)
        self.target = self.driver.at_rest(self.status)
        self._note(command)
        return self.status.text

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
        self._note(command)
        self.reply = self.status.text
        return True

    def _note(self, command: WalkCommand) -> None:
        if command.op != "set":
            self.walks, self._rests = command.op == "walk", False
            self._last_sent = time.monotonic()

    def end(self) -> None:
        """Leave the robot standing."""
        try:
            self.status = self._walker.send(WalkCommand(op="stop"))
        except (LinkError, WalkRefused):
            self.reply = "The walker does not answer any more."
