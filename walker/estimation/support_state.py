"""Where the plan of the phases and the ground disagree: feet that land late, feet that land early.

The phases keep the thesis' times. What the ground changes:

- *Early*: the swing foot touches before its single support ends. The phase goes on and the foot stays a swing
  foot; the leg admittance gives way to the ground as fast as the plan presses against it, so the foot descends
  no further, and it ends as high above the plan as the obstacle is.
- *Late*: the single support ends and the foot touches nothing. The foot stays a swing foot and is lowered
  further, while the plan waits for it if the gait can wait. Both are bounded: then the foot counts as landed,
  and what follows is the fall detector's business.
"""

from __future__ import annotations

from typing import Final, Literal, NamedTuple

import msgspec

from bridge.types import NotNegative, Positive, Side
from walker.estimation.contact import Contacts
from walker.planning.plan import Plan, Support

Role = Literal["swing", "stance"]
OTHER: Final[dict[Side, Side]] = {"L": "R", "R": "L"}


class TouchDownParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What happens when the plan puts a foot down and there is no ground."""

    max_wait: NotNegative = 0.0
    """Time for which the plan waits for the ground, s."""
    search_depth: NotNegative = 0.010
    """How far the foot is lowered beyond `leg.target_depth` in search of the ground, m."""
    search_rate: Positive = 0.04
    """Speed of that, m/s."""


class SupportState(NamedTuple):
    """Which leg bears the weight in this cycle, and how far the other one's swing has come."""

    support: Support
    """The leg that bears the weight."""
    progress: float = 1.0
    """Fraction of the swing that has passed, 0..1; 1 for a foot that should have landed."""
    search_depth: float = 0.0
    """How far the swing foot is to be lowered in search of late ground, m."""
    wait: bool = False
    """The plan is to wait for the swing foot."""

    def role(self, side: Side) -> Role:
        """Of one leg, for its admittance."""
        return "stance" if self.support in (side, "both") else "swing"


class SupportStateMachine:
    """Follows the plan's supports, and keeps a foot in its swing until it has landed.

    Args:
        parameters: bounds of the search for late ground; None: the plan is believed.
    """

    def __init__(self, parameters: TouchDownParameters | None) -> None:
        self._p = parameters
        self._landing: Side | None = None
        self._late = 0.0

    def update(self, plan: Plan, contacts: Contacts, dt: float) -> SupportState:
        """One cycle.

        Args:
            plan: the plan.
            contacts: of the feet.
            dt: time since the last cycle, s.
        """
        if self._p is None or plan.support != "both":
            if plan.support != "both":
                self._landing, self._late = OTHER[plan.support], 0.0
            return SupportState(plan.support, plan.progress)
        if self._landing is None or contacts.of(self._landing):
            return self._landed()
        self._late += dt
        if self._late > max(self._p.max_wait, self._p.search_depth / self._p.search_rate):
            return self._landed()
        return SupportState(
            OTHER[self._landing],
            search_depth=min(self._p.search_rate * self._late, self._p.search_depth),
            wait=self._late <= self._p.max_wait,
        )

    def _landed(self) -> SupportState:
        self._landing = None
        return SupportState("both")
