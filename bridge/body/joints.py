"""Joint names and the one order they have in every frame.

The order is LoLA's (25 joints, one HipYawPitch), for every body; a body without a joint ignores its slot.
Source: LoLA joint order of the NAO V6; `RHipYawPitch` is absent because one motor drives both hips.
"""

from __future__ import annotations

import math
from typing import Final

JOINTS: Final = (
    "HeadYaw",
    "HeadPitch",
    "LShoulderPitch",
    "LShoulderRoll",
    "LElbowYaw",
    "LElbowRoll",
    "LWristYaw",
    "LHipYawPitch",
    "LHipRoll",
    "LHipPitch",
    "LKneePitch",
    "LAnklePitch",
    "LAnkleRoll",
    "RHipRoll",
    "RHipPitch",
    "RKneePitch",
    "RAnklePitch",
    "RAnkleRoll",
    "RShoulderPitch",
    "RShoulderRoll",
    "RElbowYaw",
    "RElbowRoll",
    "RWristYaw",
    "LHand",
    "RHand",
)
"""The 25 joints in frame order (confirmed: LoLA schema of the NAO V6)."""

N_JOINTS: Final = len(JOINTS)

INDEX: Final = {name: i for i, name in enumerate(JOINTS)}
"""Frame slot of each joint name."""

INDEX_WITH_MIRROR: Final = INDEX | {"RHipYawPitch": INDEX["LHipYawPitch"]}
"""As `INDEX`, and `RHipYawPitch` at the slot of the one motor that drives both hips."""

LEG_JOINTS: Final = {
    "L": ("LHipYawPitch", "LHipRoll", "LHipPitch", "LKneePitch", "LAnklePitch", "LAnkleRoll"),
    "R": ("RHipYawPitch", "RHipRoll", "RHipPitch", "RKneePitch", "RAnklePitch", "RAnkleRoll"),
}
"""The six joints of each leg from hip to foot, in chain order."""

UPPER_JOINTS: Final = tuple(name for name in JOINTS if name not in {*LEG_JOINTS["L"], *LEG_JOINTS["R"]})
"""Head, arms and hands, in frame order."""

LEG_SLOTS: Final = {side: tuple(INDEX_WITH_MIRROR[j] for j in names) for side, names in LEG_JOINTS.items()}
"""Frame slots of each leg's six joints; both legs share the HipYawPitch slot."""


def degrees_warning(joint: str, angle: float) -> str:
    """Why an angle is probably one in degrees; empty for one that some joint reaches.

    Args:
        joint: name.
        angle: rad.
    """
    if abs(angle) <= math.pi:
        return ""
    return f"{joint} is {angle:g} rad, which no joint reaches; angles are in radians."
