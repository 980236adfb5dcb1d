"""Whether a body can walk a gait at all: found out before the first joint moves."""

from __future__ import annotations

import math

from bridge.datasheet import Body
from bridge.datasheet.model import Side
from bridge.errors import ConfigurationError
from bridge.joints import LEG_SLOTS
from walker.errors import UnreachableError
from walker.gait import Gait, Reference
from walker.kinematics.limits import limit_violations
from walker.pose import PoseMaker

_STEPS = 4
"""Start, two regular steps and the closing one hold every pose of a gait."""
_DT = 0.02
CLIPPED = math.radians(0.5)
"""Excess over a range that is clipped in silence: half the play of a good robot's ankle."""
_SIDES: tuple[Side, Side] = ("L", "R")


def check_walkable(body: Body, gait: Gait) -> None:
    """Walk a gait dry, through the inverse kinematics.

    Args:
        body: data sheet.
        gait: in its initial stand; is used up.

    Raises:
        ConfigurationError: a pose that the legs cannot reach or the joint limits forbid; names the phase, the
            leg or joint, and by how much.
    """
    reference = gait.stand()
    try:
        pose = PoseMaker(body, reference, by_pose=gait.quasi_static)
        while reference.phase != "stand" or reference.step == 0:
            reference = gait.advance(_DT, go_on=reference.step < _STEPS - 1)
            _check_limits(body, pose.unlimited_angles(reference), reference, _where(gait, reference))
    except UnreachableError as error:
        raise ConfigurationError(
            f"{_where(gait, reference)}: {error}; shorten the step, narrow the feet or lower the gait height."
        ) from None


def _where(gait: Gait, reference: Reference) -> str:
    return f"gait {gait.name}, phase {reference.phase} of step {reference.step + 1}"


def _check_limits(body: Body, angles: tuple[float, ...], reference: Reference, where: str) -> None:
    for side in _SIDES:
        for joint, excess in limit_violations(body, side, [angles[slot] for slot in LEG_SLOTS[side]]):
            hangs = joint == f"{side}AnkleRoll" and _clears_ground(body, side, reference, excess)
            if hangs or abs(excess) < CLIPPED:
                continue
            bound = "above" if excess > 0.0 else "below"
            raise ConfigurationError(
                f"{where}: {joint} would stand {math.degrees(abs(excess)):.1f} deg {bound} its range on a "
                f"{body.name}; change the step, the feet's distance or the gait height."
            )


def _clears_ground(body: Body, side: Side, reference: Reference, tilt: float) -> bool:
    """Whether a swing foot that its AnkleRoll cannot keep level stays off the ground all the same.

    AnkleRoll's range narrows as AnklePitch bends: with the 35 mm of lift of figure 3.4 a level foot is out of
    it at mid-swing, and hangs tilted instead.
    """
    if reference.support in (side, "both"):
        return False
    foot = reference.left if side == "L" else reference.right
    widest = max(abs(y) for _, y in body.foot.sole)
    return foot.z > widest * math.sin(abs(tilt))
