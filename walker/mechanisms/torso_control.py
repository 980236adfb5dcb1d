"""Torso control: keep the torso upright with the AnklePitch of the stance leg (thesis 4.2).

Reads: pitch of the torso, the leg that alone touches the ground.
Gives: offsets of both AnklePitches.

Designed controllers are data, each with its plant and specification. `nao-hil
design torso` computes them; `torso.toml` in the folder of a gait holds them.

The thesis lets the controller act on the stance ankle in single support while the swing foot does not touch the
ground, and leaves the rest open. Here:

- Single support, the swing foot in the air: the controller drives the AnklePitch offset of the stance leg. Each
  leg has an integrator of its own, the slow part of its offset, so a leg that becomes the stance leg continues
  from its own; the proportional part is added at the limited rate. Neither ankle jumps, and a contact that
  chatters between two phases does not count the proportional part twice.
- Swing leg: its offset and integrator, leftovers of its last stance, are bled off at a constant rate, so that
  the foot lands as planned.
- Both feet on the ground, by the plan or by the force sensors: both offsets are held, because turning one ankle
  would only press the feet against each other.

The notch sees every sample in every phase, so it has settled when a single support begins.

Sign between the thesis' plant and NAO's axes: AnklePitch turns the foot against the shank about +y (x forward,
y left, z up): positive is toe down. With the sole flat on the ground the foot cannot turn, so the body does,
the other way: of the chain R_torso R_y(HipPitch) R_y(KneePitch) R_y(AnklePitch) = 1 follows AngleY = -(HipPitch
+ KneePitch + AnklePitch). A positive AnklePitch tips the body backwards, and AngleY, positive nose down, falls:
the plant from AnklePitch to AngleY has a steady-state gain of -1. The thesis' plant (4.12) has +1. Its input is
therefore the ankle angle counted positive when it tips the body forwards, called the *lean* here. All designs
are made on plants in this sign, so they have positive gains, and their output is a lean.
"""

from __future__ import annotations

import math
from typing import Final, Literal

import msgspec

from bridge.errors import ConfigurationError
from walker.functions import clip
from walker.gaits.plan import Support

ANKLE_PITCH_PER_LEAN: Final = -1.0
"""AnklePitch (rad, NAO's axis) that makes 1 rad of lean (positive: the body tips forwards)."""


def ankle_pitch_from_lean(lean: float) -> float:
    """AnklePitch offset, rad, positive toe down, for a lean, rad, positive forwards."""
    return ANKLE_PITCH_PER_LEAN * lean


class TorsoController(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A second-order section (notch) followed by a PI controller, sampled.

    G_R(z) = G_N(z) V_i (T_i + (T/2) (z + 1)/(z - 1)): the PI controller (4.15) under Tustin's map. The parts
    are kept apart because the expanded third-order polynomials ((4.19), (4.22)) have their roots close together
    at z = 1, where rounded coefficients move them a lot; apart, the integrator's pole is exactly 1.
    """

    sample_time: float
    """T, s"""
    integral_gain: float
    """V_i, 1/s"""
    reset_time: float
    """T_i, s"""
    notch_numerator: tuple[float, float, float]
    """In z, highest power first."""
    notch_denominator: tuple[float, float, float]
    """In z, highest power first, the first is 1."""

    @property
    def proportional_gain(self) -> float:
        """V_i T_i."""
        return self.integral_gain * self.reset_time


class TorsoPlant(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """G_s(s) from the ankle angle to the torso pitch, in the thesis' sign (see `torso.sign`)."""

    numerator: tuple[float, ...] = (-0.125, 1.0)
    """Highest power first; the default is (4.12)."""
    denominator: tuple[float, ...] = (0.02041, 0.02857, 1.0)


class ThesisSpecification(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Specification of the closed loop by the rules of thumb of the frequency-response method (4.2.2)."""

    rise_time: float = 0.563
    """t_r, s; the default is the thesis' value for the static gait."""
    overshoot: float = 0.10
    """Fraction of the final value."""
    notch_factor: float = 6.0
    """a_Notch (4.16): the wider, the less the resonance must be known."""

    def __post_init__(self) -> None:
        if not self.rise_time > 0.0:
            raise ConfigurationError(f"the rise time is {self.rise_time} s; it must be positive")
        if not 0.0 <= self.overshoot < 0.7:
            raise ConfigurationError(
                f"the overshoot is {self.overshoot:g}; it is a fraction of the final value, 0 to 0.7"
            )
        if not self.notch_factor >= 1.0:
            raise ConfigurationError(f"the notch factor is {self.notch_factor:g}; it must be 1 or more")

    @property
    def crossover(self) -> float:
        """Omega_C = 1.2 / t_r, rad/s."""
        return 1.2 / self.rise_time

    @property
    def phase_margin_deg(self) -> float:
        """Phi = 70 degrees less the overshoot in percent."""
        return 70.0 - 100.0 * self.overshoot


class RobustSpecification(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Bounds that hold at the identified plant and at every corner of its uncertainty."""

    overshoot: float = 0.10
    """Maximum overshoot, and maximum undershoot, of a step response, fraction of the final value."""
    gain_margin: float = 2.5
    """Minimum factor, up or down, to instability."""
    spread: float = 0.20
    """Relative uncertainty of natural frequency, damping and zero, each."""
    noise_gain: float = 0.174
    """Maximum gain at high frequencies: the ankle's immediate response to a jump of the measured angle. The
    default is that of the thesis' static design, the leading coefficient of (4.19)."""

    def __post_init__(self) -> None:
        if not 0.0 < self.overshoot < 1.0:
            raise ConfigurationError(f"the overshoot is {self.overshoot:g}; it is a fraction, 0 to 1")
        if not self.gain_margin > 1.0:
            raise ConfigurationError(f"the gain margin is {self.gain_margin:g}; it is a factor above 1")
        if not 0.0 <= self.spread < 1.0:
            raise ConfigurationError(f"the spread is {self.spread:g}; it is a fraction, 0 or more and below 1")
        if not self.noise_gain > 0.0:
            raise ConfigurationError(f"the noise gain is {self.noise_gain:g}; it must be positive")


class ThesisRecord(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A controller designed as in thesis 4.2.2."""

    plant: TorsoPlant
    specification: ThesisSpecification
    controller: TorsoController


class RobustRecord(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A controller designed for bounds on uncertain plants."""

    plant: TorsoPlant
    specification: RobustSpecification
    controller: TorsoController


class TorsoDesigns(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The designed controllers of a gait, for each method one per cycle time."""

    thesis: tuple[ThesisRecord, ...] = ()
    robust: tuple[RobustRecord, ...] = ()

    def controller(self, method: Literal["thesis", "robust"], cycle: float) -> TorsoController:
        """The controller of a method for a robot.

        Args:
            method: of the design.
            cycle: of the robot, s.

        Raises:
            ConfigurationError: there is no design for this cycle time.
        """
        for record in self.thesis if method == "thesis" else self.robust:
            if math.isclose(record.controller.sample_time, cycle, rel_tol=1e-9):
                return record.controller
        raise ConfigurationError(
            f"no torso controller ({method}) is designed for a cycle of {1e3 * cycle:g} ms; design one with "
            f"`nao-hil design torso --cycle {cycle:g} --out torso.toml` and walk with --config torso.toml"
        )


_LARGEST_ANGLE: Final = math.pi
"""rad; no torso is pitched further, so a wilder value cannot drive the filter's states anywhere."""


class TorsoLimits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Bounds of the correction at an ankle."""

    offset: float = math.radians(15.0)
    """Largest correction, rad: three times the 5 degrees of slope that the walk is meant for, because a torso
    that has drifted on a slope needs both corrected at once."""
    rate: float = 1.0
    """Fastest change, rad/s. The motor of AnklePitch runs at several rad/s; the rest is the gait's."""
    bleed_rate: float = math.radians(15.0) / 0.4
    """Change of the swing leg's leftover towards zero, rad/s: the largest correction is bled off within the
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
    function applied to the pitch error. When a limit acts, the integrator stops unless it would leave
    the limit (conditional integration), so there is no wind-up.
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
            support: the leg that alone touches the ground, or `both`.

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
