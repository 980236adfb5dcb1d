"""Pushes in the picture: an arrow that shows one, and dragging the robot, which gives one."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from bridge.rotations import R_yaw
from bridge.types import Array
from nao_hil.view.scene.lines import show
from nao_hil.view.scene.palette import PUSH, ROOT

NEWTON_SECOND: Final = 0.12
"""Length of the arrow, m/(N s)."""
TORSO_OVER: Final = 0.06
"""Height of its head over the torso's origin, m."""
ARROW_TIME: Final = 8.0
"""How long it is shown, s."""
STEEP: Final = 0.15
"""Sine of the angle below which somebody who looks along the floor sees no place on it."""

Dragged = Callable[[tuple[float, float], bool], None]


class PushArrow:
    """An arrow whose head is at the torso.

    Args:
        scene: `viser.ViserServer.scene`.
    """

    def __init__(self, scene: Any) -> None:
        self._impulse, self._until, self._heading = (0.0, 0.0), 0.0, 0.0
        self._arrow = scene.add_arrows(
            f"{ROOT}/push",
            np.array([[[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]], dtype=np.float32),
            PUSH,
            shaft_radius=0.008,
            head_radius=0.02,
            head_length=0.04,
            visible=False,
        )

    def aim(self, impulse: tuple[float, float]) -> None:
        """Show an impulse, N s, ahead and to the left of the robot, for a while."""
        self._impulse, self._until = impulse, time.monotonic() + ARROW_TIME

    def draw(self, torso: Array, heading: float) -> None:
        """Where the robot is now: position of its torso, shape (3,), m, and its heading, rad."""
        self._heading = heading
        shown = time.monotonic() < self._until
        show(self._arrow, shown)
        if shown:
            head = torso + np.array([0.0, 0.0, TORSO_OVER])
            way = NEWTON_SECOND * (R_yaw(heading) @ (*self._impulse, 0.0))
            self._arrow.points = np.array([[head - way, head]], dtype=np.float32)

    def on_drag(self, act: Dragged) -> Callable[[Any], None]:
        """What viser is to call when a person drags the robot.

        Args:
            act: Told the impulse that the way stands for, N s, ahead and to the left of the robot, and whether
                the person has let go.
        """

        def dragged(event: Any) -> None:
            way = level_way(
                *(np.array(p) for p in (event.start_position, event.end_position, event.client.camera.position))
            )
            x, y, _ = R_yaw(-self._heading) @ way / NEWTON_SECOND
            act((float(x), float(y)), event.phase == "end")

        return dragged


def level_way(start: Array, end: Array, eye: Array) -> Array:
    """The level way from a point to where somebody at `eye` sees another, m, shape (3,)."""
    sight = end - eye
    if sight[2] < -STEEP * float(np.linalg.norm(sight)):
        end = eye + (start[2] - eye[2]) / sight[2] * sight
    way: Array = (end - start) * (1.0, 1.0, 0.0)
    return way
