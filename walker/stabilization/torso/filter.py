"""The torso controller at run time: one sample in, both ankles' corrections out (thesis 4.2).

The thesis lets the controller act on the stance ankle in single support and does not say what happens between.
Here:

- Single support: the controller drives the AnklePitch offset of the stance leg. Each leg has an integrator of
  its own, the slow part of its offset, so a leg that becomes the stance leg goes on from what it has; the
  proportional part comes in at the limited rate. Neither ankle jumps, and a contact that chatters between two
  phases does not count the proportional part twice.
- Swing leg: its offset and integrator, leftovers of its last stance, are bled off at a constant rate, so that
  the foot comes down as planned.
- Double support: both offsets are held, because both soles are on the ground and turning one ankle would only
  press the feet against each other.

The notch sees every sample in every phase, so it has settled when a single support begins.
"""

from __future__ import annotations

import math
from typing import Final

import msgspec

from bridge.errors import ConfigurationError
from walker.functions import clip
from walker.planning.plan import Support
from walker.stabilization.torso.controller import TorsoController
from walker.stabilization.torso.sign import ankle_pitch_from_lean

_LARGEST_ANGLE: Final = math.pi
"""rad; no torso is pitched further, so a wilder value cannot drive the filter's states anywhere."""


class TorsoLimits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the correction may do to an ankle."""

    offset: float = math.radians(15.0)
    """Largest correction, rad: three times the 5 degrees of slope that the walk is meant for, because a torso
    that has drifted on a slope needs both corrected at once."""
    rate: float = 1.0
    """Fastest change, rad/s. The motor of AnklePitch runs at several rad/s; the rest is the gait's."""
    bleed_rate: float = math.radians(15.0) / 0.4
    """Change of the swing leg's leftover towards zero, rad/s: the largest correction is gone within the
    shortest single support (0.44 s in the dynamic gait)."""

    def __post_init__(self) -> None:
        for name in ("offset", "rate", "bleed_rate"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ConfigurationError(f"torso limit {name} is {value}; it must be a positive number")
        if self.bleed_rate > self.rate:
            raise ConfigurationError(
                f"torso limit bleed_rate is {self.bleed_rate:g} rad/s; it may not exceed rate, which is "
                f"{self.rate:g} rad/s"
            )


class TorsoControl:
    """Torso pitch in, AnklePitch offsets of both legs out, once per DCM cycle.

    While neither limit acts, the offset of a leg that stays the stance leg is the controller's transfer
    function applied to the pitch error. When a limit acts, the integrator stands still unless it would come
    back from it (conditional integration), so there is no wind-up.
    """

    def __init__(self, controller: TorsoController, limits: TorsoLimits | None = None) -> None:
        self._controller = controller
        self._limits = limits or TorsoLimits()
        self._lean = {"L": 0.0, "R": 0.0}
        self._integral = {"L": 0.0, "R": 0.0}
        self._notched = 0.0
        self._notch_state = (0.0, 0.0)
        self._stance: Support = "both"

    def update(self, pitch_measured: float, support: Support) -> tuple[float, float]:
        """One cycle.

        Args:
            pitch_measured: AngleY, rad, positive nose down. If it is not finite, the sample counts as lost and
                the corrections stay as they are.
            support: the leg that bears the weight, `both` in double support.

        Returns:
            Offsets to add to LAnklePitch and RAnklePitch, rad, positive toe down.
        """
        if math.isfinite(pitch_measured):
            error = -clip(pitch_measured, -_LARGEST_ANGLE, _LARGEST_ANGLE)
            before, self._notched = self._notched, self._notch(error)
            if support != "both":
                self._drive(support, before)
                self._bleed("R" if support == "L" else "L")
            self._stance = support
        return ankle_pitch_from_lean(self._lean["L"]), ankle_pitch_from_lean(self._lean["R"])

    def _notch(self, error: float) -> float:
        """Second-order section, direct form II transposed."""
        n0, n1, n2 = self._controller.notch_numerator
        _, d1, d2 = self._controller.notch_denominator
        s1, s2 = self._notch_state
        output = n0 * error + s1
        self._notch_state = (n1 * error - d1 * output + s2, n2 * error - d2 * output)
        return output

    def _drive(self, leg: str, before: float) -> None:
        """PI controller on the stance leg, inside the limits."""
        half_gain = 0.5 * self._controller.sample_time * self._controller.integral_gain
        increment = half_gain * (self._notched + (before if leg == self._stance else 0.0))
        present = self._lean[leg]
        wanted = self._integral[leg] + increment + self._controller.proportional_gain * self._notched
        step = self._limits.rate * self._controller.sample_time
        allowed = clip(clip(wanted, present - step, present + step), -self._limits.offset, self._limits.offset)
        # Beyond a limit the integrator may only move back towards it.
        if allowed == wanted or (wanted - allowed) * increment < 0.0:
            self._integral[leg] += increment
        self._lean[leg] = allowed

    def _bleed(self, leg: str) -> None:
        step = self._limits.bleed_rate * self._controller.sample_time
        self._lean[leg] -= clip(self._lean[leg], -step, step)
        self._integral[leg] -= clip(self._integral[leg], -step, step)
