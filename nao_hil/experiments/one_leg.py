"""The stance of the torso step experiment: left leg stretched and standing, right leg drawn up."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.body.kinematics import CentreOfMass
from bridge.body.postures import POSTURES
from bridge.errors import ConfigurationError

DRAWN_UP: Final = {"RHipRoll": -0.3, "RHipPitch": -0.8, "RKneePitch": 1.6, "RAnklePitch": -0.8}
"""The right leg, rad: its sole is 6 cm over the ground, and the foot clear of the standing leg."""
TOLERANCE: Final = 1e-4
"""How near the centre of mass comes to the foot's middle, m."""


def _posture(lean: float, tilt: float) -> list[float]:
    """The posture with the standing leg leaning forward and outward by two angles, torso upright."""
    angles = list(POSTURES["StandInit"])
    legs = dict.fromkeys((name for name in INDEX if name[1:].startswith(("Hip", "Knee", "Ankle"))), 0.0)
    legs |= DRAWN_UP
    legs |= {"LAnklePitch": -lean, "LHipPitch": lean, "LAnkleRoll": tilt, "LHipRoll": -tilt}
    for name, angle in legs.items():
        angles[INDEX[name]] = angle
    return angles


def one_leg_stance(body: Body) -> tuple[float, ...]:
    """25 joint angles in frame order, rad: torso upright, centre of mass over the middle of the left foot.

    Raises:
        ConfigurationError: the body cannot stand so within its joint ranges.
    """
    com = CentreOfMass(body)
    middle = np.array(body.foot.centre)

    def miss(leans: NDArray[np.float64]) -> NDArray[np.float64]:
        angles = _posture(*leans.tolist())
        foot = com.tree.link_frames(angles)["LAnkleRoll"]
        in_foot = np.linalg.solve(foot, np.append(com(angles), 1.0))
        off: NDArray[np.float64] = in_foot[:2] - middle
        return off

    leans = least_squares(miss, (0.0, 0.2)).x
    angles = _posture(*leans.tolist())
    inside = all(
        sheet.lower <= angles[INDEX[n]] <= sheet.upper for n, sheet in body.joints.items() if n in INDEX
    )
    if not inside or float(np.linalg.norm(miss(leans))) > TOLERANCE:
        raise ConfigurationError(f"{body.name} cannot stand on its left leg with the right one drawn up.")
    return tuple(angles)
