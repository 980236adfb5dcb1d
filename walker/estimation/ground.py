"""The tilt of the ground under the stance feet; not in the thesis.

A loaded sole is flat on the ground, so its tilt is the ground's. It follows from the torso's measured angle
and the leg's encoders, which include the deflection of the drives; the corrections of the last cycle separate
it from the feet's own turns. The plan is aligned to the slope and the torso stays upright over it. Torso
control and admittances correct the error of the slow mean.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import msgspec

from bridge.body import Body
from bridge.body.joints import LEG_SLOTS
from bridge.body.kinematics import foot_in_torso
from bridge.messages import SensorFrame
from bridge.rotations import rotation
from bridge.types import SIDES, NotNegative, Positive, Vec2
from walker.functions import clip


class Corrections(NamedTuple):
    """Offsets from the plan, left and right."""

    lift: Vec2 = (0.0, 0.0)
    """Height of the feet over the plan (leg admittance, swing-foot orientation control), m."""
    ankle_roll: Vec2 = (0.0, 0.0)
    """AnkleRoll (ankle admittance, swing-foot orientation control), rad."""
    ankle_pitch: Vec2 = (0.0, 0.0)
    """AnklePitch (ankle admittance, swing-foot orientation control), rad."""
    torso: Vec2 = (0.0, 0.0)
    """AnklePitch (torso control, its damping included), rad."""
    common: Vec2 = (0.0, 0.0)
    """Common turn of both ankles that now counts as the ground's, roll and pitch, rad."""
    ground_alignment_active: bool = False
    """The plan is more than half a degree off the estimated ground, and turns onto it."""

    @property
    def soles(self) -> tuple[Vec2, Vec2]:
        """Roll and pitch of the left and the right sole relative to the plan, rad."""
        return (self.ankle_roll[0], self.ankle_pitch[0]), (self.ankle_roll[1], self.ankle_pitch[1])


class GroundParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the estimate of the ground's tilt."""

    time_constant: Positive = 0.7
    """Time constant of the mean over the standing soles before the first step, s."""
    walking_time_constant: Positive = 6.0
    """Time constant of the mean in the walk, s: over two strides of the static gait, so that a foot that landed
    askew on an obstacle does not turn the plan under the other one."""
    min_force: Positive = 10.0
    """Force under a sole from which it counts as lying on the ground, N."""
    max_tilt: Positive = math.radians(10.0)
    """Steepest ground that is believed, rad."""
    common_rate: NotNegative = 0.05
    """Speed at which the common turn of both ankles becomes the ground's, rad/s."""
    max_rate: Positive = 0.15
    """Fastest turn of the plan onto the ground, rad/s."""
    tipping_time: Positive = 0.6
    """Longest time that a robot tips over its soles before a capture step, s. Meanwhile it leans as on tilted
    ground; after a push of 1.9 N s for 0.4 s."""


class GroundTilt:
    """Roll and pitch of the ground, once per received frame.

    Args:
        parameters: of the mean.
        body: data sheet.
        cycle: of the robot, s.
    """

    def __init__(self, parameters: GroundParameters, body: Body, cycle: float) -> None:
        self._p = parameters
        self._body = body
        self._tilt: Vec2 = (0.0, 0.0)
        self._past = deque([self._tilt], maxlen=1 + round(parameters.tipping_time / cycle))
        """Tilts of the last cycles without a capture step, the oldest first."""

    def update(
        self,
        frame: SensorFrame,
        angle: Vec2,
        corrections: Corrections,
        dt: float,
        *,
        walking: bool,
        capturing: bool = False,
    ) -> Vec2:
        """One cycle.

        Args:
            frame: newest sensor frame.
            angle: torso roll and pitch, rad.
            corrections: of the last cycle. The turn of one sole belongs to that foot alone, not to the
                ground; the common turn of both ankles becomes the ground's.
            dt: time since the last one, s.
            walking: the first step has begun.
            capturing: the robot makes a capture step, or rests after it on soles that are not flat: the last
                tilt before it began to tip holds.

        Returns:
            Roll and pitch: the ground's frame is R_pitch(pitch) R_roll(roll) in one with z up, rad. Uphill is a
            negative pitch, the left side higher a positive roll.
        """
        p = self._p
        if capturing:
            self._tilt = self._past[0]
            return self._tilt
        self._tilt = self._tilt[0] + corrections.common[0], self._tilt[1] + corrections.common[1]
        torso = rotation(angle[0], angle[1], 0.0)
        roll = pitch = load = 0.0
        for side, cells, off in zip(SIDES, (frame.fsr[:4], frame.fsr[4:]), corrections.soles, strict=True):
            force = sum(cells)
            if force > p.min_force:
                angles = [frame.position[slot] for slot in LEG_SLOTS[side]]
                x, y, z = torso @ foot_in_torso(self._body, side, angles)[:3, 2]
                roll += force * (-math.asin(y) - off[0])
                pitch += force * (math.atan2(x, z) - off[1])
                load += force
        if load:
            weight = 1.0 - math.exp(-dt / (p.walking_time_constant if walking else p.time_constant))
            self._tilt = (
                self._tilt[0] + weight * (clip(roll / load, -p.max_tilt, p.max_tilt) - self._tilt[0]),
                self._tilt[1] + weight * (clip(pitch / load, -p.max_tilt, p.max_tilt) - self._tilt[1]),
            )
        self._past.append(self._tilt)
        return self._tilt
