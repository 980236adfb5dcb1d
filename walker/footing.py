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

from typing import Final, NamedTuple

from bridge.datasheet.model import Side
from walker.admittance import Role
from walker.estimation import Contacts
from walker.gait import Reference
from walker.gait.reference import Support
from walker.parameters.model import TouchDownParameters

OTHER: Final[dict[Side, Side]] = {"L": "R", "R": "L"}


class Footing(NamedTuple):
    """What each leg is there for in this cycle."""

    support: Support
    """The leg that bears the weight."""
    progress: float = 1.0
    """Share of the swing that has passed, 0..1; 1 for a foot that should have landed."""
    search: float = 0.0
    """How far the swing foot is to be lowered in search of late ground, m."""
    wait: bool = False
    """The plan is to wait for the swing foot."""

    def role(self, side: Side) -> Role:
        """Of one leg, for its admittance."""
        return "stance" if self.support in (side, "both") else "swing"


class FootingMachine:
    """Follows the plan's supports, and keeps a foot in its swing until it has landed.

    Args:
        parameters: bounds of the search for late ground; None: the plan is believed.
    """

    def __init__(self, parameters: TouchDownParameters | None) -> None:
        self._p = parameters
        self._landing: Side | None = None
        self._late = 0.0

    def update(self, reference: Reference, contacts: Contacts, dt: float) -> Footing:
        """One cycle.

        Args:
            reference: the plan.
            contacts: of the feet.
            dt: time since the last cycle, s.
        """
        if self._p is None or reference.support != "both":
            if reference.support != "both":
                self._landing, self._late = OTHER[reference.support], 0.0
            return Footing(reference.support, reference.progress)
        if self._landing is None or contacts.of(self._landing):
            return self._landed()
        self._late += dt
        if self._late > max(self._p.hold, self._p.reach / self._p.rate):
            return self._landed()
        return Footing(
            OTHER[self._landing],
            search=min(self._p.rate * self._late, self._p.reach),
            wait=self._late <= self._p.hold,
        )

    def _landed(self) -> Footing:
        self._landing = None
        return Footing("both")
