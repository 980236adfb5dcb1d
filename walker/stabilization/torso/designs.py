"""Designed torso controllers as data, each with the plant and the specification that it was designed for.

`nao-hil design torso` computes them; `walker/planning/<gait>/torso.toml` holds those of a gait.
"""

from __future__ import annotations

import math
from typing import Literal

import msgspec

from bridge.errors import ConfigurationError
from walker.stabilization.torso.controller import TorsoController


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
    """Maximum gain at high frequencies: how far a jump of the measured angle moves the ankle at once. The
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
