"""Balance over the foot that landed from a capture step, about the foot's long axis; not in the thesis.

The foot that stayed hangs in the air for up to half a second, since the torso leans towards the landed foot.
Meanwhile the robot is an inverted pendulum on one sole. An ankle that keeps its angle pushes the robot towards
the lean that it had at the landing, and often over the foot that hangs. So the ankle turns with the lean, which
leaves it without a moment, and beyond it by as much as brings the centre of pressure p past the capture point:
with xi' = omega (xi - p) and p = k xi, k > 1, the capture point goes back over the ankle.

Once both feet stand after a step back, the robot comes ahead over a narrow support. Both soles then turn
against the torso's rate.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from bridge.types import NotNegative, Positive, Vec2, Vec3
from walker.estimation import Contacts
from walker.estimation.support_state import OTHER
from walker.functions import clip
from walker.planning.feedback import LandedFoot
from walker.planning.plan import Plan


class LandedFootParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gains and bounds of the balance after a capture step."""

    gain: Positive = 1.5
    """Centre of pressure over the capture point, both from the ankle."""
    max_offset: NotNegative = 0.03
    """Farthest centre of pressure from the ankle, m; the sole ends at 39 and 50 mm (published outline)."""
    turn: NotNegative = 1.5
    """Turn of the ankle over the centre of pressure that it causes, rad/m. The weight over the stiffness of a
    leg about x gives 1.3, 52 N over 40 N m/rad (read off one walk)."""
    landing_time: NotNegative = 0.03
    """Time after the landing in which the ankle turns with the lean even if both feet touch, s."""
    contact_time: NotNegative = 0.015
    """Contact of the other foot after which the robot is on both, s."""
    standing_time: NotNegative = 0.3
    """Contact of both feet after which the robot stands, s."""
    damping: tuple[NotNegative, NotNegative] = (0.10, 0.06)
    """Turn of both soles about x and y over the torso's rate after a step back, s."""
    max_damping: NotNegative = 0.15
    """Largest such turn, rad."""


class LandedFootBalance:
    """Turns the ankle of the foot that landed.

    Args:
        parameters: gains and bounds.
    """

    def __init__(self, parameters: LandedFootParameters) -> None:
        self._p = parameters
        self._stage: Literal["landing", "alone", "both"] = "landing"
        self._since = 0.0
        """Time since the landing, s."""
        self._touches = 0.0
        """Time for which the other foot has touched, s."""
        self._both = 0.0
        """Time for which both feet have touched, s."""
        self.roll: float | None = None
        """Turn of the landed sole about x at which its ankle brings the centre of pressure to its place, rad;
        None: the robot does not stand on that foot alone."""
        self.damping: Vec2 = (0.0, 0.0)
        """To add to the turns of both soles, roll and pitch, rad."""

    @property
    def stands(self) -> bool:
        """Both feet have touched for a while since the landing."""
        return self._both > self._p.standing_time

    def update(
        self, plan: Plan, contacts: Contacts, measured: LandedFoot | None, gyroscope: Vec3, dt: float
    ) -> None:
        """One cycle.

        Args:
            plan: in force.
            contacts: of the feet.
            measured: about the foot that landed.
            gyroscope: angular velocity in the Torso frame, rad/s.
            dt: time since the last cycle, s.
        """
        p = self._p
        self.roll, self.damping = None, (0.0, 0.0)
        if plan.capture is None or plan.support != "both" or measured is None:
            self._stage, self._since, self._touches, self._both = "landing", 0.0, 0.0, 0.0
            return
        touches = contacts.of(OTHER[plan.capture])
        self._since += dt
        self._touches = self._touches + dt if touches else 0.0
        self._both = self._both + dt if touches and contacts.of(plan.capture) else 0.0
        if self._stage == "landing" and not touches:
            self._stage = "alone"
        elif self._stage == "alone" and self._touches > p.contact_time:
            self._stage = "both"
        if self._stage == "alone" or (self._stage == "landing" and self._since < p.landing_time):
            # While the other foot bears as well, nothing is to be brought over the landed one.
            cop = 0.0 if touches else clip(p.gain * measured.xi, -p.max_offset, p.max_offset)
            self.roll = -measured.roll - p.turn * cop
        elif plan.captures_backward:
            roll, pitch = (
                clip(gain * rate, -p.max_damping, p.max_damping)
                for gain, rate in zip(p.damping, gyroscope[:2], strict=True)
            )
            self.damping = roll, pitch if self._stage == "both" else 0.0
