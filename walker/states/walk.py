"""Walking: advance the plan, correct it, ask for the joint angles."""

from __future__ import annotations

from dataclasses import dataclass

from bridge.messages import SensorFrame
from walker.estimation import Estimate
from walker.footing import Footing, FootingMachine
from walker.gait import Gait, Reference
from walker.order import WalkOrder
from walker.stabiliser import Stabiliser
from walker.states.stand import Standing
from walker.states.state import State, StateName


@dataclass
class WalkPlan:
    """The gait and where it is, as the controller and its states see it."""

    gait: Gait
    order: WalkOrder
    reference: Reference
    """The plan of this cycle."""


class Walking:
    """Walks until the order is carried out.

    Args:
        plan: the gait in its initial stand, and how far to go.
        footing: phases against contacts.
        stabiliser: makes joint angles of plans.
    """

    def __init__(self, plan: WalkPlan, footing: FootingMachine, stabiliser: Stabiliser) -> None:
        self._plan = plan
        self._footing_machine = footing
        self._stabiliser = stabiliser
        self._footing = Footing("both")
        self._walked = 0.0
        self.name: StateName = "walk"
        self.settled = 0.0
        self.position: tuple[float, ...] = ()
        self.stiffness = 1.0

    def watch(self, estimate: Estimate) -> None:
        """Take in a cycle before the walk begins."""
        self._stabiliser.watch(estimate)

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> State:
        """One cycle."""
        self._walked += dt
        if not self._footing.wait:
            self._plan.reference = self._plan.gait.advance(dt, go_on=self._go_on())
        reference = self._plan.reference
        self._footing = self._footing_machine.update(reference, estimate.contacts, dt)
        self.position = self._stabiliser.angles(reference, self._footing, estimate, frame, dt)
        if self.name == "stopping" and reference.phase == "stand":
            return Standing(self.position)
        return self

    def _go_on(self) -> bool:
        """Whether another step is wanted after the one under way."""
        order = self._plan.order
        enough = bool(order.steps) and self._plan.reference.step >= order.steps - 1
        if enough or self._walked >= order.duration:
            self.name = "stopping"
        return self.name == "walk"
