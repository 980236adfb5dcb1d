"""The torso controller as numbers: what a design hands to the run-time filter."""

from __future__ import annotations

import msgspec


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
