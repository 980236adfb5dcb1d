"""Torso control designed as in the thesis: notch and PI controller by the frequency-response method (4.2.2)."""

from __future__ import annotations

import math
from typing import Final

import control
import numpy as np

from bridge.errors import ConfigurationError
from nao_hil.design.torso.analysis import frequency_response
from nao_hil.design.torso.assembly import PI, TorsoDesign, assemble
from nao_hil.design.torso.transfer import CYCLE, check_plant, to_q, zero_order_hold
from walker.mechanisms.torso_control import ThesisSpecification

STATIC_GAIT: Final = ThesisSpecification(rise_time=0.563, overshoot=0.10)
"""The thesis' specification for the statically stable gait."""
DYNAMIC_GAIT: Final = ThesisSpecification(rise_time=0.29, overshoot=0.10)
"""The thesis' specification for the dynamically stable gait with its short single support."""


def thesis_design(
    plant: control.TransferFunction, specification: ThesisSpecification, sample_time: float = CYCLE
) -> TorsoDesign:
    """Design notch and PI controller for a plant, as the thesis does (4.2.2).

    Args:
        plant: continuous, proper, stable, with a positive steady-state gain (see `torso.sign`).
        specification: rise time and overshoot.
        sample_time: s.

    Raises:
        ConfigurationError: the plant is not of this kind, or no PI controller gives the phase margin at the
            crossover.
    """
    check_plant(plant)
    plant_q = to_q(zero_order_hold(plant, sample_time))
    notch_q = notch(plant_q, specification.notch_factor)
    return assemble(plant, notch_q, fit_pi(notch_q * plant_q, specification), sample_time)


def resonance(plant_q: control.TransferFunction) -> tuple[float, float] | None:
    """Natural frequency, rad/s, and damping of the least damped pole pair that makes a resonance peak."""
    poles = plant_q.poles()
    candidates = [(abs(p), -p.real / abs(p)) for p in poles if p.imag > 0.0]
    peaking = [pair for pair in candidates if pair[1] < math.sqrt(0.5)]
    if not peaking:
        return None
    frequency, damping = min(peaking, key=lambda pair: pair[1])
    return float(frequency), float(damping)


def notch(plant_q: control.TransferFunction, factor: float) -> control.TransferFunction:
    """Notch filter on the plant's resonance (4.16): damping divided and multiplied by a_Notch.

    Args:
        plant_q: G_s(q).
        factor: a_Notch.

    Returns:
        The notch in the q domain; 1 for a plant without a resonance.
    """
    peak = resonance(plant_q)
    if peak is None:
        return control.tf([1.0], [1.0])
    frequency, damping = peak
    square, linear = 1.0 / frequency**2, 2.0 * damping / frequency
    return control.tf([square, linear / factor, 1.0], [square, linear * factor, 1.0])


def fit_pi(loop_q: control.TransferFunction, specification: ThesisSpecification) -> PI:
    """The PI controller that gives a loop the specified phase margin at the specified crossover.

    At Omega_C the loop's angle must be Phi - 180 degrees and its magnitude 1; the controller's angle there is
    atan(Omega_C T_i) - 90 degrees.

    Args:
        loop_q: open loop without the PI controller, in q.
        specification: rise time and overshoot.

    Raises:
        ConfigurationError: a PI controller would have to turn the phase by more than its 0 to 90 degrees.
    """
    omega = specification.crossover
    value = frequency_response(loop_q, np.array([omega]))[0]
    wanted = math.radians(specification.phase_margin_deg - 90.0)
    lift = math.remainder(wanted - float(np.angle(value)), 2.0 * math.pi)
    if not 0.0 <= lift < 0.5 * math.pi:
        remedy = "longer" if lift > 0.0 else "shorter"
        raise ConfigurationError(
            f"no PI controller reaches a phase margin of {specification.phase_margin_deg:g} degrees at "
            f"{omega:.3g} rad/s on this plant: it would have to turn the phase by {math.degrees(lift):.0f} "
            f"degrees and can by 0 to 90; ask for a {remedy} rise time than {specification.rise_time:g} s"
        )
    T_i = math.tan(lift) / omega
    return PI(T_i=T_i, V_i=omega / (float(abs(value)) * math.hypot(1.0, omega * T_i)))
