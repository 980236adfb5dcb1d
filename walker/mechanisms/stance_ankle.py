"""Offsets of the stance ankle against the torso's rate and lean; not in the thesis.

Reads: gyroscope, lean of the torso, the leg that bears the weight, progress of its step.
Gives: offsets of AnkleRoll and AnklePitch of both feet.

Damping: the torso on compliant joints rings: (4.12) has a damping ratio of 0.10. The thesis' controller takes
that resonance out of its loop with a notch, and so does the robust one: neither damps it. With a lean of -k
times the torso's rate, the plant (1 - s/z) / (s^2/w^2 + 2 d s/w + 1) gets k more in its linear term and loses
k/z in its quadratic one: on (4.12), k = 0.06 s gives a damping ratio of 0.39. A gyroscope needs no fusion. The
delay of drives and bus bounds k: at 40 ms a nominal robot walks with 0.04 to 0.08 s and falls with 0.15 s.

Lean feedback: a sole that lands on an edge is not level, and a position-controlled leg leans the torso by
as much. The ankle turns against that lean and so brings the torso upright over a sole that stays askew. A lean
that each stride repeats does not count (`StridePattern`): in walking to a side or in a turn the torso leans one
way on the left foot and the other way on the right one. That is no disturbance, and an ankle that turned
against it, late as it is, would amplify it. A lean that both feet have in common, as over an edge, is no part
of the pattern.

Both act about two axes on the ankle of the leg that alone bears the weight.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import msgspec
import numpy as np

from bridge.types import SIDES, Array, Fraction, NotNegative, Positive, Side, Vec2, Vec3
from walker.gaits.plan import OTHER_SIDE, Support
from walker.mechanisms.torso_control import ankle_pitch_from_lean

_PARTS: Final = 8
"""Parts of a step, each with a pattern of its own."""


class StridePattern:
    """Lean in, lean less the alternating pattern out, once per DCM cycle of single support.

    Args:
        gain: share of the lean that is added to the mean of its part of a step in a cycle, 0..1.
    """

    def __init__(self, gain: float) -> None:
        self._gain = gain
        self._means: dict[Side, Array] = {"L": np.zeros((_PARTS, 2)), "R": np.zeros((_PARTS, 2))}
        """Roll and pitch by the standing foot and the part of its step, rad."""

    def without(self, lean: Vec2, support: Side, progress: float) -> Vec2:
        """The lean less half the difference of both feet's means, rad.

        Args:
            lean: roll and pitch of the torso, rad.
            support: the stance foot.
            progress: fraction of its step that has passed, 0..1.
        """
        part = min(int(progress * _PARTS), _PARTS - 1)
        mean, other = self._means[support][part], self._means[OTHER_SIDE[support]][part]
        mean += self._gain * (lean - mean)
        roll, pitch = lean - 0.5 * (mean - other)
        return float(roll), float(pitch)


class DampingParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gains of the damping, and the bounds of all offsets of the stance ankle."""

    roll: NotNegative = 0.0
    """Offset against the torso's rate about x, s."""
    pitch: NotNegative = 0.0
    """The same about y, s."""
    max_offset: Positive = 0.1
    """Largest offset, rad."""
    max_rate: Positive = 5.0
    """Fastest change of an offset, rad/s, within the drives' speed. No leg jumps when the support changes."""


class LeanFeedbackParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gains of the lean feedback."""

    roll: Fraction = 0.0
    """Offset of AnkleRoll over the torso's roll."""
    pitch: Fraction = 0.0
    """Offset of AnklePitch over the torso's pitch."""
    pattern_gain: Fraction = 0.1
    """Share of the lean that is added to the pattern of a stride in a cycle."""


class AnkleOffsets(NamedTuple):
    """Offsets of both ankles, left and right."""

    roll: Vec2 = (0.0, 0.0)
    """Offsets of AnkleRoll, rad."""
    pitch: Vec2 = (0.0, 0.0)
    """Offsets of AnklePitch, rad, positive toe down."""


class StanceAnkle:
    """Torso rates and lean in, ankle offsets out, once per DCM cycle.

    Args:
        damping: gains on the rates, and the bounds.
        lean: gains on the lean.
        cycle: s.
        on_rate: the gains on the rates count.
        on_lean: the gains on the lean count.
    """

    def __init__(
        self,
        damping: DampingParameters,
        lean: LeanFeedbackParameters,
        cycle: float,
        *,
        on_rate: bool,
        on_lean: bool,
    ) -> None:
        self._rate_gains = (damping.roll, damping.pitch) if on_rate else (0.0, 0.0)
        self._lean_gains = (lean.roll, lean.pitch)
        self._pattern = StridePattern(lean.pattern_gain) if on_lean else None
        self._bound, self._step = damping.max_offset, damping.max_rate * cycle
        self._offsets = AnkleOffsets()

    def update(self, gyroscope: Vec3, lean: Vec2, support: Support, progress: float) -> AnkleOffsets:
        """One cycle.

        Args:
            gyroscope: angular velocity in the Torso frame, rad/s.
            lean: roll and pitch of the torso that are to vanish, rad.
            support: the leg that bears the weight; with `both` the offsets return to zero.
            progress: fraction of the step that has passed, 0..1.
        """
        if self._pattern is None or support == "both":
            lean = (0.0, 0.0)
        else:
            lean = self._pattern.without(lean, support, progress)
        roll, pitch = (
            rate_gain * rate + lean_gain * angle
            for rate_gain, rate, lean_gain, angle in zip(
                self._rate_gains, gyroscope[:2], self._lean_gains, lean, strict=True
            )
        )
        self._offsets = AnkleOffsets(
            self._axis(self._offsets.roll, roll, support), self._axis(self._offsets.pitch, pitch, support)
        )
        return self._offsets

    def _axis(self, offsets: Vec2, wanted: float, support: Support) -> Vec2:
        # AnkleRoll has AnklePitch's sign: positive turns the foot about +x against the shank, the body the
        # other way.
        goal = min(max(ankle_pitch_from_lean(-wanted), -self._bound), self._bound)
        left, right = (
            now + min(max((goal if side == support else 0.0) - now, -self._step), self._step)
            for side, now in zip(SIDES, offsets, strict=True)
        )
        return left, right
