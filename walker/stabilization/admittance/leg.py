"""Admittance of the legs along z (thesis 4.1.1): the swing foot stops where it meets the ground.

D e' = F_ext - F_d(e) (4.1) with the spring F_d(e) = k_c tan((e + k_b) / (2 pi k_a)) + k_d (4.4) acts on the
swing leg only. What becomes of its offset follows from 3.1: during a double support the height difference of
the feet l_HD is constant, and the leg that becomes the stance leg then has the length l_GH. So over a double
support the offset of the foot that landed passes to the other leg, with the opposite sign, and the body rises
onto the ground that the foot found.

Departures from the thesis: (4.3) is explicit Euler, which overshoots the pole of the tangent; here the step is
implicit, e_{k+1} = e_k + T_s / D (F_k - F_d(e_{k+1})), whose one solution lies inside the pole for every
force. A force tolerance keeps sensor noise from lifting the foot: the spring is so soft near zero (24 N/m)
that 0.2 N held for long would lift it 8 mm.
"""

from __future__ import annotations

import math

import msgspec

from bridge.types import SIDES, Fraction, NotNegative, Positive, Side, Vec2
from walker.estimation.support_state import OTHER, SupportState
from walker.functions import brent, clip, smoothstep
from walker.planning.plan import Plan

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
    start: Fraction = 0.5
    """Fraction of the swing from which the force counts (not given in the thesis): before that the foot may
    still be leaving the ground, and the load it takes with it would shorten the leg for the whole step."""
    target_depth: NotNegative = 0.005
    """How far below the nominal ground the swing foot's target ends, m, to step into depressions too."""
    max_ankle_z: float = -0.100
    """Leg length limit: the ankle stays below this height in the frame of the hip, m (z_{i,0}^{i,8})."""
    max_rate: Positive = 0.3
    """Largest speed of the offset, m/s: a bent knee follows it."""

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
    """Offset of one swing foot along z from its plan.

    The target that reaches below the ground is part of the offset: it is 0 on level ground, positive on an
    obstacle, down to -`target_depth` (and `search_depth`) in a depression.

    Args:
        parameters: of the admittance.
    """

    def __init__(self, parameters: LegParameters) -> None:
        self._p = parameters
        self.e = 0.0
        """Error e_z = x_0 - x_d of the thesis, m, up positive."""
        self.depth = 0.0
        """Depth of the target x_d below the plan, m."""

    @property
    def offset(self) -> float:
        """Height of the foot over its plan, m."""
        return self.e - self.depth

    def shift(self, by: float) -> None:
        """Raise the foot, m; stays inside the spring's poles. The target is the plan again."""
        p = self._p
        self.e = clip(self.offset + by, -p.pole * _INSIDE - p.k_b, p.pole * _INSIDE - p.k_b)
        self.depth = 0.0

    def swing(
        self,
        force_z: float,
        dt: float,
        *,
        progress: float = 1.0,
        ankle_z: float = -math.inf,
        search_depth: float = 0.0,
        delay: float = 0.0,
    ) -> float:
        """One cycle of the swing leg.

        Args:
            force_z: sum of the foot's four sensors, N (F_ext,z).
            dt: cycle time, s.
            progress: fraction of the swing that has passed, 0..1; the target sinks in its second half.
            ankle_z: planned height of this leg's ankle in the frame of its hip, m (negative), for the limit
                `max_ankle_z`; the limit does not lengthen a leg that is planned too short.
            search_depth: how much further below the ground the target of a late swing foot is, m.
            delay: of the loop, besides `latency`, s.

        Returns:
            e - depth: what to add to the planned height of the foot, m, up positive. It changes by at most
            `max_rate` dt per cycle, except downwards where the leg length limit forces it.
        """
        p = self._p
        e = self._comply(force_z if progress >= p.start else 0.0, dt / (p.D * (1.0 + delay / p.latency)))
        depth = p.target_depth * smoothstep(2.0 * progress - 1.0) + search_depth
        step = p.max_rate * dt
        sink = clip(depth - self.depth, -step, step)
        self.e += clip(e - self.e, sink - step, sink + step)
        self.depth += sink
        self.e = min(self.e, max(p.max_ankle_z - ankle_z, 0.0) + self.depth)
        return self.offset

    def _comply(self, force_z: float, yielding: float) -> float:
        """Implicit step of (4.1): the root of a function that rises from -inf to inf between the poles.

        `yielding` is T_s / D, m/N.
        """
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


class LegAdmittances:
    """Offsets of both feet along z: the swing leg yields, a double support passes its offset on.

    Args:
        parameters: of the admittance.
        foot_height: of the ankle over the sole, m.
    """

    def __init__(self, parameters: LegParameters, foot_height: float) -> None:
        self._p = parameters
        self._foot_height = foot_height
        self._legs = {side: LegAdmittance(parameters) for side in SIDES}
        self._landed: Side = "L"
        """The last swing leg, which becomes the stance leg."""
        self._passed = 0.0
        """Part of the present double support's exchange that is done, 0..1."""

    def update(self, plan: Plan, support: SupportState, forces: Vec2, dt: float, *, delay: float = 0.0) -> Vec2:
        """One cycle.

        Args:
            plan: the plan.
            support: roles of the legs.
            forces: sums of both feet's sensors, left and right, N.
            dt: cycle time, s.
            delay: of the loop, besides `latency`, s.

        Returns:
            What to add to the planned heights of both feet, m, up positive.
        """
        if support.support == "both":
            self._exchange(plan.progress, dt)
        else:
            side = self._landed = OTHER[support.support]
            self._passed = 0.0
            self._legs[side].swing(
                forces[SIDES.index(side)],
                dt,
                progress=support.progress,
                ankle_z=plan.foot(side).z + self._foot_height - plan.hip_height,
                search_depth=support.search_depth,
                delay=delay,
            )
        return self._legs["L"].offset, self._legs["R"].offset

    def _exchange(self, progress: float, dt: float) -> None:
        """Both legs change alike until the coming stance leg is as long as planned at the end of the phase."""
        passed = max(smoothstep(progress), self._passed)
        left = 1.0 - self._passed
        share = (passed - self._passed) / left if left > 0.0 else 1.0
        step = self._p.max_rate * dt
        by = clip(-self._legs[self._landed].offset * share, -step, step)
        self._passed = passed
        for leg in self._legs.values():
            leg.shift(by)
