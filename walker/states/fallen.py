"""Fallen, or falling: give way."""

from __future__ import annotations

import math
from typing import Final

from bridge.body.joints import INDEX
from bridge.messages import SensorFrame
from walker.estimation import Corrections, Estimate
from walker.estimation.fall import FallParameters
from walker.states.state import StateName, legs_hold

_SQUAT: Final = {"HipPitch": -0.9, "KneePitch": 1.8, "AnklePitch": -0.9}
"""Of both legs: the mass falls less far, and the soles stay level. AnkleRoll and HipYawPitch stay."""
_COUNTER: Final = {"HipRoll": 0.3, "HipPitch": 0.6}
"""By which the hips of both legs turn the way of the fall, rad: the torso turns back over the legs and
leans later. The ranges of HipPitch and HipRoll leave no more."""
_HEAD: Final = {"front": -0.65, "back": 0.5}
"""HeadPitch: the face away from the ground, or the chin on the chest (NaoTH turns it the same ways)."""
_ARMS: Final = {"ShoulderPitch": 0.3, "ElbowRoll": -0.8}
"""Of the left arm, mirrored for the right: stretched ahead and bent, so that elbow and forearm reach the ground
before the head."""


def brace(frame: SensorFrame) -> tuple[float, ...]:
    """The pose in which a robot is to meet the ground, 25 in frame order, rad.

    Args:
        frame: as the fall is noticed; the way of the torso says which side will be below.
    """
    position = list(frame.position)
    position[INDEX["HeadYaw"]] = 0.0
    roll, pitch = (angle + 0.2 * rate for angle, rate in zip(frame.angle, frame.gyroscope, strict=False))
    size = math.hypot(roll, pitch) or 1.0
    position[INDEX["HeadPitch"]] = _HEAD["front" if pitch > 0.0 else "back"]
    for side, sign in (("L", 1.0), ("R", -1.0)):
        for joint, angle in _SQUAT.items():
            position[INDEX[side + joint]] = angle
        position[INDEX[f"{side}HipRoll"]] += _COUNTER["HipRoll"] * roll / size
        position[INDEX[f"{side}HipPitch"]] += _COUNTER["HipPitch"] * pitch / size
        position[INDEX[f"{side}ShoulderPitch"]] = _ARMS["ShoulderPitch"]
        position[INDEX[f"{side}ElbowRoll"]] = sign * _ARMS["ElbowRoll"]
    return tuple(position)


class Fallen:
    """Lies limply, so that gears and limbs yield to the ground: each joint is asked to be where it is.

    Args:
        frame: as the fall was noticed.
        parameters: stiffness, and how long to brace.
        braces: first go into the pose of `brace`.
        gave_up: getting up failed; it is not tried again.
    """

    name: Final[StateName] = "fallen"
    corrections: Final = Corrections()

    def __init__(
        self, frame: SensorFrame, parameters: FallParameters, *, braces: bool = False, gave_up: bool = False
    ) -> None:
        self._p, self._braces = parameters, braces
        self.position = brace(frame) if braces else frame.position
        self.stiffness = parameters.brace_stiffness if braces else parameters.stiffness
        self.settled = 0.0
        self.gave_up = gave_up
        """Getting up failed."""
        self.went_limp = False
        """The legs were no stiffer than asked for."""

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """Go into the pose, then lie where the joints are; getting up is not begun here."""
        self.settled += dt
        self.went_limp = self.went_limp or not legs_hold(frame, self.stiffness)
        if not self._braces or self.settled >= self._p.brace_time:
            self._braces = False
            self.position, self.stiffness = frame.position, self._p.stiffness
