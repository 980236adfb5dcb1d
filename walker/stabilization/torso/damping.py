"""Damping of the torso's ringing by the gyroscope; not in the thesis.

The torso on compliant joints rings: (4.12) has a damping ratio of 0.10. The thesis' controller takes that
resonance out of its loop with a notch, and so does the robust one: neither damps it. With a lean of -k times
the torso's rate, the plant (1 - s/z) / (s^2/w^2 + 2 d s/w + 1) gets k more in its linear term and loses k/z in
its quadratic one: on (4.12), k = 0.06 s gives a damping ratio of 0.39. A gyroscope needs no fusion. The delay
of drives and bus bounds k: at 40 ms a nominal robot walks with 0.04 to 0.08 s and falls with 0.15 s.

It acts about both axes on the ankle of the leg that alone bears the weight.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import msgspec

from bridge.types import NotNegative, Positive, Side, Vec2, Vec3
from walker.planning.plan import Support
from walker.stabilization.torso.sign import ankle_pitch_from_lean

_SIDES: Final[tuple[Side, Side]] = ("L", "R")


class DampingParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gains and limits of the damping."""

    roll: NotNegative = 0.0
    """Lean of the ankle against the torso's rate about x, s."""
    pitch: NotNegative = 0.0
    """The same about y, s."""
    max_offset: Positive = 0.1
    """Largest offset, rad."""
    max_rate: Positive = 5.0
    """Fastest change of an offset, rad/s: what the drives follow. No leg jumps when the support changes."""


class Damping(NamedTuple):
    """Offsets of both ankles, left and right."""

    roll: Vec2 = (0.0, 0.0)
    """Of AnkleRoll, rad."""
    pitch: Vec2 = (0.0, 0.0)
    """Of AnklePitch, rad, positive toe down."""


class GyroDamping:
    """Torso rates in, ankle offsets out, once per DCM cycle.

    Args:
        parameters: gains and limits.
        cycle: s.
    """

    def __init__(self, parameters: DampingParameters, cycle: float) -> None:
        self._p = parameters
        self._step = parameters.max_rate * cycle
        self._offsets = Damping()

    def update(self, gyroscope: Vec3, support: Support) -> Damping:
        """One cycle.

        Args:
            gyroscope: angular velocity in the Torso frame, rad/s.
            support: the leg that bears the weight; with `both` the offsets return to zero.
        """
        self._offsets = Damping(
            self._axis(self._offsets.roll, self._p.roll * gyroscope[0], support),
            self._axis(self._offsets.pitch, self._p.pitch * gyroscope[1], support),
        )
        return self._offsets

    def _axis(self, offsets: Vec2, rate_times_gain: float, support: Support) -> Vec2:
        # AnkleRoll has AnklePitch's sign: positive turns the foot about +x against the shank, the body the
        # other way.
        against = ankle_pitch_from_lean(-rate_times_gain)
        goal = min(max(against, -self._p.max_offset), self._p.max_offset)
        left, right = (
            now + min(max((goal if side == support else 0.0) - now, -self._step), self._step)
            for side, now in zip(_SIDES, offsets, strict=True)
        )
        return left, right
