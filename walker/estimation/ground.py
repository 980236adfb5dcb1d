"""The tilt of the ground under the feet that stand; not in the thesis.

A sole that bears weight lies on the ground, so its tilt is the ground's. It is known: the torso's measured
angle, and the leg between torso and sole by its encoders, which see the sag of the drives as well. With it
the plan is laid onto the slope and the torso stays upright over it; what is left to torso control and
admittances is what a slow mean over the standing feet does not know.
"""

from __future__ import annotations

import math
from typing import Annotated, Final

import msgspec

from bridge.datasheet import Body
from bridge.datasheet.model import Side
from bridge.joints import LEG_SLOTS
from bridge.messages import SensorFrame, Vec2
from walker.kinematics.leg import foot_in_torso
from walker.kinematics.transforms import rotation

_SIDES: Final[tuple[Side, Side]] = ("L", "R")
_Positive = Annotated[float, msgspec.Meta(gt=0.0)]
_NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]


class GroundParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the ground's tilt is found; part of the admittance."""

    time_constant: _NotNegative = 0.7
    """Of the mean over the standing soles before the first step, s; 0: the ground is taken to be level."""
    walking: _Positive = 6.0
    """Of the mean in the walk, s: over two strides of the static gait, so that a foot that landed askew on an
    obstacle does not turn the plan under the other one."""
    least: _Positive = 10.0
    """Force under a sole from which it counts as lying on the ground, N."""
    largest: _Positive = math.radians(10.0)
    """Steepest ground that is believed, rad."""
    shared_rate: _NotNegative = 0.05
    """Speed at which what both ankles hold in common becomes the ground's, rad/s."""
    rate: _Positive = 0.15
    """Fastest turn of the plan onto the ground, rad/s."""


class GroundTilt:
    """Roll and pitch of the ground, once per received frame.

    Args:
        parameters: of the mean.
        body: data sheet.
    """

    def __init__(self, parameters: GroundParameters, body: Body) -> None:
        self._p = parameters
        self._body = body
        self._tilt: Vec2 = (0.0, 0.0)

    def take(self, turn: Vec2) -> None:
        """Count as the ground's what both soles were turned by in common, roll and pitch, rad."""
        self._tilt = self._tilt[0] + turn[0], self._tilt[1] + turn[1]

    def update(
        self, frame: SensorFrame, angle: Vec2, turned: tuple[Vec2, Vec2], dt: float, *, walking: bool
    ) -> Vec2:
        """One cycle.

        Args:
            frame: newest sensor frame.
            angle: torso roll and pitch, rad.
            turned: roll and pitch by which the controllers turned the left and right sole, rad: what an ankle
                yielded to lies under that foot alone and is not the ground's.
            dt: time since the last one, s.
            walking: the first step has begun.

        Returns:
            Roll and pitch: the ground's frame is R_pitch(pitch) R_roll(roll) in one with z up, rad. Uphill is a
            negative pitch, the left side higher a positive roll.
        """
        p = self._p
        if not p.time_constant:
            return self._tilt
        torso = rotation(angle[0], angle[1], 0.0)
        roll = pitch = load = 0.0
        for side, cells, off in zip(_SIDES, (frame.fsr[:4], frame.fsr[4:]), turned, strict=True):
            force = sum(cells)
            if force > p.least:
                angles = [frame.position[slot] for slot in LEG_SLOTS[side]]
                x, y, z = torso @ foot_in_torso(self._body, side, angles)[:3, 2]
                roll += force * (-math.asin(y) - off[0])
                pitch += force * (math.atan2(x, z) - off[1])
                load += force
        if load:
            share = 1.0 - math.exp(-dt / (p.walking if walking else p.time_constant))
            self._tilt = (
                self._tilt[0] + share * (_clip(roll / load, p.largest) - self._tilt[0]),
                self._tilt[1] + share * (_clip(pitch / load, p.largest) - self._tilt[1]),
            )
        return self._tilt


def _clip(value: float, bound: float) -> float:
    return min(max(value, -bound), bound)
