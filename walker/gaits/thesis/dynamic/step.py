"""Closed forms of the dynamically stable gait (thesis 3.3.2, after Zhu et al. 2005): step and beginning.

In single support the centre of mass is an inverted pendulum of constant height over the ZMP at the middle of
the stance foot (3.8); in double support it moves at constant velocity, so that it is its own ZMP. The state
in which a phase begins is known relative to the stance foot, so nothing is integrated and no rounding error
can grow with the pendulum's unstable mode.

The thesis leaves open how the gait begins ("the mass is led from O_W to A"). At A the pendulum is over the
stance foot's line with the velocity V_11 forwards: a mass that starts from rest above that line must swing
back before it moves forward. One quintic in each coordinate matches position, velocity *and* acceleration at
both ends, so the ZMP moves without a jump from the middle between the feet into that of the stance foot. The
way from D to rest is the same motion backwards in time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.polynomial import Polynomial

from bridge.types import Positive
from walker.functions import LinearPendulum, MotionState
from walker.gaits.gait import GaitParameters, PeriodicStep


class DynamicParameters(GaitParameters, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the dynamically stable gait; symbols of the thesis (3.3.2, figure 3.5), SI units.

    The times of the phases follow from the sideways motion alone (3.11), so the length of a step, S_a + S_b +
    S_d, is proportional to S_a0.
    """

    LENGTH: ClassVar = "S_a0"

    e_s1: Positive
    """Distance of the centre of mass from the x axis at A and D, where its sideways motion turns round, m."""
    e_su: Positive
    """The same at B, C, E, ... (u = 2, 3, 5, 6, ...), where double support begins and ends, m."""
    S_a0: Positive
    """Way of the centre of mass along x in an acceleration phase, m."""
    z: Positive
    """Height of the centre of mass above the ground, m."""
    l_FA: Positive
    """Step width: distance of the ankles along y, m; d_0 = l_FA / 2."""
    l_GH: Positive
    """Gait height: ankle to hip joint along z, m. Must fit `z`: it is the leg that holds the mass there."""
    l_lift: Positive
    """Lift of the swing foot at the middle of the single support, m."""
    T_start: Positive
    """Duration of the motion from rest to A, and from D to rest, s."""
    mu: Positive
    """Coefficient of static friction between sole and ground (3.9)."""
    first_swing: Literal["L", "R"] = "L"
    """The foot that makes the first step."""

    @property
    def d_0(self) -> float:
        """Distance of either foot's middle from the x axis, m."""
        return 0.5 * self.l_FA

    @property
    def periodic_step(self) -> PeriodicStep:
        """From one double support to the next."""
        plan = plan_step(self)
        return PeriodicStep(plan.length, plan.duration)


@dataclass(frozen=True, slots=True)
class StepPlan:
    """The periodic step that a parameter set means; names as in (3.7)-(3.15), SI units.

    All e_su (u > 1) being equal, the mass turns round at D at the distance e_s4 = e_s1 where it did at A (the
    orbital energy y'^2 - nu^2 y^2 is the same before and after), so deceleration mirrors acceleration:
    t_d = t_a, S_d = S_a0, V_11 the velocity at A, and every later step equals the first.
    """

    pendulum: LinearPendulum
    turn: float
    """d_0 - e_s1: distance of the mass from the stance foot's middle along y at A and D, m."""
    t_a: float
    """Duration of an acceleration or deceleration phase, s."""
    V_ya: float
    """Velocity along y in double support, m/s."""
    V_h: float
    """Velocity along x in double support, m/s."""
    V_1: float
    """Velocity along x at A and D, m/s (V_11)."""
    T_DSP: float
    """Duration of the double support, s."""
    S_a: float
    """Way along x in the acceleration and in the deceleration phase (S_d), m."""
    S_b: float
    """Way along x in double support, m."""
    e_su: float
    """Distance of the centre of mass from the x axis where double support begins and ends, m."""

    @property
    def length(self) -> float:
        """Distance along x from one foothold to the next, m."""
        return 2.0 * self.S_a + self.S_b

    @property
    def duration(self) -> float:
        """One step: double support, deceleration, acceleration, s."""
        return 2.0 * self.t_a + self.T_DSP

    def single_support(self, tau: float, side: float) -> tuple[MotionState, MotionState]:
        """Centre of mass relative to the stance foot's middle, x and y (3.13), (3.15).

        Args:
            tau: time since D (or A), s: from -t_a to 0 deceleration, from 0 to t_a acceleration.
            side: +1 on the left foot, -1 on the right.
        """
        return (
            self.pendulum.motion(tau, 0.0, self.V_1),
            self.pendulum.motion(tau, -side * self.turn, 0.0),
        )

    def double_support(self, t: float, side: float) -> tuple[MotionState, MotionState]:
        """Centre of mass, x relative to the middle of the next foot, y to the x axis (assumption 2).

        Args:
            t: time since touch-down, s.
            side: +1 when the left foot takes over, -1 when the right does.
        """
        return (
            MotionState(self.V_h * (t - self.T_DSP) - self.S_a, self.V_h, 0.0),
            MotionState(side * (self.V_ya * t - self.e_su), side * self.V_ya, 0.0),
        )


def plan_step(p: DynamicParameters) -> StepPlan:
    """The periodic step of a parameter set with 0 < e_su < e_s1 < d_0.

    From A (x = 0, y' = 0) the solution (3.10) is x = V_11 / nu sinh(nu t), y = -(d_0 - e_s1) cosh(nu t); it
    reaches B where y = -(d_0 - e_su) and x = S_a0, which gives t_a, V_11, V_h0 and V_ya0; crossing 2 e_su at
    V_ya0 gives T_DSP and S_b.
    """
    pendulum = LinearPendulum(p.z)
    nu = pendulum.nu
    turn = p.d_0 - p.e_s1
    cosh = (p.d_0 - p.e_su) / turn
    sinh = math.sqrt(cosh**2 - 1.0)
    v_ya, v_1 = nu * turn * sinh, nu * p.S_a0 / sinh
    t_dsp = 2.0 * p.e_su / v_ya
    return StepPlan(
        pendulum=pendulum,
        turn=turn,
        t_a=math.acosh(cosh) / nu,
        V_ya=v_ya,
        V_h=v_1 * cosh,
        V_1=v_1,
        T_DSP=t_dsp,
        S_a=p.S_a0,
        S_b=v_1 * cosh * t_dsp,
        e_su=p.e_su,
    )


class Transfer:
    """Motion of the centre of mass, x relative to the feet's middles, y to the x axis, left foot next.

    Args:
        plan: of the next step.
        e_s1: distance from the x axis at A, m.
        duration: s.
    """

    def __init__(self, plan: StepPlan, e_s1: float, duration: float) -> None:
        self.duration = duration
        self._nu = plan.pendulum.nu
        self.x = _from_rest(MotionState(0.0, plan.V_1, 0.0), duration)
        self.y = _from_rest(MotionState(e_s1, 0.0, -(plan.pendulum.nu**2) * plan.turn), duration)
        self._derivatives = [(p, p.deriv(), p.deriv(2)) for p in (self.x, self.y)]

    def start(self, t: float, side: float) -> tuple[MotionState, MotionState]:
        """`t` seconds after rest; `side` +1 towards the left foot, -1 towards the right."""
        x, y = (MotionState(*(float(p(t)) for p in parts)) for parts in self._derivatives)
        return x, MotionState(*(side * value for value in y))

    def stop(self, t: float, side: float) -> tuple[MotionState, MotionState]:
        """`t` seconds after D, x mirrored too: forwards beyond the feet's middles and back to them."""
        return tuple(  # type: ignore[return-value]
            MotionState(sign * m.position, -sign * m.velocity, sign * m.acceleration)
            for sign, m in zip((-1.0, 1.0), self.start(self.duration - t, side), strict=True)
        )

    def furthest(self, normal_x: float, normal_y: float) -> float:
        """Largest value over the motion of the ZMP's coordinate along a direction (3.4), exact."""
        along = normal_x * self.x + normal_y * self.y
        return _maximum(along - along.deriv(2) / self._nu**2, self.duration)

    def acceleration(self) -> float:
        """Largest magnitude of the acceleration over the motion, m/s^2, exact."""
        square = self.x.deriv(2) ** 2 + self.y.deriv(2) ** 2
        return float(np.sqrt(_maximum(square, self.duration)))


def _from_rest(end: MotionState, duration: float) -> Polynomial:
    """Fifth-degree polynomial from rest at 0 to a full state (3.6)."""
    p, v, a = end.position, end.velocity * duration, end.acceleration * duration**2
    unit = np.array([0.0, 0.0, 0.0, 10 * p - 4 * v + a / 2, -15 * p + 7 * v - a, 6 * p - 3 * v + a / 2])
    return Polynomial(unit / duration ** np.arange(6))


def _maximum(polynomial: Polynomial, duration: float) -> float:
    """Largest value on [0, duration]: at an end or where the slope vanishes (complex roots do no harm)."""
    candidates = np.clip(polynomial.deriv().roots().real, 0.0, duration)
    return float(max(polynomial(np.concatenate(([0.0, duration], candidates)))))
