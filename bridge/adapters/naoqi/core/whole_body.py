"""ALMotion's whole-body calls by inverse kinematics: effectors, and the centre of mass over a foot.

The feet stay in place. No controller balances the robot against motions of its arms.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from typing import Annotated, Any, Final

import numpy as np

from bridge.adapters.naoqi.core.cartesian import STEP_TIME, Cartesian
from bridge.adapters.naoqi.core.motion_tasks import MotionTask, pass_on
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import MAX_DURATION, Fraction, OneOf, Range, Vector, offers
from bridge.body import TORSO
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.body.sole import sole_hull
from bridge.types import Array

_FEET: Final = ("LLeg", "RLeg")
_LEGS: Final = ("Legs", *_FEET)
_STATES: Final = ("Fixed", "Plane", "Free")
_MASKS: Final = {"Head": 56, "LArm": 7, "RArm": 7}
"""Following effector -> mask of its axes (vendor's page: the head's angles, the arms' positions)."""
_SPEED: Final = 0.2
"""Speed of an effector to its target, as a fraction of the largest (assumed)."""
_BALANCE_TIME: Final = 1.0
"""Duration of a shift of the centre of mass over a foot at full speed, s (assumed)."""
_FRAME_ROBOT: Final = 2


Leg = Annotated[str, OneOf("leg", _LEGS)]
Follower = Annotated[str, OneOf("effector", _MASKS)]


class WholeBody(Service):
    """Whole-body methods of `ALMotion`."""

    def __init__(self, robot: ServedRobot, cartesian: Cartesian) -> None:
        super().__init__(robot)
        self._cartesian = cartesian
        self._enabled = False
        self._states = dict.fromkeys(_FEET, "Fixed")
        self._followed: set[str] = set()
        """Following effectors."""

    @offers("ALMotion.wbEnableEffectorControl")
    def enable_effector(self, effector: Follower, enabled: bool) -> None:
        """Switch the following of targets on or off."""
        self._followed = self._followed | {effector} if enabled else self._followed - {effector}

    @offers("ALMotion.wbSetEffectorControl", kind="joints")
    def set_effector(
        self, effector: Follower, target: Annotated[list[float], Vector("a, b, c", -10.0, 10.0)]
    ) -> None:
        """Send an effector towards a target in FRAME_ROBOT; does not wait, and does nothing unless it follows.

        Args:
            effector: `Head`, `LArm` or `RArm`.
            target: of the head wx, wy, wz, rad; of an arm x, y, z, m.
        """
        place = [0.0, 0.0, 0.0, *target] if effector == "Head" else [*target, 0.0, 0.0, 0.0]
        if effector in self._followed:
            self._cartesian.move([effector], _FRAME_ROBOT, place, _SPEED, _MASKS[effector])

    def go_to_balance(self, leg: str, seconds: float) -> Future[Any]:
        """Bring the centre of mass over a foot, or between both, by shifting the torso; waits for the end."""
        goal = np.mean([self._sole(one) for one in _feet(leg)], axis=0)
        torso = self._frames.transform(TORSO, _FRAME_ROBOT, False)
        for _ in range(3):
            position = self._cartesian.solved(TORSO, _FRAME_ROBOT, torso)
            torso[:2, 3] += goal - self._frames.com_at("Body", position, _FRAME_ROBOT)[:2]
        path = [[float(x) for x in torso.flat]]
        moving = self._cartesian.along([TORSO], _FRAME_ROBOT, path, 63, [seconds])
        done: Future[Any] = Future()
        moving.add_done_callback(lambda ended: pass_on(ended.exception() is None, done))
        return done

    @offers("ALMotion.angleInterpolation", kind="joints")
    def angle_interpolation(self, names: Any, angles: Any, times: Any, absolute: Any) -> Future[Any]:
        """As `ALMotion.angleInterpolation`; fixed feet stay flat below the torso while leg joints move."""
        moving = self._motion.angle_interpolation(names, angles, times, absolute)
        legs = self._joints.names.resolve("Legs")
        named = [joint for joint in self._joints.names.resolve(names) if joint in legs]
        if named and self._enabled and "Free" not in self._states.values():
            others = [joint for joint in legs if joint not in named]
            return self._tasks.begin(self._keep_feet(moving, named, others))
        return moving

    def _keep_feet(self, moving: Future[Any], named: Sequence[str], others: Sequence[str]) -> MotionTask:
        feet, ended = self._cartesian.feet(), False
        try:
            while not ended:
                ended = moving.done()
                angles = {joint: self._joints.commanded(joint) for joint in named}
                wanted = self._cartesian.on_flat_feet(angles, feet)
                for joint in others:
                    self._joints.put_position(joint, [(STEP_TIME, wanted[INDEX_WITH_MIRROR[joint]])])
                yield self._joints.now + round(1000.0 * STEP_TIME)
        finally:  # also after a stop
            self._tasks.stop_tasks(self._tasks.of(moving))
        return moving.result()

    def _sole(self, leg: str) -> Array:
        """Middle of a sole in the robot's space, (2,), m."""
        corners = np.array(sole_hull(self._frames.body, "L" if leg == "LLeg" else "R"))
        middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
        place: Array = (self._frames.transform(leg, _FRAME_ROBOT, False) @ (*middle, 0.0, 1.0))[:2]
        return place

    @offers("ALMotion.wbEnable")
    def _wb_enable(self, enabled: bool) -> Any:
        self._enabled = enabled
        if not self._enabled:
            self._followed.clear()
            self._states = dict.fromkeys(_FEET, "Fixed")

    @offers("ALMotion.wbFootState")
    def _wb_foot_state(self, state: Annotated[str, OneOf("state", _STATES)], support_leg: Leg) -> Any:
        self._states |= dict.fromkeys(_feet(support_leg), state)

    @offers("ALMotion.wbEnableEffectorOptimization")
    def _wb_enable_effector_optimization(self, effector: Any, active: bool) -> Any:
        self._frames.effector(effector)

    @offers("ALMotion.wbGoToBalance", kind="joints")
    def _wb_go_to_balance(self, support_leg: Leg, duration: Annotated[float, Range(0.1, MAX_DURATION)]) -> Any:
        return self.go_to_balance(support_leg, duration)

    @offers("ALMotion.wbGoToBalanceWithSpeed", kind="joints")
    def _wb_go_to_balance_with_speed(self, support_leg: Leg, speed: Fraction) -> Any:
        return self.go_to_balance(support_leg, _BALANCE_TIME / speed)


def _feet(leg: str) -> tuple[str, ...]:
    return _FEET if leg == "Legs" else (leg,)
