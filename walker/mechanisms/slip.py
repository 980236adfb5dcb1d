"""Slip of the stance foot, by inertial unit and force cells, and a slower walk; an outlook of the thesis.

Reads: joint angles, lean, gyroscope, accelerometer, force sensors, plan. Gives: `Feedback.pace` for the gait.

A stance sole that holds its place leaves the torso one motion: that of the stance leg's joints over it. The
inertial unit measures the torso's motion itself. While the cells say that the sole bears the weight, the
difference is the motion of the sole over the floor: the integral of the accelerometer less the velocity by the
joints. A sole that spins is no sign of a slippery floor: it does on any.

A slower walk has shorter steps, which ask the floor for less friction.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np

from bridge.body.kinematics import FloatingBase
from bridge.messages import SensorFrame
from bridge.rotations import heading, rotation
from bridge.types import Array, Fraction, NotNegative, Positive, Side, Vec2
from walker.gaits.plan import Plan


class SlipParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Thresholds of a slip, and the answer to it."""

    slide: Positive = 0.15
    """Speed of the sole over the floor that counts as a slip, m/s."""
    hold: NotNegative = 0.02
    """Time for which it must last, s."""
    leak: Positive = 0.1
    """Time over which the accelerometer is integrated, s: a lean that is off by 0.02 rad leaves 0.02 m/s."""
    pace: Fraction = 0.5
    """Share of the commanded velocity after a slip."""
    recovery: Positive = 3.0
    """Time in which the whole velocity returns, s."""


class SlipDetector:
    """Sensor frames in, slip out, once per received frame.

    Args:
        parameters: thresholds and answer.
        base: kinematics of the body.
    """

    def __init__(self, parameters: SlipParameters, base: FloatingBase) -> None:
        self._p, self._base = parameters, base
        unit = base.body.inertial_unit
        self._sees_turn, self._unit = unit.gyroscope_axes == 3, np.array(unit.accelerometer)
        self._stance: Side | None = None
        self._velocity: Array | None = None
        """Of the torso over the sole by the joints, m/s; None: no cycle to compare with."""
        self._torso: Array = np.zeros(2)
        self._heading = 0.0
        self._lasts = 0.0
        self.slide: Array = np.zeros(2)
        """Velocity of the stance sole over the floor, forward and to the left of the torso, m/s."""
        self.pace = 1.0
        """Share of the commanded velocity."""

    def update(self, frame: SensorFrame, lean: Vec2, plan: Plan, dt: float) -> bool:
        """One cycle: whether the stance foot slips.

        Args:
            frame: newest sensor frame.
            lean: roll and pitch of the torso, rad.
            plan: in force.
            dt: time since the last cycle, s.
        """
        p = self._p
        self.pace = min(self.pace + (1.0 - p.pace) * dt / p.recovery, 1.0)
        self._measure(frame, lean, plan, dt)
        self._lasts = self._lasts + dt if math.hypot(*self.slide) > p.slide else 0.0
        slips = self._lasts > p.hold
        if slips:
            self.pace = p.pace
        return slips

    def _measure(self, frame: SensorFrame, lean: Vec2, plan: Plan, dt: float) -> None:
        """`slide`; zero unless one foot is planned to bear the weight and bears the most."""
        left, right = sum(frame.fsr[:4]), sum(frame.fsr[4:])
        side: Side = "L" if left > right else "R"
        if plan.support != side or dt <= 0.0:
            self._stance, self.slide = None, np.zeros(2)
            return
        tilt = rotation(*lean, 0.0)
        foot = self._base.foot(self._base.in_torso(frame.position), side)
        turned = heading(tilt @ foot[:3, :3])
        torso = (tilt @ (self._unit - (foot @ self._base.centres[side])[:3]))[:2]
        if self._stance != side:
            self._stance, self._velocity, self.slide = side, None, np.zeros(2)
        else:
            rate = math.remainder(self._heading - turned, math.tau) / dt
            if self._sees_turn:
                rate = float((tilt @ frame.gyroscope)[2])
            x, y = torso
            velocity = (torso - self._torso) / dt + rate * np.array([-y, x])
            if self._velocity is not None:
                gained = (tilt @ frame.accelerometer)[:2] * dt - (velocity - self._velocity)
                self.slide = math.exp(-dt / self._p.leak) * self.slide + gained
            self._velocity = velocity
        self._torso, self._heading = torso, turned
