"""Fit of the torso's plant, in the form of (4.12), to a measured step response."""

from __future__ import annotations

from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Vector = NDArray[np.float64]
STARTS: Final = ((5.0, 0.02), (7.0, 0.1), (9.0, 0.05))
"""Natural frequencies and zeros from which the fit is started; the best end counts."""


class Plant(msgspec.Struct, frozen=True, kw_only=True):
    """gain (1 - zero_time s) / (s^2 / w^2 + 2 damping s / w + 1), w the natural frequency."""

    gain: float
    natural_frequency_rad_s: float
    damping: float
    zero_time_s: float
    """Positive: a right-half-plane zero at 1 / zero_time."""

    def step(self, time: Vector) -> Vector:
        """Response to a unit step at time 0, in closed form."""
        w, d = self.natural_frequency_rad_s, self.damping
        t = np.maximum(time, 0.0)
        ring = w * np.sqrt(1.0 - d * d)
        decay = np.exp(-d * w * t)
        rest = decay * (np.cos(ring * t) + d * w / ring * np.sin(ring * t))
        impulse = w * w / ring * decay * np.sin(ring * t)
        return np.asarray(np.where(time > 0.0, self.gain * (1.0 - rest - self.zero_time_s * impulse), 0.0))


THESIS: Final = Plant(
    gain=1.0, natural_frequency_rad_s=0.02041**-0.5, damping=0.5 * 0.02857 * 0.02041**-0.5, zero_time_s=0.125
)
"""(4.12)"""


class Shape(msgspec.Struct, frozen=True, kw_only=True):
    """What one reads off a step response, as shares of its final value."""

    final: float
    """Mean of the last second."""
    peak: float
    undershoot: float
    """Lowest value before the rise, negative."""
    rise_time_s: float
    """From 10 to 90 % of the final value."""


def fit_plant(time: Vector, response: Vector) -> tuple[Plant, float]:
    """The plant with the least squared error, and the root mean square of what it leaves.

    Args:
        time: After the step, s, shape (n,).
        response: To a step of size 1, shape (n,).
    """

    def plant(values: Vector) -> Plant:
        gain, frequency, damping, zero = values.tolist()
        return Plant(gain=gain, natural_frequency_rad_s=frequency, damping=damping, zero_time_s=zero)

    fits = [
        least_squares(
            lambda values: plant(values).step(time) - response,
            (response[-1], frequency, 0.15, zero),
            bounds=((-10.0, 1.0, 0.005, -1.0), (10.0, 30.0, 0.95, 1.0)),
        )
        for frequency, zero in STARTS
    ]
    best = min(fits, key=lambda fit: float(fit.cost))
    return plant(best.x), float(np.sqrt(np.mean(best.fun**2)))


def read_shape(time: Vector, response: Vector) -> Shape:
    """Peak, undershoot and rise of a step response; arguments as in `fit_plant`."""
    final = float(response[time > time[-1] - 1.0].mean())
    share = response / final
    low = int(np.argmax(share >= 0.1))
    high = int(np.argmax(share >= 0.9))

    def crossing(level: float, k: int) -> float:
        if k == 0:
            return float(time[0])
        return float(np.interp(level, share[k - 1 : k + 1], time[k - 1 : k + 1]))

    return Shape(
        final=final,
        peak=float(share.max()),
        undershoot=min(0.0, float(share[: low + 1].min())),
        rise_time_s=crossing(0.9, high) - crossing(0.1, low),
    )
