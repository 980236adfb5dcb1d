"""The statically stable gait of the thesis (3.3.1): the ZMP follows the centre of mass.

In double support the centre of mass moves on quintics (3.6) from one foot's middle to the other's; in single
support it rests over the middle of the stance foot while the swing foot moves on a quintic in x and a cubic
spline in z. Order of phases: DSL - SSL - DSR - SSR.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import msgspec

from bridge.datasheet import Body
from bridge.errors import ConfigurationError
from walker.gait.polynomial import lift_spline, quintic
from walker.gait.reference import Foot, Phase, Reference
from walker.gravity import GRAVITY

_Positive = Annotated[float, msgspec.Meta(gt=0.0)]
_EPSILON = 1e-9
"""s; phases end on cycle boundaries in spite of rounding."""


class StaticParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the statically stable gait; symbols of the thesis, SI units."""

    T_DSP: _Positive
    """Double support phase, s."""
    T_SSP: _Positive
    """Single support phase, s."""
    l_SW: _Positive
    """Step length: distance of the feet along x in double support, m."""
    l_FA: _Positive
    """Step width: distance of the ankles along y, m."""
    l_lift: _Positive
    """Lift of the swing foot at the middle of the single support, m."""
    l_GH: _Positive
    """Gait height: ankle to hip joint along z, m."""
    first_swing: Literal["L", "R"] = "R"
    """The foot that makes the first step."""


class StaticGait:
    """Phase machine of the statically stable gait.

    Args:
        parameters: of the gait.
        body: gives the middle and the outline of the sole, and the lengths.

    Raises:
        ConfigurationError: a weight shift so fast that the neglected acceleration term breaks the margin
            condition (3.5).
    """

    name = "static"
    quasi_static = True

    def __init__(self, parameters: StaticParameters, body: Body) -> None:
        self._p = parameters
        self._centre = body.foot.centre
        self._hip_height = parameters.l_GH + body.lengths.FootHeight
        self._check_margin(body)
        half = 0.5 * parameters.l_FA
        self._left = Foot(0.0, half)
        self._right = Foot(0.0, -half)
        self._com = self._middle()
        self._swing = parameters.first_swing
        self._step = 0
        self._phase: Phase = "stand"
        self._t = 0.0
        self._from = self._to = self._com

    def set_step_length(self, length: float) -> None:
        """Length l_SW of the steps from the next one on, m; see `AdjustableGait`."""
        self._p = msgspec.structs.replace(self._p, l_SW=length)

    def stand(self) -> Reference:
        """The plan at rest where the gait is now."""
        return self._reference(self._left, self._right, self._com, 0.0)

    def advance(self, dt: float, *, go_on: bool) -> Reference:
        """The plan `dt` seconds later; see `Gait.advance`."""
        if self._phase == "stand":
            if not go_on:
                return self.stand()
            self._begin_double_support(go_on=True)
        self._t += dt
        while self._phase != "stand" and self._t >= self._duration() - _EPSILON:
            self._t = max(self._t - self._duration(), 0.0)
            self._next_phase(go_on=go_on)
        if self._phase == "stand":
            self._t = 0.0
            return self.stand()
        return self._evaluate()

    def _duration(self) -> float:
        return self._p.T_SSP if self._phase in ("SSL", "SSR") else self._p.T_DSP

    def _next_phase(self, *, go_on: bool) -> None:
        if self._phase in ("DSL", "DSR"):
            self._com = self._to
            self._phase = "SSL" if self._phase == "DSL" else "SSR"
            self._target = self._landing(go_on=go_on)
        elif self._phase in ("SSL", "SSR"):
            if self._swing == "L":
                self._left = self._target
            else:
                self._right = self._target
            self._step += 1
            self._swing = "L" if self._swing == "R" else "R"
            self._begin_double_support(go_on=go_on or self._left.x != self._right.x)
        else:
            self._com = self._to
            self._phase = "stand"

    def _begin_double_support(self, *, go_on: bool) -> None:
        """Shift the weight onto the next stance foot, or to the middle at the end of the walk."""
        self._from = self._com
        if go_on:
            self._phase = "DSL" if self._swing == "R" else "DSR"
            self._to = self._foot_centre("L" if self._swing == "R" else "R")
        else:
            self._phase = "stop"
            self._to = self._middle()

    def _landing(self, *, go_on: bool) -> Foot:
        """Where the swing foot comes down: one step length ahead of the stance foot, or beside it to stop."""
        stance = self._left if self._swing == "R" else self._right
        swing = self._right if self._swing == "R" else self._left
        return Foot(stance.x + (self._p.l_SW if go_on else 0.0), swing.y)

    def _evaluate(self) -> Reference:
        t = self._t
        progress = t / self._duration()
        if self._phase in ("SSL", "SSR"):
            start = self._right if self._swing == "R" else self._left
            foot = Foot(
                quintic(start.x, self._target.x, self._p.T_SSP, t).position,
                start.y,
                lift_spline(start.z, self._p.l_lift, self._target.z, self._p.T_SSP, t).position,
            )
            left, right = (foot, self._right) if self._swing == "L" else (self._left, foot)
            return self._reference(left, right, self._com, progress)
        com = (
            quintic(self._from[0], self._to[0], self._p.T_DSP, t).position,
            quintic(self._from[1], self._to[1], self._p.T_DSP, t).position,
        )
        return self._reference(self._left, self._right, com, progress)

    def _reference(self, left: Foot, right: Foot, com: tuple[float, float], progress: float) -> Reference:
        return Reference(
            phase=self._phase,
            support={"SSL": "L", "SSR": "R"}.get(self._phase, "both"),  # type: ignore[arg-type]
            progress=progress,
            step=self._step,
            left=left,
            right=right,
            com=com,
            zmp=com,
            hip_height=self._hip_height,
        )

    def _foot_centre(self, side: str) -> tuple[float, float]:
        if side == "L":
            return self._left.x + self._centre[0], self._left.y + self._centre[1]
        return self._right.x + self._centre[0], self._right.y - self._centre[1]

    def _middle(self) -> tuple[float, float]:
        (xl, yl), (xr, yr) = self._foot_centre("L"), self._foot_centre("R")
        return 0.5 * (xl + xr), 0.5 * (yl + yr)

    def _check_margin(self, body: Body) -> None:
        """Condition (3.5): the acceleration term stays below the distance to the border of the sole."""
        p = self._p
        height = self._hip_height + body.lengths.HipOffsetZ  # upper bound of the centre of mass, torso origin
        peak = 10.0 / math.sqrt(3.0)  # largest acceleration of the unit quintic over a unit time
        xs = [x for x, _ in body.foot.sole]
        ys = [y for _, y in body.foot.sole]
        for what, way, margin in (
            ("x", p.l_SW, min(max(xs) - self._centre[0], self._centre[0] - min(xs))),
            ("y", p.l_FA + 2.0 * self._centre[1], min(max(ys) - self._centre[1], self._centre[1] - min(ys))),
        ):
            term = peak * way / p.T_DSP**2 * height / GRAVITY
            if term >= margin:
                raise ConfigurationError(
                    f"static gait: T_DSP = {p.T_DSP} s moves the ZMP {1e3 * term:.0f} mm off the centre of "
                    f"mass along {what}, more than the sole's margin of {1e3 * margin:.0f} mm (3.5); T_DSP "
                    f"must be longer than {math.sqrt(peak * way * height / GRAVITY / margin):.2f} s."
                )
