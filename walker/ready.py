"""A walk made ready: whatever takes time to make is made before the cycle in which the walk begins."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace

from bridge.datasheet import Body
from walker.footing import FootingMachine
from walker.gait import Gait
from walker.gait.speed import Step
from walker.order import WalkOrder
from walker.parameters import ControllerParameters
from walker.pose import PoseMaker
from walker.stabiliser import Stabiliser


@dataclass(frozen=True, slots=True)
class ReadyWalk:
    """A gait in its initial stand, how far to go, and the controllers for it."""

    gait: Gait
    order: WalkOrder
    parameters: ControllerParameters
    stabiliser: Stabiliser
    goal: tuple[float, ...]
    """Joint angles of the initial stand, rad."""
    step: Step | None
    """The gait's periodic step; None where nobody asks."""

    def copied(self) -> ReadyWalk:
        """One that can be begun while this one is walked, or after it."""
        return replace(self, gait=copy.deepcopy(self.gait), stabiliser=copy.deepcopy(self.stabiliser))

    def footing(self) -> FootingMachine:
        """Phases against contacts."""
        return FootingMachine(self.parameters.touch_down if self.parameters.admittance else None)


def ready_walk(
    body: Body,
    gait: Gait,
    order: WalkOrder,
    cycle: float,
    parameters: ControllerParameters,
    step: Step | None = None,
) -> ReadyWalk:
    """Make a walk ready; designing a torso controller takes a second.

    Raises:
        ConfigurationError: no torso controller can be designed to the parameters.
        UnreachableError: the gait's stand is out of the legs' reach.
    """
    stand = gait.stand()
    pose = PoseMaker(body, stand, by_pose=gait.quasi_static)
    stabiliser = Stabiliser(body, parameters, pose, cycle)
    return ReadyWalk(gait, order, parameters, stabiliser, pose.angles(stand), step)
