"""Admittance of one leg along z (thesis 4.1.1): the swing foot stops where it meets the ground.

D e' = F_ext - F_d(e) (4.1) with the spring F_d(e) = k_c tan((e + k_b) / (2 pi k_a)) + k_d (4.4).

Departures from the thesis: (4.3) is explicit Euler, which overshoots the pole of the tangent; here the step is
implicit, e_{k+1} = e_k + T_s / D (F_k - F_d(e_{k+1})), whose one solution lies inside the pole for every
force. A force tolerance keeps sensor noise from lifting the foot: the spring is so soft near zero (24 N/m)
that 0.2 N held for long would lift it 8 mm.
"""

from __future__ import annotations

import math

import msgspec

from bridge.types import NotNegative, Positive
from walker.estimation.support_state import Role
from walker.model.roots import brent
from walker.stabilization.admittance.phases import APEX, clip, kept, lowered

_INSIDE = 1.0 - 1e-9
"""Fraction of the way to the pole that e may go; there the spring pulls with 3e8 N."""


class LegParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the leg admittance; symbols of the thesis (4.4), SI units."""

    k_a: Positive = 1.0 / 300.0
    """m: the pole of the spring is at |e + k_b| = pi^2 k_a, 32.9 mm."""
    k_b: float = 0.0
    """m"""
    k_c: Positive = 0.5
    """N"""
    k_d: float = 0.0
    """N"""
    D: Positive = 75.0
    """Damping, N s/m. Not given in the thesis. A foot whose target sinks at the speed v into an obstacle is
    loaded with D v + F_d(e). The static gait's foot passes the height of 10 mm at 0.065 m/s, so the 5 N of
    figure 4.1 allow at most (5 - 0.26) / 0.065 = 73. Below it waits instability: contact of the stiffness k
    makes e' = -k e / D, delayed by servo and sampling by T = 50 ms, stable for k < pi D / (2 T) = 2.4 kN/m.
    """
    latency: Positive = 0.05
    """T of servo and sampling, s. In a loop that is late by d besides, D (T + d) / T has the margin of D in one
    that is not, and is what is used."""
    force_tolerance: NotNegative = 0.5
    """Sum of the foot's sensor forces that does not count, N."""
    target_depth: NotNegative = 0.005
    """How far below the nominal ground the swing foot's target ends, m, to step into depressions too."""
    max_ankle_z: float = -0.100
    """Leg length limit: the ankle stays below this height in the frame of the hip, m (z_{i,0}^{i,8})."""
    max_rate: Positive = 0.3
    """Largest speed of the offset, m/s: what the knee of a bent leg follows."""

    def __post_init__(self) -> None:
        if abs(self.k_b) >= self.pole:
            raise ValueError(f"k_b = {self.k_b} m lies beyond the spring's pole, |k_b| < {self.pole:.4f} m")

    @property
    def pole(self) -> float:
        """Deflection |e + k_b| at which the spring's force is infinite, m."""
        return math.pi**2 * self.k_a

    def spring(self, e: float) -> float:
        """F_d(e) in N (4.4), for |e + k_b| < `pole`."""
        return self.k_c * math.tan((e + self.k_b) / (2.0 * math.pi * self.k_a)) + self.k_d


class LegAdmittance:
    """Offset of one foot along z from its plan.

    States (see `phases`): hold in stance, release in the first half of the swing, comply in the second. The
    target that reaches below the ground is part of the offset, so that what is held is what the foot found:
    0 on level ground, positive on an obstacle, down to -`target_depth` (and `search_depth`) in a depression.
    """

    def __init__(self, parameters: LegParameters) -> None:
        self._p = parameters
        self.e = 0.0
        """Error e_z = x_0 - x_d of the thesis, m, up positive."""
        self.depth = 0.0
        """How far the target x_d lies below the plan, m."""
        self._held = (0.0, 0.0)

    def update(
        self,
        force_z: float,
        role: Role,
        dt: float,
        *,
        progress: float = 1.0,
        ankle_z: float = -math.inf,
        search_depth: float = 0.0,
        delay: float = 0.0,
    ) -> float:
        """One cycle.

        Args:
            force_z: sum of the foot's four sensors, N (F_ext,z).
            role: of this leg.
            dt: cycle time, s.
            progress: fraction of the swing that has passed, 0..1; without meaning in stance.
            ankle_z: planned height of this leg's ankle in the frame of its hip, m (negative), for the limit
                `max_ankle_z`; the limit does not lengthen a leg that is planned too short.
            search_depth: how much further below the ground the target of a late swing foot is, m.
            delay: of the loop, besides `latency`, s.

        Returns:
            e - depth: what to add to the planned height of the foot, m, up positive. It changes by at most
            `max_rate` dt per cycle, except downwards where the leg length limit forces it.
        """
        p = self._p
        damping = p.D * (1.0 + delay / p.latency)
        e, depth = self._wanted(force_z, role, dt / damping, progress, search_depth)
        step = p.max_rate * dt
        sink = clip(depth - self.depth, -step, step)
        self.e += clip(e - self.e, sink - step, sink + step)
        self.depth += sink
        if role == "swing":
            self.e = min(self.e, max(p.max_ankle_z - ankle_z, 0.0) + self.depth)
        return self.e - self.depth

    @property
    def held(self) -> float:
        """Height over the plan at which the foot stands, or stood when it was last on the ground, m."""
        return self._held[0] - self._held[1]

    def lower(self, by: float) -> None:
        """Lower the foot and where it stood by `by`, m: the body rises over both feet.

        Stays inside the spring's poles.
        """
        p = self._p
        lowest, highest = -p.pole * _INSIDE - p.k_b, p.pole * _INSIDE - p.k_b
        self.e = clip(self.e - by, lowest, highest)
        self._held = clip(self._held[0] - by, lowest, highest), self._held[1]

    def _wanted(
        self, force_z: float, role: Role, yielding: float, progress: float, search_depth: float
    ) -> tuple[float, float]:
        """Error and depth before the limits; all three states keep e strictly inside the pole.

        `yielding` is T_s / D, m/N.
        """
        if role == "stance":
            self._held = self.e, self.depth
            return self._held
        if progress < APEX:
            return self._held[0] * kept(progress), self._held[1] * kept(progress)
        return self._comply(force_z, yielding), self._p.target_depth * lowered(progress) + search_depth

    def _comply(self, force_z: float, yielding: float) -> float:
        """Implicit step of (4.1): the root of a function that rises from -inf to inf between the poles."""
        p = self._p
        force = max(force_z - p.force_tolerance, 0.0)

        def residual(e: float) -> float:
            return e - self.e - yielding * (force - p.spring(e))

        lowest, highest = -p.pole * _INSIDE - p.k_b, p.pole * _INSIDE - p.k_b
        if residual(highest) <= 0.0:
            return highest
        if residual(lowest) >= 0.0:
            return lowest
        return brent(residual, lowest, highest, 1e-12)
