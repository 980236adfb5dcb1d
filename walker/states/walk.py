"""Walking: advance the plan, correct it, ask for the joint angles."""

from __future__ import annotations

from bridge.messages import SensorFrame
from walker.estimation import Corrections, Estimate
from walker.estimation.support_state import SupportState, SupportStateMachine
from walker.planning.planner import WalkPlanner
from walker.stabilization.bumpless import BumplessTransfer
from walker.stabilization.stabilizer import Stabilizer
from walker.states.stand import Standing
from walker.states.state import State, StateName


class Walking:
    """Walks until the order is carried out.

    Args:
        planner: of a walk that has not begun.
        support_machine: phases against contacts.
        stabilizer: makes joint angles of plans.
        before: the state from which the walk begins without a jump; None: begin at the plan.
        walked: time that the order was walked before, s.
    """

    def __init__(
        self,
        planner: WalkPlanner,
        support_machine: SupportStateMachine,
        stabilizer: Stabilizer,
        before: State | None = None,
        walked: float = 0.0,
    ) -> None:
        self._planner = planner
        self._support_machine = support_machine
        self._stabilizer = stabilizer
        self._support_state = SupportState("both")
        self.walked = walked
        """Time that the order was walked, s."""
        self._held = before.position if before is not None else None
        self._transfer: BumplessTransfer | None = None
        self._successor: tuple[Stabilizer, SupportStateMachine] | None = None
        self.name: StateName = "walk"
        self.settled = 0.0
        self.position: tuple[float, ...] = ()
        self.stiffness = 1.0
        self.corrections = before.corrections if before is not None else Corrections()

    def settle(self, estimate: Estimate) -> None:
        """One cycle before the walk begins; see `Stabilizer.settle`."""
        self._stabilizer.settle(estimate)

    def stop(self) -> None:
        """Wish for no further step: the feet come together, then the robot stands."""
        self.name = "stopping"

    @property
    def feet_closed(self) -> bool:
        """The plan is at rest: the walk is over."""
        return self._planner.plan.phase == "stand"

    def standing(self) -> Standing:
        """The stand that the walk ends in."""
        return Standing(self.position, self._stabilizer, self.corrections)

    def switch(self, stabilizer: Stabilizer, support_machine: SupportStateMachine) -> None:
        """Go on with other controllers from the next cycle on, without a jump."""
        self._successor = stabilizer, support_machine

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """One cycle."""
        self.walked += dt
        plan = self._planner.plan
        righting = self.corrections.righting and plan.phase == "stand"
        if not self._support_state.wait and not righting:
            plan = self._planner.step(dt, walk=self._wants_step(), feedback=estimate.feedback)
        self._support_state = self._support_machine.update(plan, estimate.contacts, dt)
        self.position = self._angles(frame, estimate, dt)

    def _angles(self, frame: SensorFrame, estimate: Estimate, dt: float) -> tuple[float, ...]:
        plan = self._planner.plan
        angles, self.corrections = self._stabilizer.update(plan, self._support_state, estimate, frame, dt)
        if self._held is not None:
            self._transfer, self._held = BumplessTransfer(self._held, angles), None
        if self._transfer is not None:
            angles = self._transfer.apply(angles, dt)
        if self._successor is not None:
            (self._stabilizer, self._support_machine), self._successor = self._successor, None
            after, self.corrections = self._stabilizer.update(plan, self._support_state, estimate, frame, dt)
            self._transfer = BumplessTransfer(angles, after)
        elif self._transfer is not None and self._transfer.done:
            self._transfer = None
        return angles

    def _wants_step(self) -> bool:
        """Whether another step is wanted after the one under way."""
        order = self._planner.order
        enough = bool(order.steps) and self._planner.plan.step >= order.steps - 1
        if enough or self.walked >= order.duration:
            self.name = "stopping"
        return self.name == "walk"
