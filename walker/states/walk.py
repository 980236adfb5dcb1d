"""Walking: advance the plan, correct it, ask for the joint angles."""

from __future__ import annotations

from dataclasses import dataclass

from bridge.messages import SensorFrame
from walker.estimation import Estimate
from walker.fade import Fade
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
        held: joint angles held before, from which the walk is to begin without a jump, rad; None: those of the
            plan.
        walked: time that the order was walked before, s.
    """

    def __init__(
        self,
        plan: WalkPlan,
        footing: FootingMachine,
        stabiliser: Stabiliser,
        held: tuple[float, ...] | None = None,
        walked: float = 0.0,
    ) -> None:
        self._plan = plan
        self._footing_machine = footing
        self._stabiliser = stabiliser
        self._footing = Footing("both")
        self.walked = walked
        """Time that the order was walked, s."""
        self._held = held
        self._fade: Fade | None = None
        self._successor: tuple[Stabiliser, FootingMachine] | None = None
        self.name: StateName = "walk"
        self.settled = 0.0
        self.position: tuple[float, ...] = ()
        self.stiffness = 1.0

    def watch(self, estimate: Estimate) -> None:
        """Take in a cycle before the walk begins."""
        self._stabiliser.watch(estimate)

    def stop(self) -> None:
        """Wish for no further step: the feet come together, then the robot stands."""
        self.name = "stopping"

    def switch(self, stabiliser: Stabiliser, footing: FootingMachine) -> None:
        """Go on with other controllers from the next cycle on, without a jump."""
        self._successor = stabiliser, footing

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> State:
        """One cycle."""
        self.walked += dt
        righting = self._stabiliser.righting and self._plan.reference.phase == "stand"
        if not self._footing.wait and not righting:
            self._plan.reference = self._plan.gait.advance(dt, go_on=self._go_on())
        reference = self._plan.reference
        self._footing = self._footing_machine.update(reference, estimate.contacts, dt)
        self.position = self._angles(frame, estimate, dt)
        if self.name == "stopping" and reference.phase == "stand":
            return Standing(self.position, self._stabiliser)
        return self

    def _angles(self, frame: SensorFrame, estimate: Estimate, dt: float) -> tuple[float, ...]:
        reference = self._plan.reference
        angles = self._stabiliser.angles(reference, self._footing, estimate, frame, dt)
        if self._held is not None:
            self._fade, self._held = Fade(self._held, angles), None
        if self._fade is not None:
            angles = self._fade.apply(angles, dt)
        if self._successor is not None:
            (self._stabiliser, self._footing_machine), self._successor = self._successor, None
            after = self._stabiliser.angles(reference, self._footing, estimate, frame, dt)
            self._fade = Fade(angles, after)
        elif self._fade is not None and self._fade.done:
            self._fade = None
        return angles

    def _go_on(self) -> bool:
        """Whether another step is wanted after the one under way."""
        order = self._plan.order
        enough = bool(order.steps) and self._plan.reference.step >= order.steps - 1
        if enough or self.walked >= order.duration:
            self.name = "stopping"
        return self.name == "walk"
