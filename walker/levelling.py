"""Keep the swing foot level, whatever the torso does.

A NAO on one leg sags towards its swing foot: by 7 degrees with the play and compliance of a used robot. Its
swing foot then comes down 12 mm early and tilted, and the admittances, which know the plan only, would take it
for the ground: held in stance, the tilt would stay for good and add up with every step. So the swing foot is
turned about the stance foot by the measured angle of the torso while it is in the air; what the admittances add
is the ground alone. Once both feet stand the turn fades out, and the legs push the torso upright as planned.

Not in the thesis; `share = 0` leaves it out. Roll is levelled whenever the admittance is on, as nothing else
looks after it. Pitch belongs to torso control: without it the error of figure 4.9 grows as in the thesis.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from bridge.datasheet.model import Side
from bridge.messages import Vec2
from walker.admittance.phases import APEX, clip, kept
from walker.estimation import Contacts
from walker.footing import OTHER, Footing
from walker.gait import Reference
from walker.parameters.model import LevellingParameters

_SIDES: Final[tuple[Side, Side]] = ("L", "R")


class Level(NamedTuple):
    """What levelling adds to one foot."""

    lift: float = 0.0
    """Height, m."""
    roll: float = 0.0
    """Of the sole, rad, right-handed."""
    pitch: float = 0.0
    """Of the sole, rad, positive toe down."""


class Levelling:
    """Turns of both feet against the measured angle of the torso.

    Args:
        parameters: of the levelling.
    """

    def __init__(self, parameters: LevellingParameters) -> None:
        self._p = parameters
        self._turn: dict[Side, Vec2] = {"L": (0.0, 0.0), "R": (0.0, 0.0)}

    def update(
        self, angle: Vec2, reference: Reference, footing: Footing, contacts: Contacts, dt: float
    ) -> dict[Side, Level]:
        """One cycle.

        Args:
            angle: roll and pitch of the torso to level against, rad.
            reference: the plan.
            footing: roles of the legs.
            contacts: of the feet.
            dt: time since the last cycle, s.
        """
        feet = {"L": reference.left, "R": reference.right}
        levels: dict[Side, Level] = {}
        for side in _SIDES:
            roll, pitch = self._turn[side] = self._next(side, angle, footing, contacts.of(side), dt)
            foot, other = feet[side], feet[OTHER[side]]
            levels[side] = Level(roll * (foot.y - other.y) - pitch * (foot.x - other.x), roll, pitch)
        return levels

    def _next(self, side: Side, angle: Vec2, footing: Footing, contact: bool, dt: float) -> Vec2:
        p, (roll, pitch) = self._p, self._turn[side]
        if footing.role(side) == "stance":
            step = p.fade * dt
            return roll - clip(roll, -step, step), pitch - clip(pitch, -step, step)
        if contact and footing.progress > APEX:
            return roll, pitch  # it stands: from here on the torso's turn is no longer the foot's
        share, step = p.share * (1.0 - kept(footing.progress)), p.rate * dt
        wanted = (-share * clip(a, -p.largest, p.largest) for a in angle)
        return tuple(  # type: ignore[return-value]
            now + clip(goal - now, -step, step) for now, goal in zip((roll, pitch), wanted, strict=True)
        )
