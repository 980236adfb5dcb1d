"""A walk made ready: whatever takes time to make is made before the cycle in which the walk begins."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from bridge.body import Body
from bridge.types import Vec3
from walker.estimation.contact import SupportStateMachine
from walker.gaits import Gait, standing_plan
from walker.gaits.gait import PeriodicStep
from walker.gaits.learned.gait import LearnedGait
from walker.gaits.order import WalkOrder
from walker.gaits.pose import PoseMaker
from walker.parameters import ControllerParameters
from walker.policy import PolicyRunner
from walker.stabilizer import Stabilizer


@dataclass(frozen=True, slots=True)
class WalkSetup:
    """A gait, its order, and the controllers for it."""

    gait: Gait[Any]
    order: WalkOrder
    parameters: ControllerParameters
    make_stabilizer: Callable[[], Stabilizer | PolicyRunner]
    """One that remembers nothing."""
    stabilizer: Stabilizer | PolicyRunner
    """Makes joint angles of the plans."""
    goal: tuple[float, ...]
    """Joint angles of the initial stand, rad."""
    step: PeriodicStep | None
    """The gait's periodic step; None: not needed."""
    velocity: Vec3 = (0.0, 0.0, 0.0)
    """Mean velocity by the gait's parameters, m/s, m/s, rad/s."""

    def with_fresh_controllers(self) -> WalkSetup:
        """The same walk with controllers that remember nothing."""
        return replace(self, stabilizer=self.make_stabilizer())

    def support_machine(self) -> SupportStateMachine:
        """Phases against contacts."""
        p = self.parameters
        return SupportStateMachine(p.touch_down if p.switches.late_touch_down else None)


def set_up_walk(
    body: Body,
    gait: Gait[Any],
    order: WalkOrder,
    cycle: float,
    parameters: ControllerParameters,
    step: PeriodicStep | None = None,
    velocity: Vec3 = (0.0, 0.0, 0.0),
) -> WalkSetup:
    """Prepare a walk.

    Args:
        body: data sheet.
        gait: to walk by.
        order: bounds of the walk.
        cycle: of the robot, s.
        parameters: of the controllers.
        step: the gait's periodic step; None: not needed.
        velocity: mean velocity by the gait's parameters, m/s, m/s, rad/s.

    Raises:
        ConfigurationError: no torso controller can be designed to the parameters.
        UnreachableError: the gait's stand is out of the legs' reach.
    """
    make: Callable[[], Stabilizer | PolicyRunner]
    if isinstance(gait, LearnedGait):
        goal, make = gait.default_pose, partial(PolicyRunner, body, gait, parameters, cycle)
    else:
        stand = standing_plan(gait)
        pose = PoseMaker(body, stand, by_pose=gait.quasi_static)
        goal, make = pose.angles(stand), partial(Stabilizer, body, parameters, pose, cycle)
    return WalkSetup(gait, order, parameters, make, make(), goal, step, velocity)
