"""Torso control designed the thesis' way: notch and PI controller by the frequency-response method (4.2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import control
import numpy as np

from bridge.errors import ConfigurationError
from walker.torso.analysis import Margins, StepResponse, frequency_response, margins, step_response
from walker.torso.controller import TorsoController
from walker.torso.transfer import (
    CYCLE,
    check_plant,
    closed_loop,
    denominator,
    numerator,
    to_q,
    to_z,
    zero_order_hold,
)


@dataclass(frozen=True, slots=True)
class Specification:
    """What the closed loop is to do, by the rules of thumb of the frequency-response method (4.2.2)."""

    rise_time: float
    """t_r, s"""
    overshoot: float
    """Share of the final value: 0.1 is the thesis' 10 %."""
    notch_factor: float = 6.0
    """a_Notch (4.16): the wider, the less the resonance must be known."""

    def __post_init__(self) -> None:
        if not self.rise_time > 0.0:
            raise ConfigurationError(f"a rise time of {self.rise_time} s was asked for; it must be positive")
        if not 0.0 <= self.overshoot < 0.7:
            raise ConfigurationError(
                f"an overshoot of {self.overshoot:g} was asked for; it is a share of the final value, 0 to 0.7"
            )
        if not self.notch_factor >= 1.0:
            raise ConfigurationError(f"a notch factor of {self.notch_factor:g} was asked for; it is 1 or more")

    @property
    def crossover(self) -> float:
        """Omega_C = 1.2 / t_r, rad/s."""
        return 1.2 / self.rise_time

    @property
    def phase_margin_deg(self) -> float:
        """Phi = 70 degrees less the overshoot in percent."""
        return 70.0 - 100.0 * self.overshoot


STATIC_GAIT: Final = Specification(rise_time=0.563, overshoot=0.10)
"""The thesis' specification for the statically stable gait."""
DYNAMIC_GAIT: Final = Specification(rise_time=0.29, overshoot=0.10)
"""The thesis' specification for the dynamically stable gait with its short single support."""


@dataclass(frozen=True, slots=True)
class PI:
    """G_PI(q) = V_i (1 + q T_i)/q (4.15)."""

    T_i: float
    """s"""
    V_i: float
    """1/s"""


@dataclass(frozen=True, slots=True, eq=False)
class TorsoDesign:
    """A torso controller, the plant it was made for, and what the two do together.

    The controller's input is the torso pitch error, its output the lean (`walker.torso.sign`), both rad.
    """

    plant: control.TransferFunction
    """G_s(s)"""
    plant_z: control.TransferFunction
    """Behind a zero-order hold (4.13)"""
    plant_q: control.TransferFunction
    """(4.14)"""
    notch_q: control.TransferFunction
    """(4.16); 1 for a plant that needs none"""
    pi: PI
    controller_q: control.TransferFunction
    """(4.17)"""
    controller_z: control.TransferFunction
    """(4.19), monic denominator"""
    loop_q: control.TransferFunction
    """The open loop G_L = G_R G_s"""
    controller: TorsoController
    """The same for the run-time filter"""
    stable: bool
    """All poles of the closed loop are inside the unit circle."""
    margins: Margins
    step: StepResponse
    """Torso angle after a unit step of its reference, and one minus the decay of an error that is suddenly
    there."""

    @property
    def numerator_z(self) -> tuple[float, ...]:
        """Of G_R(z), highest power first."""
        return tuple(float(c) for c in numerator(self.controller_z))

    @property
    def denominator_z(self) -> tuple[float, ...]:
        """Of G_R(z), highest power first, the first is 1."""
        return tuple(float(c) for c in denominator(self.controller_z))


def thesis_design(
    plant: control.TransferFunction, specification: Specification, sample_time: float = CYCLE
) -> TorsoDesign:
    """Design notch and PI controller for a plant, as the thesis does (4.2.2).

    Args:
        plant: continuous, proper, stable, with a positive steady-state gain (`walker.torso.sign`).
        specification: rise time and overshoot.
        sample_time: s.

    Raises:
        ConfigurationError: the plant is none of the kind, or no PI controller gives the wanted phase margin at
            the wanted crossover.
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

    Returns 1 for a plant without a resonance.
    """
    peak = resonance(plant_q)
    if peak is None:
        return control.tf([1.0], [1.0])
    frequency, damping = peak
    square, linear = 1.0 / frequency**2, 2.0 * damping / frequency
    return control.tf([square, linear / factor, 1.0], [square, linear * factor, 1.0])


def fit_pi(loop_q: control.TransferFunction, specification: Specification) -> PI:
    """The PI controller that gives `loop_q` the specified phase margin at the specified crossover.

    At Omega_C the loop's angle must be Phi - 180 degrees and its magnitude 1; the controller's angle there is
    atan(Omega_C T_i) - 90 degrees.

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


def assemble(
    plant: control.TransferFunction, notch_q: control.TransferFunction, pi: PI, sample_time: float
) -> TorsoDesign:
    """Put notch and PI controller together with the plant and work out what comes of it."""
    plant_z = zero_order_hold(plant, sample_time)
    plant_q = to_q(plant_z)
    controller_q = notch_q * control.tf([pi.V_i * pi.T_i, pi.V_i], [1.0, 0.0])
    controller_z = to_z(controller_q, sample_time)
    closed = closed_loop(controller_z, plant_z)
    loop_q = controller_q * plant_q
    return TorsoDesign(
        plant=plant,
        plant_z=plant_z,
        plant_q=plant_q,
        notch_q=notch_q,
        pi=pi,
        controller_q=controller_q,
        controller_z=controller_z,
        loop_q=loop_q,
        controller=_sections(notch_q, pi, sample_time),
        stable=bool(np.abs(closed.poles()).max() < 1.0),
        margins=margins(loop_q),
        step=step_response(closed),
    )


def _sections(notch_q: control.TransferFunction, pi: PI, sample_time: float) -> TorsoController:
    notch_z = to_z(notch_q, sample_time)
    top, bottom = numerator(notch_z), denominator(notch_z)
    # A factor z^k above and below changes nothing and gives the section its fixed length.
    n0, n1, n2 = (*(float(c) for c in top), *[0.0] * (3 - len(top)))
    d0, d1, d2 = (*(float(c) for c in bottom), *[0.0] * (3 - len(bottom)))
    return TorsoController(sample_time, pi.V_i, pi.T_i, (n0, n1, n2), (d0, d1, d2))
