"""ALMotion's walking methods: their arguments, and the walks that they ask the walker for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any, Final

from bridge.adapters.naoqi.arguments import number
from bridge.adapters.naoqi.walker_handover import WalkerHandover
from bridge.errors import NaoqiRefused
from bridge.rotations import planar_point
from bridge.types import Vec3

_WIDTH: Final = 0.1
"""Distance of the feet where a robot stands, m."""
_LONGEST: Final = 1.0
"""m and rad in a footstep; NAOqi's own bound is a tenth."""

_SHARE: Final = 0.7
"""Of the gait's full speed, for walks to a place."""


class WalkingMethods:
    """Walking methods of `ALMotion`; thread-safe.

    Args:
        handover: of the robot between this side and the walker.
        full: what `moveToward` calls 1 forward and to the left, m/s, and as a turn, rad/s; the last two are 0
            for a gait that walks straight ahead.
    """

    def __init__(self, handover: WalkerHandover, full: Vec3) -> None:
        self.handover, self._full = handover, full

    def move(self, x: Any, y: Any, theta: Any, *_: Any) -> Future[Any]:
        """Walk at a velocity, m/s and rad/s; returns when the walker has accepted it."""
        velocity = _three("ALMotion.move", (x, y, theta), 1e4)
        return self.handover.walk(velocity)

    def move_toward(self, x: Any, y: Any, theta: Any, *_: Any) -> Future[Any]:
        """Walk at fractions of the gait's full speed, -1 to 1."""
        fraction, side, turn = self._possible(
            "ALMotion.moveToward", _three("ALMotion.moveToward", (x, y, theta), 1.0)
        )
        ahead, aside, around = self._full
        return self.handover.walk((fraction * ahead, side * aside, turn * around))

    def move_to(self, x: Any, y: Any = 0.0, theta: Any = 0.0, *_: Any) -> Future[Any]:
        """Walk to a place, m and rad from here; waits for the end. Also as one list `[x, y, theta]`."""
        if isinstance(x, list):
            x, y, theta = (*x, 0.0, 0.0, 0.0)[:3]
        target = self._possible("ALMotion.moveTo", _three("ALMotion.moveTo", (x, y, theta), 1e4))
        if self._full[1]:
            return self._walk_to(target)
        return self.handover.walk_distance((math.copysign(self._full[0], target[0]), 0.0, 0.0), abs(target[0]))

    def set_foot_steps(self, legs: Any, steps: Any, *_: Any) -> Future[Any]:
        """Walk to where footsteps end, by steps of the gait's own.

        Args:
            legs: `LLeg` or `RLeg` for each step.
            steps: `[x, y, theta]` of each foot in the frame of the other one, m and rad.
        """
        method = "ALMotion.setFootSteps"
        if not isinstance(legs, list) or not isinstance(steps, list) or len(legs) != len(steps) or not legs:
            raise NaoqiRefused(f"{method}: a list of legs and one of as many steps [x, y, theta] are expected.")
        half = 0.5 * _WIDTH
        feet = {"LLeg": (0.0, half, 0.0), "RLeg": (0.0, -half, 0.0)}
        for i, (leg, step) in enumerate(zip(legs, steps, strict=True)):
            if leg not in feet:
                raise NaoqiRefused(f"{method}: leg {i} is {leg!r:.60}; LLeg or RLeg is expected.")
            if not isinstance(step, list) or len(step) != 3:
                raise NaoqiRefused(f"{method}: step {i} is {step!r:.60}; [x, y, theta] is expected.")
            other = feet["RLeg" if leg == "LLeg" else "LLeg"]
            feet[leg] = _composed(other, _three(f"{method}, step {i}", step, _LONGEST))
        left, right = feet["LLeg"], feet["RLeg"]
        x, y, turn = (0.5 * (a + b) for a, b in zip(left, right, strict=True))
        return self._walk_to(self._possible(method, (x, y, turn)))

    def _walk_to(self, target: Vec3) -> Future[Any]:
        return self.handover.walk_to(target, (_SHARE * self._full[0], 0.0, 0.0))

    def _possible(self, method: str, wanted: Vec3) -> Vec3:
        """What is wanted, unless the gait walks straight only and it is not straight."""
        _, y, theta = wanted
        if not self._full[1] and (y or theta):
            raise NaoqiRefused(
                f"{method}: y is {y:g} and theta is {theta:g}, but this gait walks straight only; both must be "
                "0. `--gait omni` walks in any direction."
            )
        return wanted

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
            "setFootSteps": self.set_foot_steps,
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


def _three(method: str, values: Sequence[Any], bound: float) -> Vec3:
    x, y, theta = values
    return (
        number(x, f"{method}: x", -bound, bound),
        number(y, f"{method}: y", -bound, bound),
        number(theta, f"{method}: theta", -bound, bound),
    )


def _composed(frame: Vec3, pose: Vec3) -> Vec3:
    """A pose of a frame in the frame's own frame, m and rad."""
    return *planar_point(frame, pose), frame[2] + pose[2]
