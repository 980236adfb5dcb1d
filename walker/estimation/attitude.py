"""Torso roll and pitch that do not drift in a long walk; not in the thesis.

The vendor's fused angle follows the gyroscope while the body moves, so in a walk it runs away with the
gyroscope's bias and gain: 7 degrees in 30 s of the dynamic gait, and torso control leans the robot over by as
much. But over a step a walk gains no speed, so the accelerometer's mean is gravity, however hard the steps. The
fused angle is corrected by what that mean says, slowly enough to average over many steps.
"""

from __future__ import annotations

import math

import msgspec

from bridge.body.quantities import GRAVITY
from bridge.messages import SensorFrame
from bridge.types import NotNegative, Positive, Vec2


class AttitudeParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How fast the fused torso angle follows the mean of the accelerometer."""

    proportional: Positive = 0.3
    """1/s: the mean is over 3 s, three strides of the dynamic gait."""
    integral: NotNegative = 0.02
    """1/s^2: finds a constant drift within half a minute."""
    max_error: Positive = 0.5
    """Largest error that counts in one cycle, as a fraction of gravity."""


class Attitude:
    """Fused angle in, corrected angle out, once per received frame.

    The error is taken between components of the specific force, not between angles: under shocks along z the
    mean of the components is still gravity's, that of the angles is not.

    Args:
        parameters: how fast it corrects; None: not at all.
    """

    def __init__(self, parameters: AttitudeParameters | None) -> None:
        self._p = parameters
        self._offset = [0.0, 0.0]
        self._drift = [0.0, 0.0]

    def update(self, frame: SensorFrame, dt: float) -> Vec2:
        """One cycle.

        Args:
            frame: newest sensor frame.
            dt: time since the last one, s.

        Returns:
            Roll and pitch, rad.
        """
        p = self._p
        if p is None:
            return frame.angle
        x, y, _ = frame.accelerometer
        roll, pitch = (fused + offset for fused, offset in zip(frame.angle, self._offset, strict=True))
        errors = (
            y / GRAVITY - math.sin(roll) * math.cos(pitch),
            -x / GRAVITY - math.sin(pitch),
        )
        for i, error in enumerate(errors):
            limited = min(max(error, -p.max_error), p.max_error)
            self._drift[i] += p.integral * limited * dt
            self._offset[i] += (p.proportional * limited + self._drift[i]) * dt
        return roll, pitch
