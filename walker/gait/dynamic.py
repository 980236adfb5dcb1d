"""The dynamically stable gait of the thesis (3.3.2): an inverted pendulum that falls from foot to foot.

Order of phases, beginning on the right foot: start (from rest to A), SSR (acceleration only), DSL, SSL, DSR,
SSR, ..., and at the end a single support that only decelerates to D while the swing foot comes down beside
the stance foot, then stop (from D to rest). Phases do not end on cycle boundaries (the double support lasts
four cycles); the remainder is carried over, and every phase is evaluated at its exact time. Position and
velocity of the centre of mass are continuous throughout. Its acceleration, and with it the ZMP, jumps by
design where double support begins and ends: from the stance foot's middle to the point below the mass and on
to the next foot's middle.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator

from bridge.datasheet import Body
from walker.gait.admissible import check_balance, check_distances, check_legs
from walker.gait.pendulum import DynamicParameters, plan_step
from walker.gait.polynomial import Motion, lift_spline, quintic
from walker.gait.reference import Foot, Phase, Reference, Support
from walker.gait.transfer import Transfer

_SIDE = {"L": 1.0, "R": -1.0}
_OTHER = {"L": "R", "R": "L"}
_TRIAL = 0.005
"""s; sampling of the walk in which the reach of the legs is checked."""


class DynamicGait:
    """Phase machine of the dynamically stable gait.

    The planned ZMP of single support rests at the sole's middle along x and on the ankle's line along y
    (d_0 = l_FA / 2 as in the thesis, a few millimetres inside the sole's middle).

    Args:
        parameters: of the gait.
        body: gives the soles, the leg lengths and the foot height.

    Raises:
        ConfigurationError: a parameter set that the body cannot walk; names the violated bound.
    """

    name = "dynamic"
    quasi_static = False

    def __init__(self, parameters: DynamicParameters, body: Body) -> None:
        check_distances(parameters)
        self._p = parameters
        self.plan = plan_step(parameters)
        """The periodic step."""
        self._transfer = Transfer(self.plan, parameters.e_s1, parameters.T_start)
        check_balance(parameters, self.plan, self._transfer, body)
        self._centre_x = body.foot.centre[0]
        self._hip_height = parameters.l_GH + body.lengths.FootHeight
        self._left = Foot(0.0, parameters.d_0)
        self._right = Foot(0.0, -parameters.d_0)
        self._landing = self._left
        self._stance = _OTHER[parameters.first_swing]
        self._tau = (
            0.0,
            0.0,
        )  # of the single support under way: where on the pendulum's orbit it begins and ends
        self._phase: Phase = "stand"
        self._step = 0
        self._t = 0.0
        self.com_motion = self._com()
        """Position, velocity and acceleration of the planned centre of mass, x and y, of the last plan."""
        check_legs(parameters, body, self._trial())

    def stand(self) -> Reference:
        """The plan at rest where the gait is now."""
        return self._evaluate()

    def advance(self, dt: float, *, go_on: bool) -> Reference:
        """The plan `dt` seconds later; see `Gait.advance`.

        Whether another step follows is decided when a foot lifts. Told to stop on the way from rest to A, the
        gait returns to rest without a step.
        """
        if self._phase == "stand":
            if not go_on:
                return self.stand()
            self._begin()
        self._t += dt
        while self._phase != "stand" and self._t >= self._duration():
            self._t -= self._duration()
            self._next_phase(go_on=go_on)
        if self._phase == "stand":
            self._t = 0.0
        return self._evaluate()

    def _begin(self) -> None:
        self._stance = _OTHER[self._p.first_swing]
        self._phase = "start"

    def _duration(self) -> float:
        if self._phase in ("SSL", "SSR"):
            return self._tau[1] - self._tau[0]
        return self.plan.T_DSP if self._phase in ("DSL", "DSR") else self._p.T_start

    def _next_phase(self, *, go_on: bool) -> None:
        t_a = self.plan.t_a
        if self._phase == "start":
            if go_on:
                self._lift(0.0, t_a)
            else:
                self._phase = "stop"
        elif self._phase in ("DSL", "DSR"):
            self._lift(-t_a, t_a if go_on else 0.0)
        elif self._phase in ("SSL", "SSR"):
            self._put_down()
        else:
            self._phase = "stand"

    def _lift(self, begin: float, end: float) -> None:
        """Single support on the stance foot, over a part of the orbit; up to D only, the feet come together."""
        self._tau = (begin, end)
        self._phase = "SSL" if self._stance == "L" else "SSR"
        stance, swing = self._foot(self._stance), self._foot(_OTHER[self._stance])
        self._landing = Foot(stance.x + (self.plan.length if end > 0.0 else 0.0), swing.y)

    def _put_down(self) -> None:
        if self._stance == "R":
            self._left = self._landing
        else:
            self._right = self._landing
        self._step += 1
        if self._tau[1] > 0.0:
            self._stance = _OTHER[self._stance]
            self._phase = "DSL" if self._stance == "L" else "DSR"
        else:
            self._phase = "stop"

    def _evaluate(self) -> Reference:
        self.com_motion = x, y = self._com()
        left, right = self._left, self._right
        support: Support = "both"
        if self._phase == "SSR":
            left, support = self._swing(left), "R"
        elif self._phase == "SSL":
            right, support = self._swing(right), "L"
        nu2 = self.plan.nu**2
        return Reference(
            phase=self._phase,
            support=support,
            progress=0.0 if self._phase == "stand" else self._t / self._duration(),
            step=self._step,
            left=left,
            right=right,
            com=(x.position, y.position),
            zmp=(x.position - x.acceleration / nu2, y.position - y.acceleration / nu2),
            hip_height=self._hip_height,
        )

    def _com(self) -> tuple[Motion, Motion]:
        side = _SIDE[self._stance]
        stance = self._foot(self._stance)
        across = 0.0
        if self._phase == "start":
            x, y = self._transfer.start(self._t, side)
        elif self._phase == "stop":
            x, y = self._transfer.stop(self._t, side)
        elif self._phase in ("SSL", "SSR"):
            x, y = self.plan.single_support(self._tau[0] + self._t, side)
            across = stance.y
        elif self._phase in ("DSL", "DSR"):
            x, y = self.plan.double_support(self._t, side)
        else:
            x = y = Motion(0.0, 0.0, 0.0)
        return _shift(x, stance.x + self._centre_x), _shift(y, across)

    def _swing(self, start: Foot) -> Foot:
        """Quintic along x, so that the foot is at rest when it lands, cubic spline along z (3.3.1)."""
        duration = self._duration()
        return Foot(
            quintic(start.x, self._landing.x, duration, self._t).position,
            start.y,
            lift_spline(start.z, self._p.l_lift, self._landing.z, duration, self._t).position,
        )

    def _foot(self, name: str) -> Foot:
        return self._left if name == "L" else self._right

    def _trial(self) -> Iterator[Reference]:
        """A walk with a first, a periodic and a closing step, sampled, on a copy of this gait."""
        gait = copy.copy(self)
        plan = gait.advance(0.0, go_on=True)
        while plan.phase != "stand":
            yield plan
            plan = gait.advance(_TRIAL, go_on=plan.step < 2)


def _shift(motion: Motion, by: float) -> Motion:
    return motion._replace(position=motion.position + by)
