"""A torso controller put together with its plant: transfer functions, margins and step response."""

from __future__ import annotations

from dataclasses import dataclass

import control
import numpy as np

from nao_hil.design.torso.analysis import Margins, StepResponse, margins, step_response
from nao_hil.design.torso.transfer import closed_loop, denominator, numerator, to_q, to_z, zero_order_hold
from walker.mechanisms.torso_control import TorsoController


@dataclass(frozen=True, slots=True)
class PI:
    """G_PI(q) = V_i (1 + q T_i)/q (4.15)."""

    T_i: float
    """Integration time of the PI controller, s."""
    V_i: float
    """1/s"""


@dataclass(frozen=True, slots=True, eq=False)
class TorsoDesign:
    """A torso controller, its plant, and the figures of their loop.

    The controller's input is the torso pitch error, its output the lean (see `torso.sign`), both rad.
    """

    plant_z: control.TransferFunction
    """G_s(s) behind a zero-order hold (4.13)"""
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
    """The same as the numbers of the run-time filter"""
    stable: bool
    """All poles of the closed loop are inside the unit circle."""
    margins: Margins
    step: StepResponse
    """Torso angle after a unit step of its reference."""

    @property
    def numerator_z(self) -> tuple[float, ...]:
        """Numerator of G_R(z), highest power first."""
        return tuple(float(c) for c in numerator(self.controller_z))

    @property
    def denominator_z(self) -> tuple[float, ...]:
        """Denominator of G_R(z), highest power first, the first is 1."""
        return tuple(float(c) for c in denominator(self.controller_z))


def assemble(
    plant: control.TransferFunction, notch_q: control.TransferFunction, pi: PI, sample_time: float
) -> TorsoDesign:
    """The design that consists of a notch and a PI controller, and its figures on a plant.

    Args:
        plant: G_s(s).
        notch_q: notch in the q domain.
        pi: PI controller.
        sample_time: s.
    """
    plant_z = zero_order_hold(plant, sample_time)
    plant_q = to_q(plant_z)
    controller_q = notch_q * control.tf([pi.V_i * pi.T_i, pi.V_i], [1.0, 0.0])
    controller_z = to_z(controller_q, sample_time)
    closed = closed_loop(controller_z, plant_z)
    loop_q = controller_q * plant_q
    return TorsoDesign(
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
    return TorsoController(
        sample_time=sample_time,
        integral_gain=pi.V_i,
        reset_time=pi.T_i,
        notch_numerator=(n0, n1, n2),
        notch_denominator=(d0, d1, d2),
    )
