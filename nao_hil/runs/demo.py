"""The walk of `nao-hil demo`: a fixed plan, with a caption for each part."""

from __future__ import annotations

from typing import Final, NamedTuple

from bridge.errors import NaoHilError
from bridge.link.client import WalkClient, WorldClient
from bridge.messages import SensorFrame
from bridge.messages.walk import WalkCommand
from bridge.messages.world import Push
from bridge.types import Closing
from nao_hil.runs.announcer import CAPTION, CONNECT_TIMEOUT, Announcer

ROBOT: Final = "nao-v6"
GAIT: Final = "omni"


class DemoPart(NamedTuple):
    """One part of the demo."""

    lasts: float
    """Robot time, s."""
    text: str
    """Caption."""
    command: WalkCommand | Push | None = None
    """Given when it begins."""


def _walk(x: float, y: float, turn: float) -> WalkCommand:
    return WalkCommand(op="walk", velocity=(x, y, turn))


PARTS: Final = (
    DemoPart(4.0, "It stands. Bars on its feet: loads on the force sensors; red ball: its centre of mass."),
    DemoPart(
        6.0,
        "Ahead at 0.2 m/s, four steps a second. Outlines: footsteps, planned (blue) and made (grey).",
        _walk(0.2, 0.0, 0.0),
    ),
    DemoPart(
        6.0,
        "A turn on the spot at 0.8 rad/s. One motor, HipYawPitch, turns both legs.",
        _walk(0.0, 0.0, 0.8),
    ),
    DemoPart(
        5.0, "Sideways to the left at 0.1 m/s. Every second step only closes the feet.", _walk(0.0, 0.1, 0.0)
    ),
    DemoPart(
        4.0,
        "Ahead at 0.15 m/s, and a push comes. Purple ball: the capture point, where a foot would stop it.",
        _walk(0.15, 0.0, 0.0),
    ),
    DemoPart(
        5.0,
        "Pushed from behind with 1.5 N s, as by a ball of half a kilogram at 3 m/s.",
        Push(impulse=(1.5, 0.0, 0.0)),
    ),
    DemoPart(4.0, "Stop: it slows down over some steps, closes its feet and stands.", WalkCommand(op="stop")),
)


class Demo(Closing):
    """Plays the parts one after the other; use it as a context manager.

    Args:
        robot: Id of the robot; its walker serves.
        endpoint: Zenoh endpoint of the robot.
    """

    def __init__(self, robot: str, endpoint: str) -> None:
        self._robot, self._endpoint = robot, endpoint
        self._part = 0
        self._next: float | None = None
        """Robot time at which the next part begins, s."""
        self._announcer = Announcer(robot, endpoint)
        self.done = False

    def advance(self, frame: SensorFrame | None, state: str) -> None:
        """Begin the part that is due.

        Args:
            frame: The robot's newest.
            state: The walker's, as in `WalkTelemetry`; the first part begins at the first `stand`.
        """
        if self._next is None and frame is not None and state == "stand":
            self._next = frame.time
        if self._next is None or frame is None or frame.time < self._next or self.done:
            return
        if self._part == len(PARTS):
            self.done = True
            return
        part = PARTS[self._part]
        self._part += 1
        self._next = frame.time + part.lasts
        self._announcer.announce(CAPTION, part.text, frame.seq)
        try:
            self._send(part.command)
        except NaoHilError as error:  # after a fall, for example: its sentence is shown, the demo continues
            self._announcer.announce(CAPTION, str(error), frame.seq)

    def _send(self, command: WalkCommand | Push | None) -> None:
        if isinstance(command, Push):
            with WorldClient(self._robot, self._endpoint) as world:
                world.send(command)
        elif command is not None:
            with WalkClient(self._robot, self._endpoint, CONNECT_TIMEOUT) as walker:
                walker.send(command)

    def close(self) -> None:
        """Leave the network."""
        self._announcer.close()
