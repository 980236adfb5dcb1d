"""The states of a robot on its feet: standing, walking, and the approach from wherever the joints are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from bridge.body.joints import LEG_SLOTS, N_JOINTS
from bridge.messages import SensorFrame
from walker.estimation.contact import SupportState, SupportStateMachine
from walker.estimation.ground import Corrections
from walker.functions import quintic
from walker.gaits.order import WalkPlanner
from walker.monitor import Estimate
from walker.policy import PolicyRunner
from walker.stabilizer import Stabilizer
from walker.states.state import State, StateName

APPROACH_RATE: Final = 0.6
"""rad/s; the fastest joint's mean speed (assumed safe: a sixth of the slowest leg joint's no-load speed)."""
MIN_APPROACH_TIME: Final = 1.0
"""Shortest approach, s."""


class JointInterpolation:
    """Rest-to-rest motion in joint space.

    Args:
        start: measured angles, 25 slots, rad.
        goal: angles to reach, 25 slots, rad.
    """

    def __init__(self, start: tuple[float, ...], goal: tuple[float, ...]) -> None:
        self._start, self._goal = start, goal
        way = max(abs(goal[i] - start[i]) for i in range(N_JOINTS))
        self._duration = max(MIN_APPROACH_TIME, way / APPROACH_RATE)
        self._t = 0.0

    @property
    def done(self) -> bool:
        """The goal has been commanded, and half a second given to settle there."""
        return self._t >= self._duration + 0.5

    def advance(self, dt: float) -> tuple[float, ...]:
        """Angles `dt` seconds later, 25 slots, rad."""
        self._t += dt
        return tuple(
            quintic(a, b, self._duration, self._t).position
            for a, b in zip(self._start, self._goal, strict=True)
        )


TRANSFER_TIME: Final = 1.0
"""s; a jump of 0.1 rad is at most 0.19 rad/s fast."""


class BumplessTransfer:
    """Adds the difference of the angles at the switch, and lets it decay to zero.

    Args:
        before: joint angles before the switch, rad.
        after: those that the new controller asks for at the same instant, rad.
    """

    def __init__(self, before: tuple[float, ...], after: tuple[float, ...]) -> None:
        self._jump = tuple(b - a for b, a in zip(before, after, strict=True))
        self._t = 0.0

    @property
    def done(self) -> bool:
        """The jump has decayed."""
        return self._t >= TRANSFER_TIME

    def apply(self, angles: tuple[float, ...], dt: float) -> tuple[float, ...]:
        """The new controller's angles with the rest of the jump.

        Args:
            angles: of the new controller in this cycle, 25 slots, rad.
            dt: time since the last cycle, s.
        """
        self._t += dt
        remaining = quintic(1.0, 0.0, TRANSFER_TIME, self._t).position
        return tuple(a + remaining * jump for a, jump in zip(angles, self._jump, strict=True))


class Standing:
    """Holds the last angles of the walk, corrections included: both feet are on the ground they found.

    Args:
        position: joint angles, 25 slots, rad.
        stabilizer: of the last walk and the next; its filters continue.
        corrections: in `position`.
    """

    name: Final[StateName] = "stand"

    def __init__(
        self, position: tuple[float, ...], stabilizer: Stabilizer | PolicyRunner, corrections: Corrections
    ) -> None:
        self.position = position
        self.stiffness = 1.0
        self.settled = 0.0
        self.corrections = corrections._replace(common=(0.0, 0.0))
        self._stabilizer = stabilizer

    def settle(self, estimate: Estimate) -> None:
        """One cycle before the robot stands; see `Stabilizer.settle`."""
        self._stabilizer.settle(estimate)

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """Keep standing."""
        self.settled += dt
        self._stabilizer.settle(estimate)


class Walking:
    """Walks until the order is carried out.

    Args:
        planner: of a walk that has not begun.
        support_machine: phases against contacts.
        stabilizer: makes joint angles of plans.
        before: the state from which the walk begins without a jump; None: begin at the plan.
        walked: time already spent on the order, s.
    """

    def __init__(
        self,
        planner: WalkPlanner,
        support_machine: SupportStateMachine,
        stabilizer: Stabilizer | PolicyRunner,
        before: State | None = None,
        walked: float = 0.0,
    ) -> None:
        self._planner = planner
        self._support_machine = support_machine
        self._stabilizer = stabilizer
        self._support_state = SupportState("both")
        self.walked = walked
        """Time spent on the order, s."""
        self._held = before.position if before is not None else None
        self._transfer: BumplessTransfer | None = None
        self._successor: tuple[Stabilizer | PolicyRunner, SupportStateMachine] | None = None
        self.name: StateName = "walk"
        self.settled = 0.0
        self.position: tuple[float, ...] = ()
        self.stiffness = stabilizer.stiffness
        self.corrections = before.corrections if before is not None else Corrections()

    def settle(self, estimate: Estimate) -> None:
        """One cycle before the walk begins; see `Stabilizer.settle`."""
        self._stabilizer.settle(estimate)

    def stop(self) -> None:
        """Request no further step: the feet close, then the robot stands."""
        self.name = "stopping"

    @property
    def failure(self) -> str:
        """Why no further joint angles can be made; empty: they can."""
        return self._stabilizer.failure

    @property
    def feet_closed(self) -> bool:
        """The plan is at rest: the walk is over."""
        return self._planner.plan.phase == "stand"

    def standing(self) -> Standing:
        """The stand at the end of the walk."""
        return Standing(self.position, self._stabilizer, self.corrections)

    def switch(self, stabilizer: Stabilizer | PolicyRunner, support_machine: SupportStateMachine) -> None:
        """Continue with other controllers from the next cycle on, without a jump."""
        self._successor = stabilizer, support_machine

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """One cycle."""
        self.walked += dt
        plan = self._planner.plan
        ground_alignment_active = self.corrections.ground_alignment_active and plan.phase == "stand"
        if not self._support_state.wait and not ground_alignment_active:
            plan = self._planner.step(dt, walk=self._step_wanted(), feedback=estimate.feedback)
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

    def _step_wanted(self) -> bool:
        """Whether another step is wanted after the one under way."""
        order = self._planner.order
        enough = bool(order.steps) and self._planner.plan.step >= order.steps - 1
        if enough or self.walked >= order.duration:
            self.name = "stopping"
        return self.name == "walk"


NEAR_STAND: Final = 0.35
"""rad from a leg joint to the stand: the vendor's StandInit is 0.26 from that of `omni`."""
LEGS: Final = (*LEG_SLOTS["L"], *LEG_SLOTS["R"])


class Approaching:
    """Moves all joints slowly to where the walk begins.

    Args:
        goal: joint angles to reach, 25 slots, rad.
        successor: the state that follows.
        begin: joint angles to ask for at first, 25 slots, rad, by the first frame.
    """

    name: Final[StateName] = "approach"
    settled: Final = 0.0
    corrections: Final = Corrections()

    def __init__(
        self,
        goal: tuple[float, ...],
        successor: Walking | Standing,
        begin: Callable[[SensorFrame], tuple[float, ...]],
    ) -> None:
        self._goal = goal
        self.successor = successor
        """The state that follows."""
        self._begin = begin
        self._approach: JointInterpolation | None = None
        self.position = goal
        self.stiffness = 1.0

    @property
    def near(self) -> bool:
        """Whether a walk may begin at once: the legs are near the goal, from where the walk blends them in."""
        if self._approach is None:
            return False
        return max(abs(self._goal[i] - self.position[i]) for i in LEGS) <= NEAR_STAND

    @property
    def to_stand(self) -> bool:
        """Whether no walk follows."""
        return isinstance(self.successor, Standing)

    @property
    def done(self) -> bool:
        """The successor's pose is reached."""
        return self._approach is not None and self._approach.done

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """One cycle."""
        if self._approach is None:
            self._approach = JointInterpolation(self._begin(frame), self._goal)
        self.position = self._approach.advance(dt)
        self.successor.settle(estimate)
