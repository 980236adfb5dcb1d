"""The statically stable gait of the thesis (3.3.1): the ZMP follows the centre of mass.

In double support the centre of mass moves on quintics (3.6) from one foot's middle to the other's; in single
support it rests over the middle of the stance foot while the swing foot moves on a quintic in x and a cubic
spline in z. Order of phases: DSL - SSL - DSR - SSR.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Final, Literal

from bridge.body import Body
from bridge.body.quantities import GRAVITY
from bridge.errors import ConfigurationError
from bridge.types import Positive, Side, Vec2
from walker.functions import lift_spline, quintic
from walker.gaits.gait import GaitCommand, GaitParameters, PeriodicStep
from walker.gaits.plan import OTHER_SIDE, Phase, Plan, SolePose, Support


class StaticParameters(GaitParameters, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Symbols of the thesis, SI units."""

    LENGTH: ClassVar = "l_SW"

    T_DSP: Positive
    """Double support phase, s."""
    T_SSP: Positive
    """Single support phase, s."""
    l_SW: Positive
    """Step length: distance of the feet along x in double support, m."""
    l_FA: Positive
    """Step width: distance of the ankles along y, m."""
    l_lift: Positive
    """Lift of the swing foot at the middle of the single support, m."""
    l_GH: Positive
    """Gait height: ankle to hip joint along z, m."""
    first_swing: Literal["L", "R"] = "R"
    """The foot that makes the first step."""

    @property
    def periodic_step(self) -> PeriodicStep:
        """One double and one single support."""
        return PeriodicStep(self.l_SW, self.T_DSP + self.T_SSP)


_EPSILON: Final = 1e-9
"""s; phases end on cycle boundaries in spite of rounding."""
_SUPPORT: Final[dict[Phase, Support]] = {"SSL": "L", "SSR": "R"}


@dataclass(frozen=True, slots=True)
class StaticState:
    """State of the gait, in the walk frame, m and s."""

    left: SolePose
    """Pose of the left sole, or its last one before the swing under way."""
    right: SolePose
    swing: Side
    """The foot of the swing under way, or of the next one."""
    com: Vec2
    """Centre of mass at the beginning of the phase."""
    com_end: Vec2
    """Centre of mass at the end of a double support."""
    landing: SolePose
    """Pose at the end of the swing under way."""
    phase: Phase = "stand"
    t: float = 0.0
    """Since the beginning of the phase."""
    step: int = 0

    def foot(self, side: Side) -> SolePose:
        """One of the soles."""
        return self.left if side == "L" else self.right


class StaticGait:
    """The statically stable gait.

    Args:
        parameters: of the gait.
        body: gives the middle and the outline of the sole, and the lengths.

    Raises:
        ConfigurationError: a weight shift so fast that the neglected acceleration term breaks the margin
            condition (3.5).
    """

    name: Final = "static"
    quasi_static: Final = True
    adjustable: Final = True
    limits: Final = None

    def __init__(self, parameters: StaticParameters, body: Body) -> None:
        self._p = parameters
        self._centre = body.foot.centre
        self._hip_height = parameters.l_GH + body.lengths.FootHeight
        self._check_margin(body)

    def initial(self) -> StaticState:
        """The state at rest, the feet side by side."""
        half = 0.5 * self._p.l_FA
        left, right = SolePose(0.0, half), SolePose(0.0, -half)
        com = self._middle(left, right)
        return StaticState(left, right, self._p.first_swing, com, com, landing=left)

    def step(self, state: StaticState, dt: float, command: GaitCommand) -> tuple[Plan, StaticState]:
        """The plan and the state `dt` seconds later; see `Gait.step`."""
        if state.phase == "stand":
            if not command.walk:
                return self._plan(state), state
            state = self._begin_double_support(state, walk=True)
        t = state.t + dt
        while state.phase != "stand" and t >= self._duration(state.phase) - _EPSILON:
            t = max(t - self._duration(state.phase), 0.0)
            state = self._next_phase(state, command)
        state = replace(state, t=0.0 if state.phase == "stand" else t)
        return self._plan(state), state

    def _duration(self, phase: Phase) -> float:
        return self._p.T_SSP if phase in ("SSL", "SSR") else self._p.T_DSP

    def _next_phase(self, state: StaticState, command: GaitCommand) -> StaticState:
        if state.phase in ("DSL", "DSR"):
            single: Phase = "SSL" if state.phase == "DSL" else "SSR"
            return replace(state, com=state.com_end, phase=single, landing=self._landing(state, command))
        if state.phase in ("SSL", "SSR"):
            left, right = (state.landing, state.right) if state.swing == "L" else (state.left, state.landing)
            swing = OTHER_SIDE[state.swing]
            landed = replace(state, left=left, right=right, swing=swing, step=state.step + 1)
            return self._begin_double_support(landed, walk=command.walk or left.x != right.x)
        return replace(state, com=state.com_end, phase="stand")

    def _begin_double_support(self, state: StaticState, *, walk: bool) -> StaticState:
        """Shift the weight onto the next stance foot, or to the middle at the end of the walk."""
        if not walk:
            return replace(state, phase="stop", com_end=self._middle(state.left, state.right))
        stance = OTHER_SIDE[state.swing]
        return replace(
            state,
            phase="DSL" if stance == "L" else "DSR",
            com_end=self._foot_centre(stance, state.foot(stance)),
        )

    def _landing(self, state: StaticState, command: GaitCommand) -> SolePose:
        """Landing of the swing foot: one step length ahead of the stance foot, or next to it to stop."""
        stance, length = state.foot(OTHER_SIDE[state.swing]), 0.0
        if command.walk:
            step = self._p.periodic_step
            length = step.length if command.velocity is None else command.velocity[0] * step.duration
        return SolePose(stance.x + length, state.foot(state.swing).y)

    def _plan(self, state: StaticState) -> Plan:
        left, right, com, t = state.left, state.right, state.com, state.t
        if state.phase in ("SSL", "SSR"):
            foot = self._swinging(state.foot(state.swing), state.landing, t)
            left, right = (foot, right) if state.swing == "L" else (left, foot)
        elif state.phase != "stand":
            com = (
                quintic(com[0], state.com_end[0], self._p.T_DSP, t).position,
                quintic(com[1], state.com_end[1], self._p.T_DSP, t).position,
            )
        return Plan(
            phase=state.phase,
            support=_SUPPORT.get(state.phase, "both"),
            progress=t / self._duration(state.phase),
            step=state.step,
            left=left,
            right=right,
            com=com,
            zmp=com,
            hip_height=self._hip_height,
        )

    def _swinging(self, start: SolePose, landing: SolePose, t: float) -> SolePose:
        """The sole in the air, quintic along x and cubic spline along z.

        Args:
            start: where it lifted.
            landing: pose at touch-down.
            t: since it lifted, s.
        """
        p = self._p
        return SolePose(
            quintic(start.x, landing.x, p.T_SSP, t).position,
            start.y,
            lift_spline(start.z, p.l_lift, landing.z, p.T_SSP, t).position,
        )

    def _foot_centre(self, side: Side, foot: SolePose) -> Vec2:
        x, y = self._centre
        return foot.x + x, foot.y + y if side == "L" else foot.y - y

    def _middle(self, left: SolePose, right: SolePose) -> Vec2:
        (x_l, y_l), (x_r, y_r) = self._foot_centre("L", left), self._foot_centre("R", right)
        return 0.5 * (x_l + x_r), 0.5 * (y_l + y_r)

    def _check_margin(self, body: Body) -> None:
        """Condition (3.5): the acceleration term stays below the distance to the border of the sole."""
        p = self._p
        height = self._hip_height + body.lengths.HipOffsetZ  # upper bound of the centre of mass, torso origin
        peak = 10.0 / math.sqrt(3.0)  # maximum acceleration of the unit quintic over a unit time
        xs = [x for x, _ in body.foot.sole]
        ys = [y for _, y in body.foot.sole]
        for axis, way, margin in (
            ("x", p.l_SW, min(max(xs) - self._centre[0], self._centre[0] - min(xs))),
            ("y", p.l_FA + 2.0 * self._centre[1], min(max(ys) - self._centre[1], self._centre[1] - min(ys))),
        ):
            term = peak * way / p.T_DSP**2 * height / GRAVITY
            if term >= margin:
                raise ConfigurationError(
                    f"static gait: T_DSP = {p.T_DSP} s moves the ZMP {1e3 * term:.0f} mm off the centre of "
                    f"mass along {axis}, more than the sole's margin of {1e3 * margin:.0f} mm (3.5); T_DSP "
                    f"must be longer than {math.sqrt(peak * way * height / GRAVITY / margin):.2f} s."
                )
