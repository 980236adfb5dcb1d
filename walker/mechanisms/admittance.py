"""Admittance of the swing leg and its ankle (thesis 4.1): the foot yields to the ground at touch-down.

Reads: plan, roles of the legs, force sensors, delay of the loop.
Gives: height of both feet over the plan (`LegAdmittances`), turn of each sole (`AnkleAdmittance`).

Admittance of the legs along z (thesis 4.1.1): the swing foot stops at the ground.

D e' = F_ext - F_d(e) (4.1) with the spring F_d(e) = k_c tan((e + k_b) / (2 pi k_a)) + k_d (4.4) acts on the
swing leg only. The end of its offset follows from 3.1: during a double support the height difference of
the feet l_HD is constant, and the leg that becomes the stance leg then has the length l_GH. So over a double
support the offset of the foot that landed passes to the other leg, with the opposite sign, and the body rises
onto the ground that the foot found.

Departures from the thesis: (4.3) is explicit Euler, which overshoots the pole of the tangent; here the step is
implicit, e_{k+1} = e_k + T_s / D (F_k - F_d(e_{k+1})), whose one solution is inside the pole for every
force. A force tolerance keeps sensor noise from lifting the foot: the spring is so soft near zero (24 N/m)
that 0.2 N held for long would lift it 8 mm.

Admittance of the ankle (thesis 4.1.2): the swing foot turns until its sole is flat on the ground.

M e'' + D e' + K e = tau (4.9) for roll and pitch each, tau from the four force sensors (4.6). It acts on the
swing leg only; the stance foot keeps the offset with which it landed, and swings on from it.

Departure from the thesis: (4.11) is explicit Euler; its velocity pole 1 - D T_s / M is -0.129 in roll, so
near the border that the printed damping allows no cycle longer than 17.7 ms. The equation is linear, so here
it is solved exactly for a moment held over the cycle (zero-order hold): stable for every cycle time.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import msgspec
import numpy as np

from bridge.body import Body
from bridge.types import SIDES, Fraction, NotNegative, Positive, Side, Vec2, Vec3
from walker.estimation.contact import Role, SupportState
from walker.functions import brent, clip, smoothstep
from walker.gaits.plan import OTHER_SIDE, Plan

_POLE_FRACTION = 1.0 - 1e-9
"""Bound of e, as a fraction of the way to the pole; there the spring pulls with 3e8 N."""


class LegParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the leg admittance; symbols of the thesis (4.4), SI units."""

    k_a: Positive = 1.0 / 300.0
    """m: the pole of the spring is at |e + k_b| = pi^2 k_a, 32.9 mm."""
    k_b: float = 0.0
    """Offset in the spring's argument, m."""
    k_c: Positive = 0.5
    """Force scale of the spring, N."""
    k_d: float = 0.0
    """Offset of the spring's force, N."""
    D: Positive = 280.0
    """Damping, N s/m; not given in the thesis. By 4.1.1 the first contact loads the foot with about 70 N, and e
    stays small. Chosen: 70 N for two cycles (20 ms) move e by at most 5 mm, the target's depth: D = 70 N
    20 ms / 5 mm. A contact of the stiffness k makes e' = -k e / D, delayed by servo and sampling by T = 50 ms:
    stable for k < pi D / (2 T) = 8.8 kN/m.
    """
    latency: Positive = 0.05
    """T of servo and sampling, s. In a loop that is late by d besides, the damping D (T + d) / T, which is
    used, has the margin of D in one that is not."""
    force_tolerance: NotNegative = 0.5
    """Sum of the foot's sensor forces that does not count, N."""
    start: Fraction = 0.5
    """Fraction of the swing from which the force counts (not given in the thesis): before that the foot may
    still be leaving the ground, and the load it takes with it would shorten the leg for the whole step."""
    target_depth: NotNegative = 0.005
    """Depth of the swing foot's target below the nominal ground, m, to step into depressions too."""
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
        self.e = clip(self.offset + by, -p.pole * _POLE_FRACTION - p.k_b, p.pole * _POLE_FRACTION - p.k_b)
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
            search_depth: further depth of the target of a late swing foot, m.
            delay: of the loop, besides `latency`, s.

        Returns:
            e - depth: offset of the planned height of the foot, m, up positive. It changes by at most
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

        lowest, highest = -p.pole * _POLE_FRACTION - p.k_b, p.pole * _POLE_FRACTION - p.k_b
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
            Offsets of the planned heights of both feet, m, up positive.
        """
        if support.support == "both":
            self._exchange(plan.progress, dt)
        else:
            side = self._landed = OTHER_SIDE[support.support]
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
        """Both legs change alike until the next stance leg is as long as planned at the end of the phase."""
        passed = max(smoothstep(progress), self._passed)
        remaining = 1.0 - self._passed
        share = (passed - self._passed) / remaining if remaining > 0.0 else 1.0
        step = self._p.max_rate * dt
        by = clip(-self._legs[self._landed].offset * share, -step, step)
        self._passed = passed
        for leg in self._legs.values():
            leg.shift(by)


class AnkleParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the ankle admittance; values of the thesis after (4.11), in units of rotation."""

    M_roll: Positive = 0.0031
    """kg m^2"""
    M_pitch: Positive = 0.0031
    """kg m^2"""
    D_roll: Positive = 0.35
    """N m s/rad"""
    D_pitch: Positive = 0.17525
    """N m s/rad"""
    K_roll: NotNegative = 0.0667
    """N m/rad"""
    K_pitch: NotNegative = 0.071
    """N m/rad"""
    relative_force_tolerance: NotNegative = 0.2
    """Sensor tolerance: fraction of its reading by which each cell may be off."""
    force_tolerance: NotNegative = 0.1
    """Sensor tolerance: force by which each cell may be off, N."""
    start: Fraction = 0.0
    """Fraction of the swing from which (4.9) runs (not given in the thesis)."""
    max_rate: Positive = 2.0
    """Largest speed of the offsets, rad/s."""


class AnkleLimits(NamedTuple):
    """Offsets that the joints still allow: their ranges less the planned angles, rad; lower <= upper."""

    roll_lower: float
    roll_upper: float
    pitch_lower: float
    pitch_upper: float


def sole_moment(forces: Sequence[float], places: Sequence[Vec3]) -> tuple[float, float]:
    """Moment of sole-normal forces about the ankle, roll and pitch, N m (4.6, with the sign of 4.6b put right).

    r x F with F along +z: a force at +y turns about +x (roll), a force at +x turns about -y (pitch, positive:
    toe down), that is, ground under the toe lifts the toe.

    Args:
        forces: of the cells, N.
        places: of the cells in the AnkleRoll frame, m, in the same order.
    """
    cells = list(zip(forces, places, strict=True))
    return sum(f * y for f, (_, y, _) in cells), -sum(f * x for f, (x, _, _) in cells)


class AnkleAdmittance:
    """Offsets of one foot's roll and pitch from its plan.

    Args:
        parameters: of the admittance.
        body: gives the places of the force sensors.
        side: of the foot.
    """

    def __init__(self, parameters: AnkleParameters, body: Body, side: Side) -> None:
        p = self._p = parameters
        self._places = body.fsr.L if side == "L" else body.fsr.R
        self._roll = _Axis(p.M_roll, p.D_roll, p.K_roll, p.max_rate, body.cycle)
        self._pitch = _Axis(p.M_pitch, p.D_pitch, p.K_pitch, p.max_rate, body.cycle)

    def update(
        self, fsr: Sequence[float], role: Role, dt: float, limits: AnkleLimits, *, progress: float = 1.0
    ) -> tuple[float, float]:
        """One cycle.

        Args:
            fsr: FL, FR, RL, RR of this foot, N.
            role: of this leg.
            dt: cycle time, s.
            limits: of the offsets in this cycle; they bind in every state.
            progress: fraction of the swing that has passed, 0..1; without meaning in stance.

        Returns:
            Roll and pitch of the sole to add to the plan, rad, right-handed (pitch positive: toe down). They
            change by at most `max_rate` dt per cycle, except where the limits force them.
        """
        roll, pitch = self.moment(fsr)
        free = role == "swing" and progress >= self._p.start
        return (
            self._roll.update(roll, dt, limits.roll_lower, limits.roll_upper, free=free),
            self._pitch.update(pitch, dt, limits.pitch_lower, limits.pitch_upper, free=free),
        )

    @property
    def held(self) -> tuple[float, float]:
        """Roll and pitch that the stance foot holds, or held last, rad."""
        return self._roll.held, self._pitch.held

    def reduce(self, roll: float, pitch: float) -> None:
        """Subtract from both offsets, also from those held: another block turns the foot by these angles now.

        Args:
            roll: rad.
            pitch: rad.
        """
        self._roll.reduce(roll)
        self._pitch.reduce(pitch)

    def moment(self, fsr: Sequence[float]) -> tuple[float, float]:
        """Moment that is more than the cells could report between them without a tilt, roll and pitch, N m."""
        p = self._p
        roll, pitch = sole_moment(fsr, self._places)
        off = [p.relative_force_tolerance * abs(f) + p.force_tolerance for f in fsr]
        return (
            _beyond(roll, sum(o * abs(y) for o, (_, y, _) in zip(off, self._places, strict=True))),
            _beyond(pitch, sum(o * abs(x) for o, (x, _, _) in zip(off, self._places, strict=True))),
        )


class _Axis:
    """(4.9) about one axis while the foot is free; held otherwise."""

    def __init__(self, M: float, D: float, K: float, max_rate: float, cycle: float) -> None:
        self._system = (M, D, K)
        zero_order_hold(M, D, K, cycle)  # loads SciPy, which takes longer than a cycle
        self._max_rate = max_rate
        self._angle = 0.0
        self._velocity = 0.0
        self.held = 0.0

    def reduce(self, by: float) -> None:
        """Subtract an angle from the offset and from the one held, rad."""
        self._angle -= by
        self.held -= by

    def update(self, moment: float, dt: float, lower: float, upper: float, *, free: bool) -> float:
        """The offset of the next cycle, rad: led by (4.9) while the foot is free, else held.

        Args:
            moment: About this axis, N m.
            dt: Cycle time, s.
            lower: Limit of the offset, rad.
            upper: Limit of the offset, rad.
            free: The foot swings.
        """
        if not free:
            wanted, velocity = self._angle, 0.0
            self.held = wanted
        else:
            (aa, av, ab), (va, vv, vb) = zero_order_hold(*self._system, dt)
            wanted = aa * self._angle + av * self._velocity + ab * moment
            velocity = va * self._angle + vv * self._velocity + vb * moment
        step = self._max_rate * dt
        angle = self._angle + clip(wanted - self._angle, -step, step)
        self._angle = clip(angle, lower, upper)
        # At a limit the foot rests: no stored velocity delays its return.
        self._velocity = clip(velocity, -self._max_rate, self._max_rate) if self._angle == angle else 0.0
        return self._angle


@functools.lru_cache(maxsize=16)
def zero_order_hold(
    M: float, D: float, K: float, dt: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Rows (from angle, from velocity, from moment) of the exact step of M e'' + D e' + K e = tau.

    Args:
        M: inertia, kg m^2.
        D: damping, N m s/rad.
        K: stiffness, N m/rad.
        dt: cycle time, s.
    """
    from scipy.linalg import expm

    rates = np.array([[0.0, 1.0, 0.0], [-K / M, -D / M, 1.0 / M], [0.0, 0.0, 0.0]])
    (a, v, _) = expm(rates * dt).tolist()
    return tuple(a), tuple(v)


def _beyond(value: float, band: float) -> float:
    """Dead zone: distance of `value` outside -band..band, signed."""
    return value - clip(value, -band, band)
