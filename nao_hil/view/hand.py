"""The joints of an emulated robot that no controller holds: the page takes its lease and moves them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, JOINTS
from bridge.errors import FrameError, NaoHilError
from nao_hil.connection import connect

SPEED: Final = 1.0
"""At which a joint moves to where its slider is, rad/s."""
WAIT: Final = 3.0
"""s for a robot to answer."""


class Hand:
    """Holds the joints while the page wants to.

    Args:
        body: Whose ranges they have.
        robot: Id of the robot.
        endpoint: Zenoh endpoint of the robot.
        say: Told a sentence where the robot goes away.
    """

    def __init__(self, body: Body, robot: str, endpoint: str, say: Callable[[str], None]) -> None:
        self._body, self._robot, self._endpoint, self._say = body, robot, endpoint, say
        self._end: threading.Event | None = None
        self._held = threading.Event()
        self._wanted = np.zeros(len(JOINTS))

    @property
    def holds(self) -> bool:
        """Whether the page holds the robot."""
        return self._held.is_set()

    def move(self, angles: Mapping[str, float]) -> str:
        """Want these angles, rad; the joints approach them at `SPEED`.

        Raises:
            FrameError: no such joint, or the page does not hold the robot.
        """
        if not self.holds:
            raise FrameError("The page does not hold the robot; take the joints first.")
        for name, angle in angles.items():
            if name not in self._body.joints:
                raise FrameError(f"`{name}` is no joint of {self._body.name}.")
            joint = self._body.joints[name]
            self._wanted[INDEX[name]] = min(max(angle, joint.lower), joint.upper)
        return ""

    def take(self) -> str:
        """Take the robot's lease and hold its joints where they are."""
        if self._end is None:
            self._end = threading.Event()
            threading.Thread(target=self._hold, args=(self._end,), name="hand", daemon=True).start()
        return "The page asks for the robot."

    def let_go(self) -> str:
        """Give the robot back."""
        if self._end is not None:
            self._end.set()
        return "The robot is free."

    def _hold(self, end: threading.Event) -> None:
        try:
            with connect(self._endpoint, robot=self._robot, name="page", timeout=WAIT) as robot:
                target = np.array(robot.frame.position)
                self._wanted[:] = target
                self._held.set()
                self._say("The page holds the robot; its joints go where the sliders are.")
                step = SPEED * self._body.cycle
                while not end.is_set():
                    target += np.clip(self._wanted - target, -step, step)
                    robot.step(target)
        except NaoHilError as error:
            self._say(str(error))
        self._held.clear()
        self._end = None
