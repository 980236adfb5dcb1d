"""Motions of the hip at many times, as linear functions of the numbers that are searched."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bridge.types import Array
from walker.gaits.huang.hip import hip_x, hip_y
from walker.gaits.huang.parameters import HuangParameters


class Sampled(NamedTuple):
    """Position, velocity and acceleration at many times."""

    position: Array
    velocity: Array
    acceleration: Array


class Linear(NamedTuple):
    """A motion that is linear in two numbers a, b: base + a first + b second."""

    base: Sampled
    first: Sampled
    second: Sampled

    def at(self, a: Array, b: Array) -> Sampled:
        """The motions for many pairs, each of shape (times, pairs).

        Args:
            a: first numbers, shape (pairs,).
            b: second numbers, shape (pairs,).
        """
        return Sampled(
            *(
                base[:, None] + np.outer(first, a) + np.outer(second, b)
                for base, first, second in zip(self.base, self.first, self.second, strict=True)
            )
        )


def sample_x(p: HuangParameters, times: Array) -> Linear:
    """X as a function of x_sd and x_ed.

    Args:
        p: parameters.
        times: from the beginning of double support, s, shape (times,).
    """

    def one(x_sd: float, x_ed: float) -> Sampled:
        position, velocity, acceleration = hip_x(p, x_sd, x_ed).sample(times)
        mean = p.D_s / p.T_c
        return Sampled(position + mean * times, velocity + mean, acceleration)

    return _linear(one(0.0, 0.0), one(1.0, 0.0), one(0.0, 1.0))


def sample_y(p: HuangParameters, times: Array) -> Linear:
    """Y as a function of y_d and y_m.

    Args:
        p: parameters.
        times: from the beginning of double support, s, shape (times,).
    """
    return _linear(*(Sampled(*hip_y(p, *ends).sample(times)) for ends in ((0, 0), (1, 0), (0, 1))))


def _linear(base: Sampled, first: Sampled, second: Sampled) -> Linear:
    return Linear(
        base,
        Sampled(*(a - b for a, b in zip(first, base, strict=True))),
        Sampled(*(a - b for a, b in zip(second, base, strict=True))),
    )
