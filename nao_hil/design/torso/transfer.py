"""Transfer functions between the s, z and q domains, and the plants they start from.

The q domain is the image of the z domain under Tustin's map z = (1 + q T/2) / (1 - q T/2). The unit circle
becomes the imaginary axis q = j Omega with Omega = (2/T) tan(omega T/2), so the methods for continuous loops
hold exactly for sampled ones; far below the sampling rate Omega is the angular frequency itself.
"""

from __future__ import annotations

import math
from typing import Final

import control
import numpy as np

from bridge.errors import ConfigurationError
from bridge.types import Array
from walker.mechanisms.torso_control import TorsoPlant

CYCLE: Final = 0.01
"""Sample time of the DCM exchange, s (thesis ch. 1.2)."""


def transfer_function(plant: TorsoPlant) -> control.TransferFunction:
    """G_s(s) of a plant, in the thesis' sign (see `walker.mechanisms.torso_control`)."""
    return control.tf(list(plant.numerator), list(plant.denominator))


def thesis_plant() -> control.TransferFunction:
    """The plant that the thesis identified on its robot (4.12)."""
    return transfer_function(TorsoPlant())


def numerator(system: control.TransferFunction) -> Array:
    """Coefficients of a single-input, single-output transfer function's numerator, highest power first."""
    return np.asarray(system.num[0][0], dtype=float)


def denominator(system: control.TransferFunction) -> Array:
    """Coefficients of the denominator, highest power first."""
    return np.asarray(system.den[0][0], dtype=float)


def check_plant(plant: control.TransferFunction) -> None:
    """Check that the designs can handle a plant.

    Raises:
        ConfigurationError: the plant is not continuous, proper, stable and of positive steady-state gain.
    """
    if not control.isctime(plant, strict=True):
        raise ConfigurationError("the plant is sampled; the torso design needs the continuous one, G(s)")
    if len(np.trim_zeros(numerator(plant), "f")) > len(np.trim_zeros(denominator(plant), "f")):
        raise ConfigurationError("the plant's numerator is of higher degree than its denominator")
    poles = plant.poles()
    if poles.size and poles.real.max() >= 0.0:
        raise ConfigurationError(
            f"the plant has a pole with real part {poles.real.max():.3g} 1/s; the design needs a stable plant"
        )
    gain = float(np.real(plant.dcgain()))
    if not (math.isfinite(gain) and gain > 0.0):
        raise ConfigurationError(
            f"the plant's steady-state gain is {gain:.3g}; the torso design needs a positive one "
            "(change the sign of a plant measured from AnklePitch to AngleY, see docs/walking.md)"
        )


def zero_order_hold(plant: control.TransferFunction, sample_time: float = CYCLE) -> control.TransferFunction:
    """Sample a continuous plant behind a zero-order hold (4.13).

    Args:
        plant: G_s(s).
        sample_time: s.
    """
    return control.sample_system(plant, sample_time, method="zoh")


def to_q(system_z: control.TransferFunction) -> control.TransferFunction:
    """From the z to the q domain (4.14); the denominator's lowest coefficient other than zero becomes 1."""
    half = 0.5 * float(system_z.dt)
    order = _order(system_z)
    numerator_q = _substitute(numerator(system_z), order, [half, 1.0], [-half, 1.0])
    denominator_q = _substitute(denominator(system_z), order, [half, 1.0], [-half, 1.0])
    # A pole at z = 1 is one at q = 0, up to rounding: it must not end up as a pole near the origin.
    denominator_q[np.abs(denominator_q) < 1e-12 * np.abs(denominator_q).max()] = 0.0
    scale = denominator_q[np.flatnonzero(denominator_q)[-1]]
    return control.tf(numerator_q / scale, denominator_q / scale)


def to_z(system_q: control.TransferFunction, sample_time: float = CYCLE) -> control.TransferFunction:
    """From the q back to the z domain by the inverse map q = (2/T) (z - 1)/(z + 1).

    Args:
        system_q: transfer function in q.
        sample_time: T, s.

    Returns:
        Transfer function in z with a monic denominator.
    """
    rate = 2.0 / sample_time
    order = _order(system_q)
    numerator_z = _substitute(numerator(system_q), order, [rate, -rate], [1.0, 1.0])
    denominator_z = _substitute(denominator(system_q), order, [rate, -rate], [1.0, 1.0])
    return control.tf(numerator_z / denominator_z[0], denominator_z / denominator_z[0], sample_time)


def closed_loop(
    controller: control.TransferFunction, plant: control.TransferFunction
) -> control.TransferFunction:
    """From the reference to the output of the loop with unit negative feedback, nothing cancelled.

    Args:
        controller: G_R(z).
        plant: G_s(z).
    """
    forward = np.polymul(numerator(controller), numerator(plant))
    open_denominator = np.polymul(denominator(controller), denominator(plant))
    return control.tf(forward, np.polyadd(open_denominator, forward), plant.dt)


def _order(system: control.TransferFunction) -> int:
    return max(len(numerator(system)), len(denominator(system))) - 1


def _substitute(polynomial: Array, order: int, top: list[float], bottom: list[float]) -> Array:
    """Coefficients of p(top/bottom) bottom^order, for first-degree polynomials `top` and `bottom`."""
    result = np.zeros(order + 1)
    for power, coefficient in enumerate(polynomial[::-1]):
        term = np.array([coefficient])
        for _ in range(power):
            term = np.convolve(term, top)
        for _ in range(order - power):
            term = np.convolve(term, bottom)
        result += term
    return result
