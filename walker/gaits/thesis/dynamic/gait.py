"""The dynamically stable gait of the thesis (3.3.2): an inverted pendulum that falls from foot to foot.

Order of phases, beginning on the right foot: start (from rest to A), SSR (acceleration only), DSL, SSL, DSR,
SSR, ..., and at the end a single support that only decelerates to D while the swing foot lands next to
the stance foot, then stop (from D to rest). Phases do not end on cycle boundaries (the double support lasts
four cycles); the remainder is carried over, and every phase is evaluated at its exact time. Position and
velocity of the centre of mass are continuous throughout. Its acceleration, and with it the ZMP, jumps by
design where double support begins and ends: from the stance foot's middle to the point below the mass and on
to the next foot's middle.

Every bound of its parameters is checked for the body before the first step, and named when it is violated.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bridge.body import Body
from bridge.body.quantities import GRAVITY
from bridge.body.sole import sole_hull
from bridge.errors import ConfigurationError
from bridge.polygon import convex_hull
from bridge.types import Array, Side
from walker.functions import MotionState, lift_spline, quintic
from walker.gaits.gait import GaitCommand, dry_walk
from walker.gaits.plan import OTHER_SIDE, SIGN, Phase, Plan, SolePose, Support
from walker.gaits.thesis.dynamic.step import DynamicParameters, StepPlan, Transfer, plan_step

_TRIAL_INTERVAL: Final = 0.005
"""s; sampling of the walk in which the reach of the legs is checked."""
_TRIAL_STEPS: Final = 3
"""A first, a periodic and a closing step."""


@dataclass(frozen=True, slots=True)
class DynamicState:
    """State of the gait, in the walk frame, m and s."""

    left: SolePose
    """Pose of the left sole, or its last one before the swing under way."""
    right: SolePose
    landing: SolePose
    """Pose at the end of the swing under way."""
    stance: Side
    """The foot of the single support under way, or of the next one."""
    tau: tuple[float, float] = (0.0, 0.0)
    """Orbit times of the single support under way: where on the pendulum's orbit it begins and ends."""
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
        check_legs(parameters, body, (plan for plan, _ in dry_walk(self, _TRIAL_INTERVAL, _TRIAL_STEPS)))

    def initial(self) -> DynamicState:
        """The state at rest, the feet side by side."""
        left, right = SolePose(0.0, self._p.d_0), SolePose(0.0, -self._p.d_0)
        return DynamicState(left, right, landing=left, stance=OTHER_SIDE[self._p.first_swing])

    def step(self, state: DynamicState, dt: float, command: GaitCommand) -> tuple[Plan, DynamicState]:
        """The plan and the state `dt` seconds later; see `Gait.step`.

        Whether another step follows is decided when a foot lifts. Stopped on the way from rest to A, the
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
        """Single support on the stance foot, over a part of the orbit; up to D only, the feet close."""
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
    """The end of a single support: its step continues the gait or ends it."""
    left, right = (state.landing, state.right) if state.stance == "R" else (state.left, state.landing)
    landed = replace(state, left=left, right=right, step=state.step + 1)
    if state.tau[1] <= 0.0:
        return replace(landed, phase="stop")
    stance = OTHER_SIDE[state.stance]
    return replace(landed, stance=stance, phase="DSL" if stance == "L" else "DSR")


def _shift(motion: MotionState, by: float) -> MotionState:
    return motion._replace(position=motion.position + by)


def check_distances(p: DynamicParameters) -> None:
    """Bounds without which there is no step at all: 0 < e_su < e_s1 < d_0.

    Raises:
        ConfigurationError: names the bound and by how much it is violated.
    """
    if p.e_s1 >= p.d_0:
        _refuse(
            f"e_s1 = {p.e_s1} m reaches {1e3 * (p.e_s1 - p.d_0):.1f} mm beyond the middle of the stance foot; "
            f"it must be less than d_0 = l_FA / 2 = {p.d_0} m"
        )
    if p.e_su >= p.e_s1:
        _refuse(
            f"e_su = {p.e_su} m is {1e3 * (p.e_su - p.e_s1):.1f} mm too large for a step of positive duration; "
            f"it must be less than e_s1 = {p.e_s1} m"
        )


def check_balance(p: DynamicParameters, plan: StepPlan, transfer: Transfer, body: Body) -> None:
    """The feet do not overlap, do not slip (3.9), and the ZMP stays inside them in every phase.

    Raises:
        ConfigurationError: names the bound and by how much it is violated.
    """
    inner = -min(y for _, y in body.foot.sole)
    if p.l_FA < 2.0 * inner:
        _refuse(
            f"at l_FA = {p.l_FA} m the soles overlap by {1e3 * (2.0 * inner - p.l_FA):.1f} mm; l_FA must be at "
            f"least {2.0 * inner:.4f} m"
        )
    _check_friction(p, plan, transfer)
    centre = np.array([body.foot.centre[0], 0.0])
    outside = _beyond(sole_hull(body, "L"), centre[None, :])
    if outside > 0.0:
        _refuse(f"the middle of the foot {centre} lies {1e3 * outside:.1f} mm outside the sole")
    ends = centre + np.array([[plan.S_a, -p.e_su], [plan.S_a + plan.S_b, p.e_su]])
    outside = _beyond(_feet(p, body, plan.length), ends)
    if outside > 0.0:
        _refuse(f"with S_a0 = {p.S_a0} m the ZMP leaves the feet by {1e3 * outside:.1f} mm in double support")
    together = _edges(_feet(p, body, 0.0) - centre)
    outside = max(transfer.furthest(way * nx, ny) + d for nx, ny, d in together for way in (1.0, -1.0))
    if outside > 0.0:
        _refuse(
            f"with T_start = {p.T_start} s the ZMP leaves the feet by {1e3 * outside:.1f} mm on the way from "
            "rest to A or from D to rest; choose T_start nearer to 1 s, or a smaller S_a0 or e_s1"
        )


def check_legs(p: DynamicParameters, body: Body, walk: Iterable[Plan]) -> None:
    """Check that no leg stretches or folds further than in a sampled walk.

    The hip joints are taken to move with the centre of mass and to be above the ankles at rest (the mass
    ahead of them as far as the sole's middle is ahead of the ankle: within 8 mm on every NAO).

    Raises:
        ConfigurationError: names the bound and by how much it is violated.
    """
    length = body.lengths
    thigh, tibia = length.ThighLength, length.TibiaLength
    max_reach = thigh + tibia
    knee = body.joints["LKneePitch"].upper
    min_reach = math.sqrt(thigh**2 + tibia**2 + 2.0 * thigh * tibia * math.cos(knee))
    reaches = [
        math.hypot(
            plan.com[0] - body.foot.centre[0] - foot.x,
            plan.com[1] + side * length.HipOffsetY - foot.y,
            p.l_GH - foot.z,
        )
        for plan in walk
        for foot, side in ((plan.left, 1.0), (plan.right, -1.0))
    ]
    if max(reaches) > max_reach:
        _refuse(
            f"with l_GH = {p.l_GH} m and S_a0 = {p.S_a0} m a leg is stretched "
            f"{1e3 * (max(reaches) - max_reach):.1f} mm beyond its {max_reach:.4f} m; l_GH or S_a0 must be "
            "smaller"
        )
    if min(reaches) < min_reach:
        _refuse(
            f"with l_GH = {p.l_GH} m and l_lift = {p.l_lift} m a leg is folded "
            f"{1e3 * (min_reach - min(reaches)):.1f} mm below the {min_reach:.4f} m that the knee allows; l_GH "
            "must be larger or l_lift smaller"
        )


def _check_friction(p: DynamicParameters, plan: StepPlan, transfer: Transfer) -> None:
    """(3.9), for the resultant of both axes: the cone of friction knows no axes, so this implies (3.9a, b)."""
    # In single support the mass is furthest from the ZMP at touch-down.
    touch_down = plan.pendulum.nu**2 * math.hypot(plan.S_a, p.d_0 - p.e_su)
    for where, acceleration in (
        ("at touch-down", touch_down),
        ("while starting and stopping", transfer.acceleration()),
    ):
        excess = acceleration - p.mu * GRAVITY
        if excess > 0.0:
            _refuse(
                f"the acceleration {where}, {acceleration:.2f} m/s^2, is {excess:.2f} m/s^2 more than the "
                f"friction bound mu g (3.9); mu must be at least {acceleration / GRAVITY:.3f}"
            )


def _feet(p: DynamicParameters, body: Body, length: float) -> Array:
    """Corners of both soles, the right ankle at x = 0, the left one a step length ahead, shape (n, 2)."""
    right = sole_hull(body, "R") + np.array((0.0, -p.d_0))
    left = sole_hull(body, "L") + np.array((length, p.d_0))
    return np.concatenate((right, left))


def _beyond(corners: Array, points: Array) -> float:
    """Largest distance of the points from the convex hull of the corners, m; negative inside."""
    edges = _edges(corners)
    return float((points @ edges[:, :2].T + edges[:, 2]).max())


def _edges(corners: Array) -> Array:
    """Edges of the convex hull of points: outward normals and offsets, n . x + d = 0, shape (n, 3)."""
    hull = np.array(convex_hull(corners))
    along = np.roll(hull, -1, axis=0) - hull
    normals = np.column_stack((along[:, 1], -along[:, 0])) / np.linalg.norm(along, axis=1)[:, None]
    return np.column_stack((normals, -np.einsum("ij,ij->i", normals, hull)))


def _refuse(sentence: str) -> None:
    raise ConfigurationError(f"dynamic gait: {sentence}.")
