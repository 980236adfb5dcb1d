"""What a loop is worth: margins, step response, Nyquist's criterion, and the data of the usual diagrams."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import control
import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from walker.torso.transfer import Floats, denominator, numerator

Complexes = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Margins:
    """How far a loop is from instability."""

    phase_margin_deg: float
    """The smallest one, degrees."""
    gain_margin: float
    """The factor nearest to 1, up or down, that brings the loop to the border; inf if none does."""
    crossover: float
    """Omega_C where the smallest phase margin is taken, rad/s."""
    phase_crossover: float
    """Where the gain margin is taken, rad/s; nan without one."""


@dataclass(frozen=True, slots=True, eq=False)
class StepResponse:
    """Samples of a unit step response, and its usual figures. Of an unstable loop the figures are inf."""

    time: Floats
    """s, shape (N,)"""
    output: Floats
    """Shape (N,), final value 1"""
    overshoot: float
    """Peak above the final value, share of it."""
    undershoot: float
    """Lowest value, negative if it moves the wrong way first, share of the final value."""
    rise_time: float
    """From 10 % to 90 %, s."""
    settling_time: float
    """From when on it stays within 2 %, s."""


@dataclass(frozen=True, slots=True)
class NyquistCount:
    """Nyquist's criterion on the continuous change of the angle of 1 + L(j Omega), all Omega (4.18)."""

    angle_change: float
    """rad"""
    required: float
    """What a stable closed loop must have, rad."""

    @property
    def stable(self) -> bool:
        """Both agree; the change is a multiple of pi, so half of that separates."""
        return abs(self.angle_change - self.required) < 0.5 * math.pi


@dataclass(frozen=True, slots=True, eq=False)
class Bode:
    """Bode diagram of one transfer function; arrays of shape (N,)."""

    omega: Floats
    """rad/s"""
    magnitude_db: Floats
    phase_deg: Floats
    """Unwrapped from the lowest frequency on."""


def margins(loop_q: control.TransferFunction) -> Margins:
    """Margins of an open loop in the q domain."""
    gain, phase, _, phase_crossover, crossover, _ = control.stability_margins(loop_q)
    return Margins(float(phase), float(gain), float(crossover), float(phase_crossover))


def step_response(closed_loop_z: control.TransferFunction) -> StepResponse:
    """Unit step response of a closed loop with integral action, until its slowest mode is down to 1e-4."""
    sample_time = float(closed_loop_z.dt)
    radius = float(np.abs(closed_loop_z.poles()).max())
    # A minute is longer than any single support; of an unstable loop two seconds show it.
    seconds = min(60.0, math.log(1e-4) / math.log(radius) * sample_time) if 0.0 < radius < 1.0 else 2.0
    samples = max(10, math.ceil(seconds / sample_time))
    top, bottom = numerator(closed_loop_z), denominator(closed_loop_z)
    padded = np.concatenate([np.zeros(len(bottom) - len(top)), top])
    output = np.asarray(lfilter(padded, bottom, np.ones(samples)), dtype=float)
    time = np.arange(samples, dtype=np.float64) * sample_time
    if radius >= 1.0:
        return StepResponse(time, output, math.inf, -math.inf, math.inf, math.inf)
    return StepResponse(
        time,
        output,
        overshoot=float(output.max()) - 1.0,
        undershoot=min(0.0, float(output.min())),
        rise_time=_first_above(time, output, 0.9) - _first_above(time, output, 0.1),
        settling_time=_settled(time, output, 0.02),
    )


def _first_above(time: Floats, output: Floats, level: float) -> float:
    """When the response first passes `level` upwards, interpolated between the samples."""
    above = output >= level
    if not above.any():
        return math.inf
    k = int(np.argmax(above))
    if k == 0:
        return float(time[0])
    share = (level - output[k - 1]) / (output[k] - output[k - 1])
    return float(time[k - 1] + share * (time[k] - time[k - 1]))


def _settled(time: Floats, output: Floats, band: float) -> float:
    outside = np.flatnonzero(np.abs(output - 1.0) > band)
    if outside.size == 0:
        return 0.0
    return float(time[outside[-1] + 1]) if outside[-1] + 1 < len(time) else math.inf


def nyquist_count(loop_q: control.TransferFunction) -> NyquistCount:
    """Apply the Nyquist criterion (4.18) to an open loop in the q domain.

    The thesis prints max(deg z_L, deg z_L); the second one is the denominator's, deg n_L. Poles of the loop on
    the imaginary axis count on neither side, and the jump of the angle at them is no part of its continuous
    change.

    Raises:
        ValueError: 1 + L passes so near to zero that its angle cannot be followed.
    """
    top, bottom = numerator(loop_q), denominator(loop_q)
    poles = np.roots(bottom)
    scale = np.abs(poles)[np.abs(poles) > 0.0]
    on_axis = np.abs(poles.real) <= 1e-9 * np.maximum(np.abs(poles), 1e-9)
    right = int(np.sum((poles.real > 0.0) & ~on_axis))
    left = int(np.sum((poles.real < 0.0) & ~on_axis))
    required = (max(len(top), len(bottom)) - 1 - left + right) * math.pi

    ends = sorted({0.0, *np.abs(poles[on_axis].imag).tolist()})
    edges = [1e-6 * float(scale.min()), *ends[1:], 1e6 * float(scale.max())]
    gap = 1e-7
    change = 0.0
    for low, high in itertools.pairwise(edges):
        change += _angle_change(top, bottom, low * (1.0 + gap), high * (1.0 - gap))
    return NyquistCount(2.0 * change, required)  # the curve of a real loop is symmetric


def _angle_change(top: Floats, bottom: Floats, low: float, high: float) -> float:
    """Continuous change of arg(1 + L) from j `low` to j `high`, halving the steps until each is small."""
    omega = np.geomspace(low, high, 2000)
    for _ in range(40):
        q = 1j * omega
        value = 1.0 + np.polyval(top, q) / np.polyval(bottom, q)
        steps = np.angle(value[1:] / value[:-1])
        coarse = np.flatnonzero(np.abs(steps) > 0.2)
        if coarse.size == 0:
            return float(steps.sum())
        omega = np.insert(omega, coarse + 1, np.sqrt(omega[coarse] * omega[coarse + 1]))
    raise ValueError("1 + L passes through zero on the imaginary axis: the closed loop is at its border")


def frequency_response(system_q: control.TransferFunction, omega: Floats) -> Complexes:
    """Values at q = j Omega, `omega` in rad/s, shape (N,): the points of the Nyquist curve."""
    q = 1j * np.asarray(omega, dtype=float)
    return np.asarray(np.polyval(numerator(system_q), q) / np.polyval(denominator(system_q), q))


def bode(system_q: control.TransferFunction, omega: Floats) -> Bode:
    """Bode diagram at the frequencies `omega`, rad/s, ascending."""
    values = frequency_response(system_q, omega)
    return Bode(
        np.asarray(omega, dtype=float),
        20.0 * np.log10(np.abs(values)),
        np.degrees(np.unwrap(np.angle(values))),
    )
