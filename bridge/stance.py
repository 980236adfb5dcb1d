"""Whether the robot stands, by leg joints and fused angle alone: a broken force sensor must not decide."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import msgspec

from bridge.body import Body
from bridge.body.joints import LEG_SLOTS
from bridge.messages import SensorFrame
from bridge.rotations import R_pitch, R_roll, about_axis, rotation
from bridge.types import Positive

_HALF: Final = math.sqrt(0.5)
_STIFF: Final = 0.2
"""A robot stands by a leg only if each of its joints has at least this stiffness."""


class StanceSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When a robot counts as standing, and crouches; otherwise it goes limp where it is. One foot is enough."""

    max_sole_tilt: Positive = 0.35
    """rad between the sole and the horizontal."""
    max_ankle_offset: Positive = 0.08
    """m that the ankle is ahead of or behind the hip; the postures Sit and SitRelax have more."""


STANCE: Final = StanceSettings()
"""Where nobody says otherwise."""


def legs_stiff(stiffness: Sequence[float]) -> bool:
    """Whether the legs hold the robot, by 25 stiffnesses in frame order."""
    return min(stiffness[slot] for slots in LEG_SLOTS.values() for slot in slots) >= _STIFF


def stands(body: Body, frame: SensorFrame, settings: StanceSettings = STANCE) -> bool:
    """Whether at least one sole is about horizontal and about below its hip.

    Args:
        body: data sheet; lengths of thigh and shank.
        frame: measured joints and fused angle.
        settings: bounds.
    """
    torso = rotation(*frame.angle, 0.0)
    for side, slots in LEG_SLOTS.items():
        yaw_pitch, hip_roll, hip, knee, ankle, ankle_roll = (frame.position[slot] for slot in slots)
        # docs/protocol.md: HipYawPitch turns the left hip about (0, 1, -1), the right one about (0, 1, 1).
        axis = (0.0, _HALF, -_HALF if side == "L" else _HALF)
        thigh = torso @ about_axis(axis, yaw_pitch) @ R_roll(hip_roll) @ R_pitch(hip)
        shank = thigh @ R_pitch(knee)
        sole = shank @ R_pitch(ankle) @ R_roll(ankle_roll)
        ahead = -(body.lengths.ThighLength * thigh[0, 2] + body.lengths.TibiaLength * shank[0, 2])
        tilt = math.acos(max(-1.0, min(1.0, float(sole[2, 2]))))
        if tilt <= settings.max_sole_tilt and abs(ahead) <= settings.max_ankle_offset:
            return True
    return False
