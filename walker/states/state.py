"""The interface of every state, and the orders for head and arms over a state's answer."""

from __future__ import annotations

from typing import Final, Literal, Protocol

from bridge.body.joints import INDEX, LEG_SLOTS, N_JOINTS
from bridge.messages import SensorFrame
from bridge.messages.walk import UpperBody
from walker.estimation.ground import Corrections
from walker.monitor import Estimate

StateName = Literal["approach", "walk", "stopping", "stand", "fallen", "motion", "rest"]


class State(Protocol):
    """Answers sensor frames; `walker.transitions` decides when another state takes over."""

    @property
    def name(self) -> StateName:
        """For telemetry."""
        ...

    @property
    def settled(self) -> float:
        """Time for which the robot has done nothing more in a final state, s; 0 in the others."""
        ...

    @property
    def position(self) -> tuple[float, ...]:
        """Joint angles asked for in this cycle, 25 slots, rad."""
        ...

    @property
    def stiffness(self) -> float:
        """Stiffness asked for of all joints in this cycle."""
        ...

    @property
    def corrections(self) -> Corrections:
        """Difference of `position` from the plan's angles."""
        ...

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """One cycle.

        Args:
            frame: newest sensor frame.
            estimate: from this frame.
            dt: time since the last one, s.
        """
        ...


def legs_hold(frame: SensorFrame, stiffness: float) -> bool:
    """Whether all joints of the legs are stiffer than a state that gives way has them.

    Args:
        frame: newest sensor frame.
        stiffness: that the state asks for.
    """
    return min(frame.stiffness[slot] for slots in LEG_SLOTS.values() for slot in slots) > 2.0 * stiffness


RETURN_RATE: Final = 2.0
"""rad/s at which a joint without an order returns to the state's angle."""


class UpperBodyOrders:
    """Puts the newest order over a state's angles."""

    def __init__(self) -> None:
        self._ordered: dict[int, tuple[float, float]] = {}
        """Slot -> angle and stiffness."""
        self._away: dict[int, float] = {}
        """Slot -> angle of the last cycle, of each joint that is not at the state's angle."""

    def take(self, order: UpperBody) -> None:
        """Use this order from now on."""
        rows = zip(order.joints, order.position, order.stiffness, strict=True)
        self._ordered = {INDEX[joint]: (angle, stiffness) for joint, angle, stiffness in rows}

    def merged(self, state: State, dt: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Angles and stiffnesses of this cycle, 25 slots; a robot that fell or plays a motion has its own.

        Args:
            state: of the controller.
            dt: time since the last cycle, s.
        """
        position, stiffness = state.position, (state.stiffness,) * N_JOINTS
        if state.name in ("fallen", "motion", "rest"):
            self._away.clear()
        if state.name in ("fallen", "motion", "rest") or not (self._ordered or self._away):
            return position, stiffness
        angles, stiff = list(position), list(stiffness)
        for slot, last in list(self._away.items()):
            angles[slot] = min(max(position[slot], last - RETURN_RATE * dt), last + RETURN_RATE * dt)
            self._away[slot] = angles[slot]
            if angles[slot] == position[slot]:
                del self._away[slot]
        for slot, (angle, value) in self._ordered.items():
            angles[slot], stiff[slot] = angle, value
            self._away[slot] = angle
        return tuple(angles), tuple(stiff)
