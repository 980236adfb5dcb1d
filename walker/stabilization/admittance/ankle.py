"""Admittance of the ankle (thesis 4.1.2): the swing foot turns until its sole lies on the ground it meets.

M e'' + D e' + K e = tau (4.9) for roll and pitch each, tau from the four force sensors (4.6). It acts on the
swing leg only; the foot stands with the offset with which it landed, and swings on from it.

Departure from the thesis: (4.11) is explicit Euler; its velocity pole 1 - D T_s / M is -0.129 in roll, so
near the border that the printed damping allows no cycle longer than 17.7 ms. The equation is linear, so here
it is solved exactly for a moment held over the cycle (zero-order hold): stable for every cycle time.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import NamedTuple

import msgspec
import numpy as np

from bridge.body import Body
from bridge.types import Fraction, NotNegative, Positive, Side, Vec3
from walker.estimation.support_state import Role
from walker.functions import clip


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
        """Roll and pitch with which the foot stands, or last stood, rad."""
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
        # At a limit the foot stands still: it must not have to run down a stored velocity to come back.
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
    """Dead zone: how far `value` lies outside -band..band."""
    return value - clip(value, -band, band)
