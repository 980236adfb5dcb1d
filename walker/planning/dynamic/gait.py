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

from dataclasses import dataclass, replace
from typing import Final

from bridge.body import Body
from bridge.types import Side
from walker.functions import MotionState, lift_spline, quintic
from walker.planning.dynamic.admissible import check_balance, check_distances, check_legs
from walker.planning.dynamic.step import DynamicParameters, plan_step
from walker.planning.dynamic.transfer import Transfer
from walker.planning.gait import GaitCommand, dry_walk
from walker.planning.plan import OTHER_SIDE, SIGN, Phase, Plan, SolePose, Support

_TRIAL: Final = 0.005
"""s; sampling of the walk in which the reach of the legs is checked."""
_TRIAL_STEPS: Final = 3
"""A first, a periodic and a closing step."""


@dataclass(frozen=True, slots=True)
class DynamicState:
    """Where the gait is, in the walk frame, m and s."""

    left: SolePose
    """Where the left sole stands, or stood before the swing under way."""
    right: SolePose
    landing: SolePose
    """Where the swing under way ends."""
    stance: Side
    """The foot of the single support under way, or of the next one."""
    tau: tuple[float, float] = (0.0, 0.0)
    """Of the single support under way: where on the pendulum's orbit it begins and ends."""
    phase: Phase = "stand"
    t: float = 0.0
    """Since the beginning of the phase."""
    step: int = 0

    def foot(self, side: Side) -> SolePose:
        """One of the soles."""
        return self.left if side == "L" else self.right


class DynamicGait:
    """The dynamically stable gait.

    The planned ZMP of single support rests at the sole's middle along x and on the ankle's line along y
    (d_0 = l_FA / 2 as in the thesis, a few millimetres inside the sole's middle).

    Args:
        parameters: of the gait.
        body: gives the soles, the leg lengths and the foot height.

    Raises:
        ConfigurationError: a parameter set that the body cannot walk; names the violated bound.
    """

    name: Final = "dynamic"
    quasi_static: Final = False
    adjustable: Final = False
    limits: Final = None

    def __init__(self, parameters: DynamicParameters, body: Body) -> None:
        check_distances(parameters)
        self._p = parameters
        self.plan = plan_step(parameters)
        """The periodic step."""
        self._transfer = Transfer(self.plan, parameters.e_s1, parameters.T_start)
        check_balance(parameters, self.plan, self._transfer, body)
        self._centre_x = body.foot.centre[0]
        self._hip_height = parameters.l_GH + body.lengths.FootHeight
        check_legs(parameters, body, (plan for plan, _ in dry_walk(self, _TRIAL, _TRIAL_STEPS)))

    def initial(self) -> DynamicState:
        """At rest, the feet side by side."""
        left, right = SolePose(0.0, self._p.d_0), SolePose(0.0, -self._p.d_0)
        return DynamicState(left, right, landing=left, stance=OTHER_SIDE[self._p.first_swing])

    def step(self, state: DynamicState, dt: float, command: GaitCommand) -> tuple[Plan, DynamicState]:
        """The plan and the state `dt` seconds later; see `Gait.step`.

        Whether another step follows is decided when a foot lifts. Told to stop on the way from rest to A, the
        gait returns to rest without a step.
        """
        if state.phase == "stand":
            if not command.walk:
                return self._plan(state), state
            state = replace(state, phase="start", stance=OTHER_SIDE[self._p.first_swing])
        t = state.t + dt
        while state.phase != "stand" and t >= self._duration(state):
            t -= self._duration(state)
            state = self._next_phase(state, walk=command.walk)
        state = replace(state, t=0.0 if state.phase == "stand" else t)
        return self._plan(state), state

    def com_motion(self, state: DynamicState) -> tuple[MotionState, MotionState]:
        """Position, velocity and acceleration of the planned centre of mass, x and y."""
        side, t = SIGN[state.stance], state.t
        stance = state.foot(state.stance)
        across = 0.0
        if state.phase == "start":
            x, y = self._transfer.start(t, side)
        elif state.phase == "stop":
            x, y = self._transfer.stop(t, side)
        elif state.phase in ("SSL", "SSR"):
            x, y = self.plan.single_support(state.tau[0] + t, side)
            across = stance.y
        elif state.phase in ("DSL", "DSR"):
            x, y = self.plan.double_support(t, side)
        else:
            x = y = MotionState(0.0, 0.0, 0.0)
        return _shift(x, stance.x + self._centre_x), _shift(y, across)

    def _duration(self, state: DynamicState) -> float:
        if state.phase in ("SSL", "SSR"):
            return state.tau[1] - state.tau[0]
        return self.plan.T_DSP if state.phase in ("DSL", "DSR") else self._p.T_start

    def _next_phase(self, state: DynamicState, *, walk: bool) -> DynamicState:
        t_a = self.plan.t_a
        if state.phase == "start":
            return self._lift(state, 0.0, t_a) if walk else replace(state, phase="stop")
        if state.phase in ("DSL", "DSR"):
            return self._lift(state, -t_a, t_a if walk else 0.0)
        if state.phase in ("SSL", "SSR"):
            return _put_down(state)
        return replace(state, phase="stand")

    def _lift(self, state: DynamicState, begin: float, end: float) -> DynamicState:
        """Single support on the stance foot, over a part of the orbit; up to D only, the feet come together."""
        stance, swing = state.foot(state.stance), state.foot(OTHER_SIDE[state.stance])
        return replace(
            state,
            tau=(begin, end),
            phase="SSL" if state.stance == "L" else "SSR",
            landing=SolePose(stance.x + (self.plan.length if end > 0.0 else 0.0), swing.y),
        )

    def _plan(self, state: DynamicState) -> Plan:
        x, y = self.com_motion(state)
        left, right = state.left, state.right
        support: Support = "both"
        if state.phase == "SSR":
            left, support = self._swinging(left, state), "R"
        elif state.phase == "SSL":
            right, support = self._swinging(right, state), "L"
        pendulum = self.plan.pendulum
        return Plan(
            phase=state.phase,
            support=support,
            progress=0.0 if state.phase == "stand" else state.t / self._duration(state),
            step=state.step,
            left=left,
            right=right,
            com=(x.position, y.position),
            zmp=(pendulum.zmp(x.position, x.acceleration), pendulum.zmp(y.position, y.acceleration)),
            hip_height=self._hip_height,
        )

    def _swinging(self, start: SolePose, state: DynamicState) -> SolePose:
        """Quintic along x, so that the foot is at rest when it lands, cubic spline along z (3.3.1)."""
        duration, landing = self._duration(state), state.landing
        return SolePose(
            quintic(start.x, landing.x, duration, state.t).position,
            start.y,
            lift_spline(start.z, self._p.l_lift, landing.z, duration, state.t).position,
        )


def _put_down(state: DynamicState) -> DynamicState:
    """The end of a single support: with its step the gait goes on, or comes to rest."""
    left, right = (state.landing, state.right) if state.stance == "R" else (state.left, state.landing)
    landed = replace(state, left=left, right=right, step=state.step + 1)
    if state.tau[1] <= 0.0:
        return replace(landed, phase="stop")
    stance = OTHER_SIDE[state.stance]
    return replace(landed, stance=stance, phase="DSL" if stance == "L" else "DSR")


def _shift(motion: MotionState, by: float) -> MotionState:
    return motion._replace(position=motion.position + by)
