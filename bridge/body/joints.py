"""Joint names, their one order in every frame, and the tree of joints that every NAO shares.

The order is LoLA's (25 joints, one HipYawPitch), for every body; a body without a joint ignores its slot.
Source: LoLA joint order of the NAO V6; `RHipYawPitch` is absent because one motor drives both hips.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from bridge.body.model import Body, Lengths
from bridge.types import Vec3

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

LEGS: Final = tuple(sorted({*LEG_SLOTS["L"], *LEG_SLOTS["R"]}))
"""Frame slots of the eleven leg motors."""


def degrees_warning(joint: str, angle: float) -> str:
    """Why an angle is probably one in degrees; empty for one that some joint reaches.

    Args:
        joint: name.
        angle: rad.
    """
    if abs(angle) <= math.pi:
        return ""
    return f"{joint} is {angle:g} rad, which no joint reaches; is it in degrees? Radians are right."


TORSO: Final = "Torso"
_H: Final = math.sqrt(0.5)


class JointTree(NamedTuple):
    """Where one joint sits in the tree."""

    parent: str
    """Name of the parent joint, or `Torso`."""
    axis: Vec3
    """Unit axis of positive rotation, zero-pose aligned frame."""
    offset: Vec3
    """Joint origin from the parent joint's origin, parent's zero-pose aligned frame, m."""


def _arm(side: str, sign: float, length: Lengths) -> dict[str, JointTree]:
    shoulder = (0.0, sign * length.ShoulderOffsetY, length.ShoulderOffsetZ)
    elbow = (length.UpperArmLength, sign * length.ElbowOffsetY, 0.0)
    wrist = (length.LowerArmLength, 0.0, 0.0)
    return {
        f"{side}ShoulderPitch": JointTree(TORSO, (0.0, 1.0, 0.0), shoulder),
        f"{side}ShoulderRoll": JointTree(f"{side}ShoulderPitch", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
        f"{side}ElbowYaw": JointTree(f"{side}ShoulderRoll", (1.0, 0.0, 0.0), elbow),
        f"{side}ElbowRoll": JointTree(f"{side}ElbowYaw", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
        f"{side}WristYaw": JointTree(f"{side}ElbowRoll", (1.0, 0.0, 0.0), wrist),
    }


def _leg(side: str, sign: float, length: Lengths) -> dict[str, JointTree]:
    here = (0.0, 0.0, 0.0)
    return {
        f"{side}HipYawPitch": JointTree(
            TORSO, (0.0, _H, -sign * _H), (0.0, sign * length.HipOffsetY, -length.HipOffsetZ)
        ),
        f"{side}HipRoll": JointTree(f"{side}HipYawPitch", (1.0, 0.0, 0.0), here),
        f"{side}HipPitch": JointTree(f"{side}HipRoll", (0.0, 1.0, 0.0), here),
        f"{side}KneePitch": JointTree(f"{side}HipPitch", (0.0, 1.0, 0.0), (0.0, 0.0, -length.ThighLength)),
        f"{side}AnklePitch": JointTree(f"{side}KneePitch", (0.0, 1.0, 0.0), (0.0, 0.0, -length.TibiaLength)),
        f"{side}AnkleRoll": JointTree(f"{side}AnklePitch", (1.0, 0.0, 0.0), here),
    }


def joint_tree(body: Body) -> dict[str, JointTree]:
    """The mechanical joints of a body, parents before children.

    Hands have no joint of their own here: they are part of the link they sit on.
    """
    length = body.lengths
    tree = {
        "HeadYaw": JointTree(TORSO, (0.0, 0.0, 1.0), (0.0, 0.0, length.NeckOffsetZ)),
        "HeadPitch": JointTree("HeadYaw", (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)),
        **_arm("L", 1.0, length),
        **_leg("L", 1.0, length),
        **_leg("R", -1.0, length),
        **_arm("R", -1.0, length),
    }
    if body.model == "H21":
        del tree["LWristYaw"], tree["RWristYaw"]
    return tree
