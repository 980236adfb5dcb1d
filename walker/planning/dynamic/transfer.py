"""From rest to the moving state in which the dynamic gait begins, and back: both feet side by side.

The thesis leaves this open ("the mass is led from O_W to A"). At A the pendulum stands over the stance foot's
line with the velocity V_11 forwards: a mass that starts from rest above that very line must swing back before
it comes forward. One quintic in each coordinate meets position, velocity *and* acceleration at both ends, so
the ZMP moves without a jump from the middle between the feet into the middle of the stance foot. The way from
D to rest is the same motion backwards in time.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial

from walker.functions import MotionState
from walker.planning.dynamic.step import StepPlan


class Transfer:
    """Motion of the centre of mass, x relative to the feet's middles, y to the x axis, left foot next.

    Args:
        plan: of the step to come.
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
