"""What the stabilizer added to a plan in one cycle.

The estimator takes the corrections of the last cycle to tell the ground's tilt from the feet's own turns.
"""

from __future__ import annotations

from typing import NamedTuple

from bridge.types import Vec2


class Corrections(NamedTuple):
    """Offsets from the plan, left and right."""

    lift: Vec2 = (0.0, 0.0)
    """Height of the feet over the plan (leg admittance, swing-foot orientation control), m."""
    ankle_roll: Vec2 = (0.0, 0.0)
    """AnkleRoll (ankle admittance, swing-foot orientation control), rad."""
    ankle_pitch: Vec2 = (0.0, 0.0)
    """AnklePitch (ankle admittance, swing-foot orientation control), rad."""
    torso: Vec2 = (0.0, 0.0)
    """AnklePitch (torso control, its damping included), rad."""
    common: Vec2 = (0.0, 0.0)
    """Turn that both ankles had in common; it counts as the ground's from now on, roll and pitch, rad."""
    righting: bool = False
    """The plan is more than half a degree off the ground as it was found, and is being turned onto it."""

    @property
    def soles(self) -> tuple[Vec2, Vec2]:
        """Roll and pitch by which the left and the right sole were turned against the plan, rad."""
        return (self.ankle_roll[0], self.ankle_pitch[0]), (self.ankle_roll[1], self.ankle_pitch[1])
