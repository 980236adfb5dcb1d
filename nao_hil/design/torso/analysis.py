"""Figures of a control loop: margins, step response, Bode diagram and Nyquist curve."""

from __future__ import annotations

import math
from dataclasses import dataclass

import control
import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from bridge.types import Array
from nao_hil.design.torso.transfer import denominator, numerator

Complexes = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Margins:
    """Phase and gain margin of a loop."""

    phase_margin_deg: float
    """Minimum over all crossovers, degrees."""
    gain_margin: float
    """The factor nearest to 1, up or down, at which the loop becomes unstable; inf if there is none."""
    crossover: float
    """Omega_C of the phase margin, rad/s."""


@dataclass(frozen=True, slots=True, eq=False)
class StepResponse:
    """Samples of a unit step response, and its figures, which are inf for an unstable loop."""

    time: Array
    """s, shape (N,)"""
    output: Array
    """Shape (N,), final value 1"""
    overshoot: float
    """Peak above the final value, fraction of it."""
    rise_time: float
    """From 10 % to 90 %, s."""
    settling_time: float
    """Time after which it stays within 2 %, s."""


@dataclass(frozen=True, slots=True, eq=False)
class Bode:
    """Bode diagram of one transfer function; arrays of shape (N,)."""

    magnitude_db: Array
    phase_deg: Array
    """Unwrapped from the lowest frequency on."""


def margins(loop_q: control.TransferFunction) -> Margins:
    """Margins of an open loop in the q domain."""
    gain, phase, _, _, crossover, _ = control.stability_margins(loop_q)
    return Margins(float(phase), float(gain), float(crossover))


def step_response(closed_loop_z: control.TransferFunction) -> StepResponse:
    """Unit step response of a closed loop with integral action, until its slowest mode is down to 1e-4."""
    sample_time = float(closed_loop_z.dt)
    radius = float(np.abs(closed_loop_z.poles()).max())
    # A minute is longer than any single support; two seconds show that a loop is unstable.
    seconds = min(60.0, math.log(1e-4) / math.log(radius) * sample_time) if 0.0 < radius < 1.0 else 2.0
    samples = max(10, math.ceil(seconds / sample_time))
    top, bottom = numerator(closed_loop_z), denominator(closed_loop_z)
    padded = np.concatenate([np.zeros(len(bottom) - len(top)), top])
    output = np.asarray(lfilter(padded, bottom, np.ones(samples)), dtype=float)
    time = np.arange(samples, dtype=np.float64) * sample_time
    if radius >= 1.0:
        return StepResponse(time, output, math.inf, math.inf, math.inf)
    return StepResponse(
        time,
        output,
        overshoot=float(output.max()) - 1.0,
        rise_time=_first_above(time, output, 0.9) - _first_above(time, output, 0.1),
        settling_time=_settled(time, output, 0.02),
    )


def _first_above(time: Array, output: Array, level: float) -> float:
    """Time at which the response first exceeds `level`, interpolated between the samples, s."""
    above = output >= level
    if not above.any():
        return math.inf
    k = int(np.argmax(above))
    if k == 0:
        return float(time[0])
    fraction = (level - output[k - 1]) / (output[k] - output[k - 1])
    return float(time[k - 1] + fraction * (time[k] - time[k - 1]))


def _settled(time: Array, output: Array, band: float) -> float:
    outside = np.flatnonzero(np.abs(output - 1.0) > band)
    if outside.size == 0:
        return 0.0
    return float(time[outside[-1] + 1]) if outside[-1] + 1 < len(time) else math.inf


def frequency_response(system_q: control.TransferFunction, omega: Array) -> Complexes:
    """Values at q = j Omega: the points of the Nyquist curve.

    Args:
        system_q: transfer function in q.
        omega: rad/s, shape (N,).

    Returns:
        Shape (N,).
    """
    q = 1j * np.asarray(omega, dtype=float)
    return np.asarray(np.polyval(numerator(system_q), q) / np.polyval(denominator(system_q), q))


def bode(system_q: control.TransferFunction, omega: Array) -> Bode:
    """Bode diagram of a transfer function.

    Args:
        system_q: transfer function in q.
        omega: rad/s, ascending, shape (N,).
    """
    values = frequency_response(system_q, omega)
    return Bode(20.0 * np.log10(np.abs(values)), np.degrees(np.unwrap(np.angle(values))))
