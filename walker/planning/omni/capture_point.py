"""Capture-point end conditions: where the capture point must be for a walk to go on without end.

For a ZMP p(t) the capture point obeys xi' = omega (xi - p) (Englsberger et al., T-RO 31(2), 2015). It stays
bounded only if it begins at xi(0) = omega int_0^inf exp(-omega t) p(t) dt. In step i, of duration T, the ZMP
goes within the first T_DSP straight from p_{i-1} to p_i and rests there. With q = exp(-omega T) and
rho = 1 - (1 - exp(-omega T_DSP)) / (omega T_DSP) the integral is

    xi(0) = sum_i q^(i-1) ((1 - q) p_i - rho (p_i - p_{i-1})),  i = 1, 2, ...
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from bridge.types import Vec2


def transfer_weight(omega: float, duration: float) -> float:
    """rho: the weight that the ZMP of the step before keeps, for a transfer within `duration` (s)."""
    s = omega * duration
    return 1.0 + math.expm1(-s) / s if s > 0.0 else 0.0


def bounded_capture_point(omega: float, T: float, rho: float, zmps: Sequence[Vec2]) -> Vec2:
    """Capture point at the beginning of a step from which the walk stays bounded, m.

    Args:
        omega: natural frequency of the pendulum, 1/s.
        T: duration of a step, s.
        rho: see `transfer_weight`.
        zmps: p_0 (of the step before), p_1, p_2, ...; the last one is kept for ever.
    """
    q = math.exp(-omega * T)
    x = y = 0.0
    weight = 1.0
    for before, here in itertools.pairwise(zmps):
        x += weight * ((1.0 - q) * here[0] - rho * (here[0] - before[0]))
        y += weight * ((1.0 - q) * here[1] - rho * (here[1] - before[1]))
        weight *= q
    return x + weight * zmps[-1][0], y + weight * zmps[-1][1]
