"""Roll and pitch of the torso without the lag of the fused angle.

The fused angle follows a disturbance late, and at first the other way. Here the gyroscope is integrated and
drawn slowly to the fused angle, whose mean is right. A body that turns takes its lean along: the rates of roll
and pitch then hold the turn too, and since some bodies have no gyroscope about z, the turn is the planned one.
"""

from __future__ import annotations

import math

import msgspec

from bridge.types import NotNegative, Positive, Vec2, Vec3


class LeanParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the gyroscope is integrated."""

    time_constant: Positive = 1.0
    """With which the integral follows the fused angle, s: a bias b of the gyroscope leaves b times this."""
    mean_time_constant: Positive = 2.0
    """Of the mean that is taken for the ground's, s."""
    latency: NotNegative = 0.04
    """From a command to the motion that the sensors report, s."""


class Lean:
    """Integrates the gyroscope, once per received frame.

    Args:
        parameters: of the integral.
    """

    def __init__(self, parameters: LeanParameters) -> None:
        self._p = parameters
        self.angle: Vec2 | None = None
        """Roll and pitch now, rad; None before the first frame."""
        self.swing: Vec2 = (0.0, 0.0)
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
        self.swing = (
            roll + self._p.latency * d_roll - self._mean[0],
            pitch + self._p.latency * d_pitch - self._mean[1],
        )
        return self.angle
