"""Roll and pitch of the torso: an angle without drift, and one without lag; neither is in the thesis.

`Attitude` does not drift in a long walk. The vendor's fused angle follows the gyroscope while the body moves,
so in a walk it runs away with the gyroscope's bias and gain: 7 degrees in 30 s of the dynamic gait, and torso
control leans the robot over by as much. But over a step a walk gains no speed, so the accelerometer's mean is
gravity, however hard the steps. That mean corrects the fused angle, slowly enough to average over many steps.

`Lean` has no lag. The fused angle follows a disturbance late, and at first the other way. Here the gyroscope is
integrated and drawn slowly to the fused angle, whose mean is right. A body that turns takes its lean along: the
rates of roll and pitch then hold the turn too, and since some bodies have no gyroscope about z, the turn is the
planned one.
"""

from __future__ import annotations

import math

import msgspec

from bridge.body.quantities import GRAVITY
from bridge.messages import SensorFrame
from bridge.types import NotNegative, Positive, Vec2, Vec3


class AttitudeParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gains with which the fused torso angle follows the mean of the accelerometer."""

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


class LeanParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the gyroscope's integration."""

    time_constant: Positive = 1.0
    """Time constant of the integral towards the fused angle, s: a gyroscope's bias b leaves b times this."""
    mean_time_constant: Positive = 2.0
    """Time constant of the mean that is taken for the ground's, s."""


class Lean:
    """Integrates the gyroscope, once per received frame.

    Args:
        parameters: of the integral.
        latency: over which the lean is predicted, s.
    """

    def __init__(self, parameters: LeanParameters, latency: float) -> None:
        self._p, self._latency = parameters, latency
        self.angle: Vec2 | None = None
        """Roll and pitch now, rad; None before the first frame."""
        self.lean_without_mean: Vec2 = (0.0, 0.0)
        """The same less its mean, when the command of this cycle is carried out, rad."""
        self._mean: Vec2 | None = None

    def update(self, gyroscope: Vec3, fused: Vec2, turn: float, dt: float) -> Vec2:
        """One cycle.

        Args:
            gyroscope: angular velocity in the Torso frame, rad/s.
            fused: roll and pitch that are right in the mean, rad.
            turn: planned rate of the heading, rad/s.
            dt: time since the last cycle, s.
        """
        roll, pitch = self.angle or fused
        x, y, _ = gyroscope
        # Kinematics of R_yaw R_pitch R_roll:
        # x = roll' - yaw' sin(pitch), y = pitch' cos(roll) + yaw' cos(pitch) sin(roll)
        d_roll = x + turn * math.sin(pitch)
        d_pitch = (y - turn * math.cos(pitch) * math.sin(roll)) / math.cos(roll)
        weight = min(dt / self._p.time_constant, 1.0)
        roll += dt * d_roll + weight * (fused[0] - roll)
        pitch += dt * d_pitch + weight * (fused[1] - pitch)
        self.angle = roll, pitch
        mean_roll, mean_pitch = self._mean or self.angle
        share = min(dt / self._p.mean_time_constant, 1.0)
        self._mean = mean_roll + share * (roll - mean_roll), mean_pitch + share * (pitch - mean_pitch)
        self.lean_without_mean = (
            roll + self._latency * d_roll - self._mean[0],
            pitch + self._latency * d_pitch - self._mean[1],
        )
        return self.angle
