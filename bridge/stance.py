"""Detection of a standing robot by leg joints and fused angle, without the force sensors, which may fail."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import msgspec

from bridge.body import Body
from bridge.body.joints import LEG_SLOTS
from bridge.body.kinematics import foot_in_torso, hip_in_torso
from bridge.messages import SensorFrame
from bridge.rotations import rotation
from bridge.types import SIDES, Positive

_MIN_STIFFNESS: Final = 0.2
"""Least stiffness of each joint of a supporting leg."""


class StanceSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Bounds within which one foot supports the robot; without a supporting foot the guard makes it limp."""

    max_sole_tilt: Positive = 0.35
    """rad between the sole and the horizontal."""
    max_ankle_offset: Positive = 0.08
    """m that the ankle is ahead of or behind the hip; the postures Sit and SitRelax have more."""


STANCE: Final = StanceSettings()
"""The default."""


def legs_stiff(stiffness: Sequence[float]) -> bool:
    """Whether the legs hold the robot, by 25 stiffnesses in frame order."""
    return min(stiffness[slot] for slots in LEG_SLOTS.values() for slot in slots) >= _MIN_STIFFNESS


def stands(body: Body, frame: SensorFrame, settings: StanceSettings = STANCE) -> bool:
    """Whether at least one sole is about horizontal and about below its hip.

    Args:
        body: data sheet.
        frame: measured joints and fused angle.
        settings: bounds.
    """
    torso = rotation(*frame.angle, 0.0)
    for side in SIDES:
        foot = foot_in_torso(body, side, [frame.position[slot] for slot in LEG_SLOTS[side]])
        ahead = float(torso[0] @ (foot[:3, 3] - hip_in_torso(body, side)))
        tilt = math.acos(max(-1.0, min(1.0, float(torso[2] @ foot[:3, 2]))))
        if tilt <= settings.max_sole_tilt and abs(ahead) <= settings.max_ankle_offset:
            return True
    return False
