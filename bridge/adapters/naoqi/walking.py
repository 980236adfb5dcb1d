"""ALMotion's walking methods: their arguments, and the walks that they ask the walker for."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from bridge.adapters.naoqi.arguments import number
from bridge.adapters.naoqi.walker_handover import WalkerHandover
from bridge.errors import NaoqiRefused
from bridge.types import Vec3


class WalkingMethods:
    """Walking methods of `ALMotion`; thread-safe.

    Args:
        handover: of the robot between this side and the walker.
        speed: of the gait, m/s: what `moveToward` calls 1, and how fast `moveTo` walks.
    """

    def __init__(self, handover: WalkerHandover, speed: float) -> None:
        self.handover, self._speed = handover, speed

    def move(self, x: Any, y: Any, theta: Any, *_: Any) -> Future[Any]:
        """Walk at a velocity, m/s and rad/s; returns when the walker has accepted it."""
        velocity = _three("ALMotion.move", x, y, theta, 1e4)
        return self.handover.walk(velocity)

    def move_toward(self, x: Any, y: Any, theta: Any, *_: Any) -> Future[Any]:
        """Walk at fractions of the gait's speed, -1 to 1."""
        fraction, side, turn = _three("ALMotion.moveToward", x, y, theta, 1.0)
        _require_straight("ALMotion.moveToward", side, turn)
        return self.handover.walk((fraction * self._speed, 0.0, 0.0))

    def move_to(self, x: Any, y: Any = 0.0, theta: Any = 0.0, *_: Any) -> Future[Any]:
        """Walk a distance, m; waits for the end. Also as one list `[x, y, theta]`."""
        if isinstance(x, list):
            x, y, theta = (*x, 0.0, 0.0, 0.0)[:3]
        distance, side, turn = _three("ALMotion.moveTo", x, y, theta, 1e4)
        _require_straight("ALMotion.moveTo", side, turn)
        return self.handover.walk_distance((math.copysign(self._speed, distance), 0.0, 0.0), abs(distance))

    def methods(self) -> dict[str, Callable[..., Any]]:
        """Methods of `ALMotion` that walk, and that tell of the walk."""
        handover = self.handover
        return {
            "moveInit": handover.prepare,
            "walkInit": handover.prepare,
            "move": self.move,
            "moveToward": self.move_toward,
            "setWalkTargetVelocity": lambda x, y, theta, *_: self.move_toward(x, y, theta),
            "moveTo": self.move_to,
            "walkTo": self.move_to,
            "stopMove": handover.stop,
            "stopWalk": handover.stop,
            "killMove": handover.stop,
            "killWalk": handover.stop,
            "moveIsActive": lambda: handover.active,
            "walkIsActive": lambda: handover.active,
            "waitUntilMoveIsFinished": handover.wait,
            "waitUntilWalkIsFinished": handover.wait,
            "getRobotPosition": lambda *_: handover.position(),
            "getNextRobotPosition": lambda *_: handover.position(),
            "getRobotVelocity": handover.velocity,
        }


def _three(method: str, x: Any, y: Any, theta: Any, bound: float) -> Vec3:
    return (
        number(x, f"{method}: x", -bound, bound),
        number(y, f"{method}: y", -bound, bound),
        number(theta, f"{method}: theta", -bound, bound),
    )


def _require_straight(method: str, y: float, theta: float) -> None:
    if y or theta:
        raise NaoqiRefused(
            f"{method}: y is {y:g} and theta is {theta:g}, but the gaits walk straight only; both must be 0."
        )
