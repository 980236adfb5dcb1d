"""Does the robot stand? By leg joints and fused angle alone: a broken force sensor makes nobody fall."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.datasheet import Body
from bridge.guard.config import StanceSettings
from bridge.joints import LEG_SLOTS
from bridge.messages import SensorFrame

Matrix = NDArray[np.float64]
_HALF: Final = math.sqrt(0.5)


def stands(body: Body, frame: SensorFrame, settings: StanceSettings) -> bool:
    """Whether at least one sole is about level and about below its hip.

    Args:
        body: data sheet; lengths of thigh and shank.
        frame: measured joints and fused angle.
        settings: how level, how far from below.
    """
    roll, pitch = frame.angle
    torso = _about((1.0, 0.0, 0.0), roll) @ _about((0.0, 1.0, 0.0), pitch)
    for side, slots in LEG_SLOTS.items():
        yaw_pitch, hip_roll, hip, knee, ankle, ankle_roll = (frame.position[slot] for slot in slots)
        # docs/protocol.md: HipYawPitch turns the left hip about (0, 1, -1), the right one about (0, 1, 1).
        axis = (0.0, _HALF, -_HALF if side == "L" else _HALF)
        thigh = (
            torso @ _about(axis, yaw_pitch) @ _about((1.0, 0.0, 0.0), hip_roll) @ _about((0.0, 1.0, 0.0), hip)
        )
        shank = thigh @ _about((0.0, 1.0, 0.0), knee)
        sole = shank @ _about((0.0, 1.0, 0.0), ankle) @ _about((1.0, 0.0, 0.0), ankle_roll)
        ahead = -(body.lengths.ThighLength * thigh[0, 2] + body.lengths.TibiaLength * shank[0, 2])
        tilt = math.acos(max(-1.0, min(1.0, float(sole[2, 2]))))
        if tilt <= settings.sole_tilt and abs(ahead) <= settings.reach:
            return True
    return False


def _about(axis: tuple[float, float, float], angle: float) -> Matrix:
    """Rotation by `angle` rad about a unit axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: Matrix = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return turn
