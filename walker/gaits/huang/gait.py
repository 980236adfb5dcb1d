"""The walking cycle of Huang et al. (2001) as a phase machine: start, cycles, stop.

A cycle is a double support, in which the rear foot rolls onto its toe and the front foot from its heel onto
its sole, and a single support on the front foot. Whether another step follows is decided when the swing foot
has landed. From rest the body swings sideways into the first cycle, whose step has half the way; the last step
brings the feet together. Over known ground the lengths of the steps and the heights of feet and hip follow it.

The planned zero moment point is that of all bodies (13), (14), from the poses themselves.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final, Literal

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.inverse_kinematics import UnreachableError
from bridge.body.joints import LEG_SLOTS
from bridge.body.leg_limits import CLIPPED_EXCESS, limit_violations
from bridge.body.sole import sole_hull
from bridge.types import SIDES, Side
from walker.gaits.gait import GaitCommand, dry_walk
from walker.gaits.huang.foot import ClearPaths, FootPath, FootShape, Placement
from walker.gaits.huang.footholds import Footholds
from walker.gaits.huang.hip import Piece, Pieces, choice_of
from walker.gaits.huang.multibody import STEP, Ankle, Bodies
from walker.gaits.huang.parameters import HuangParameters, check_bounds, refuse
from walker.gaits.huang.spline import even
from walker.gaits.plan import OTHER_SIDE, SIGN, Phase, Plan, SolePose, Support
from walker.gaits.pose import ARMS

_TOLERANCE: Final = 1e-9
"""m; rounding of a sole that rolls on the ground."""


def check_swing(p: HuangParameters, body: Body) -> None:
    """Check that no foot passes through flat ground, in a whole step or in a half one.

    Raises:
        ConfigurationError: with depth and time.
    """
    if p.l_FA < (width := 2.0 * max(-y for _, y in body.foot.sole)):
        refuse(
            f"at l_FA = {p.l_FA} m the soles overlap by {1e3 * (width - p.l_FA):.1f} mm; l_FA must be at least "
            f"{width:.4f} m"
        )
    shape = FootShape.of(body)
    along = sole_hull(body, "L")[:, 0]
    for fraction in (1.0, 0.5):
        path = FootPath(p, shape, Placement(0.0), Placement(fraction * 2.0 * p.D_s), fraction)
        times = even(0.0, path.settled, 400)
        heights = path.sole(times, along)[1].min(axis=1)
        if heights.min() < -_TOLERANCE:
            when = times[int(np.argmin(heights))]
            refuse(
                f"the foot goes {-1e3 * heights.min():.2f} mm into the ground at {when:.2f} s of its cycle; "
                f"raise H_ao = {p.H_ao} m or lower q_b, q_f"
            )


def check_walk(p: HuangParameters, body: Body, walk: Iterable[tuple[int, list[float]]]) -> None:
    """A walk is within reach and joint ranges.

    Args:
        p: of the gait.
        body: data sheet.
        walk: steps completed and 25 joint angles, rad, at many moments; raises UnreachableError where a foot is
            out of reach.

    Raises:
        ConfigurationError: names the foot or joint, the step, and by how much.
    """
    steps = 0
    try:
        for steps, angles in walk:
            _check_ranges(body, angles, steps + 1)
    except UnreachableError as error:
        refuse(
            f"step {steps + 1}, its first such pose: {error}; lower H_max = {p.H_max} m, or "
            "bring D_s, D_max, l_FA, y_d or y_m down"
        )


def _check_ranges(body: Body, angles: list[float], step: int) -> None:
    """Joint ranges of a pose; AnkleRoll, which may be cut in the air, is left to `walker.gaits.catalogue`."""
    for side in SIDES:
        for joint, excess in limit_violations(body, side, [angles[slot] for slot in LEG_SLOTS[side]]):
            if joint.endswith("AnkleRoll") or abs(excess) < CLIPPED_EXCESS:
                continue
            bound = "above" if excess > 0.0 else "below"
            refuse(
                f"step {step}: {joint} would stand {math.degrees(abs(excess)):.1f} deg {bound} its range on a "
                f"{body.name} in its first such pose; change q_b, q_f, H_ao, H_min, D_s or the times"
            )


_EPSILON: Final = 1e-9
"""s; cycles end on robot cycles in spite of rounding."""
_TRIAL_INTERVAL: Final = 0.02
"""s; sampling of the walk in which reach and joint ranges are checked."""
_TRIAL_STEPS: Final = 4
"""A first step, two periodic ones, and the beginning of another."""
Stage = Literal["stand", "start", "cycle", "stop"]
Pose = tuple[tuple[float, float, float], Ankle, Ankle]
"""Hips' middle, left and right ankle, walk frame, m and rad."""


@dataclass(frozen=True, slots=True)
class HuangFoot:
    """Placement of one foot, or the last one before the swing under way."""

    stand: Placement
    path: FootPath | None = None
    """Its newest swing."""
    began: float = 0.0
    """Beginning of its swing, s of the walk."""


@dataclass(frozen=True, slots=True)
class HuangState:
    """State of the gait, in the walk frame, m and s."""

    left: HuangFoot
    right: HuangFoot
    swing: Side
    """The foot of the swing under way, or of the next one."""
    piece: Piece
    """The hip's motion under way."""
    stage: Stage = "stand"
    began: float = 0.0
    """Beginning of the piece, in the time of the walk."""
    t: float = 0.0
    """Since then."""
    carry: float = 0.0
    """Time of the last cycle that is left for the next piece."""
    steps: int = 0
    """Completed."""

    def foot(self, side: Side) -> HuangFoot:
        """One of the feet."""
        return self.left if side == "L" else self.right

    @property
    def stance(self) -> Side:
        """The foot that bears the swing under way, or the next one."""
        return OTHER_SIDE[self.swing]

    @property
    def over(self) -> bool:
        """Whether the piece is at its end."""
        return self.t >= self.piece.duration - _EPSILON

    @property
    def stance_x(self) -> float:
        """Place of the foot that is furthest ahead, m."""
        return max(self.left.stand.x, self.right.stand.x)

    def with_swing(self, foot: HuangFoot) -> HuangState:
        """Another state of the foot of the swing."""
        return replace(self, left=foot) if self.swing == "L" else replace(self, right=foot)


class HuangGait:
    """The walking cycle with heel and toe.

    Args:
        parameters: of the gait; `plans` completes those of the hip's motion that they leave open.
        body: data sheet.

    Raises:
        ConfigurationError: parameters that the body cannot walk; names the bound or the joint, and by how much.
    """

    name: Final = "huang"
    quasi_static: Final = False
    adjustable: Final = False
    limits: Final = None

    def __init__(self, parameters: HuangParameters, body: Body) -> None:
        check_bounds(parameters)
        check_swing(parameters, body)
        ground = parameters.ground.stretched(1.0 / parameters.progress)
        self.parameters = parameters = msgspec.structs.replace(parameters, ground=ground, progress=1.0)
        self.choice = choice_of(parameters, body)
        """Places of the hip at the ends of single support."""
        self._shape, self.bodies = FootShape.of(body), Bodies(body, ARMS)
        half_width = max(abs(y) for _, y in body.foot.sole)
        self._footholds = Footholds(parameters, self._shape, half_width)
        self._footholds.check_width()
        self._swings = ClearPaths(parameters, body)
        rest, self._com_from_hip, height = self._standing(body)
        self._pieces = Pieces(parameters, self.choice, rest, height)
        check_walk(parameters, body, self._trial())

    def initial(self) -> HuangState:
        """The state at rest, the feet side by side."""
        left, right = self._initial_feet()
        piece = self._pieces.stand(0.0, self._level(left))
        return HuangState(HuangFoot(left), HuangFoot(right), self.parameters.first_swing, piece)

    def step(self, state: HuangState, dt: float, command: GaitCommand) -> tuple[Plan, HuangState]:
        """The plan and the state `dt` seconds later; see `Gait.step`."""
        if state.stage == "stand":
            if not command.walk:
                return self._plan(state), state
            start = self._pieces.start(*self._place(state), SIGN[state.stance])
            state = replace(state, stage="start", piece=start, t=0.0)
        elif state.over:
            state = self._next_stage(state, walk=command.walk)
        t = state.t + state.carry + dt
        state = replace(state, t=t, carry=0.0)
        if state.over:
            # The next piece is chosen at the next call, when the caller has seen this step completed.
            duration = state.piece.duration
            state = self._complete(replace(state, t=duration, carry=max(t - duration, 0.0)))
        return self._plan(state), state

    def pose(self, state: HuangState, shift: float = 0.0) -> Pose:
        """Hip and ankles.

        Args:
            state: of the walk.
            shift: time before (negative) or after that state, within the piece and a little beyond it, s.
        """
        t = state.t + shift
        if state.stage == "stand" or (state.stage == "start" and t < 0.0):
            t = 0.0
        elif state.stage == "stop":
            t = min(t, state.piece.duration)
        now = state.began + t
        return state.piece.hip(t), self._ankle("L", state.left, now), self._ankle("R", state.right, now)

    def _trial(self) -> Iterator[tuple[int, list[float]]]:
        """Steps and joint angles of a walk over all edges of the known ground, and two steps more."""
        last_edge = max(self.parameters.ground.edges(), default=0.0)
        for _, state in dry_walk(self, _TRIAL_INTERVAL):
            yield state.steps, self.bodies.joint_angles(*self.pose(state))
            if state.steps >= _TRIAL_STEPS and state.stance_x > last_edge:
                return

    def _initial_feet(self) -> tuple[Placement, Placement]:
        half = 0.5 * self.parameters.l_FA
        return self._footholds.place(0.0, half), self._footholds.place(0.0, -half)

    def _place(self, state: HuangState) -> tuple[float, float]:
        """X and height of the ground of a standing robot, m."""
        foot = state.foot(state.stance).stand
        return foot.x, self._level(foot)

    def _complete(self, state: HuangState) -> HuangState:
        """At the end of a piece."""
        if state.stage == "cycle":
            foot = state.foot(state.swing)
            assert foot.path is not None
            landed = state.with_swing(replace(foot, stand=foot.path.end))
            return replace(landed, swing=state.stance, steps=state.steps + 1)
        if state.stage == "stop":
            rest = self._pieces.stand(*self._place(state))
            return replace(state, stage="stand", piece=rest, began=state.began + state.t, t=0.0, carry=0.0)
        return state

    def _next_stage(self, state: HuangState, *, walk: bool) -> HuangState:
        """From the end of a start or a cycle: another cycle, or to rest."""
        began = state.began + state.piece.duration
        rear, stance = state.foot(state.swing).stand, state.foot(state.stance).stand
        levels, side = (state.piece.level, self._level(stance)), SIGN[state.stance]
        if not walk and rear.x == stance.x:
            return replace(
                state, stage="stop", piece=self._pieces.stop(stance.x, levels, side), began=began, t=0.0
            )
        y = SIGN[state.swing] * 0.5 * self.parameters.l_FA
        landing = self._footholds.next(stance.x, y) if walk else self._footholds.place(stance.x, y)
        cycle = self._pieces.cycle((rear, stance, landing), levels, side)
        lifted = state.with_swing(HuangFoot(rear, self._swings.path(rear, landing, y), began))
        return replace(lifted, stage="cycle", piece=cycle, began=began, t=0.0)

    def _level(self, foot: Placement) -> float:
        """Height of the patch below a foot over the floor, m."""
        return foot.z + math.tan(self.parameters.ground.slope) * foot.x

    def _plan(self, state: HuangState) -> Plan:
        hip, left, right = self.pose(state)
        before, now, after = (self.bodies.frames(*self.pose(state, shift)) for shift in (-STEP, 0.0, STEP))
        phase, support, progress = self._phase(state)
        return Plan(
            phase=phase,
            support=support,
            progress=progress,
            step=state.steps,
            left=self._sole(left),
            right=self._sole(right),
            com=(hip[0] + self._com_from_hip[0], hip[1] + self._com_from_hip[1]),
            zmp=self.bodies.zmp(before, now, after),
            hip_height=hip[2],
        )

    def _phase(self, state: HuangState) -> tuple[Phase, Support, float]:
        """Phase, support and progress."""
        stance, p = state.stance, self.parameters
        double: Phase = "DSL" if stance == "L" else "DSR"
        if state.stage == "stand":
            return "stand", "both", 0.0
        if state.over:
            return double, "both", 0.0
        if state.stage != "cycle":
            return state.stage, "both", state.t / state.piece.duration
        if state.t < p.T_d - _EPSILON:
            return double, "both", state.t / p.T_d
        return "SSL" if stance == "L" else "SSR", stance, max((state.t - p.T_d) / (p.T_c - p.T_d), 0.0)

    def _ankle(self, side: Side, foot: HuangFoot, now: float) -> Ankle:
        y, stand = SIGN[side] * 0.5 * self.parameters.l_FA, foot.stand
        if foot.path is None:
            s, c = math.sin(stand.pitch), math.cos(stand.pitch)
            return Ankle(stand.x + self._shape.l_an * s, y, stand.z + self._shape.l_an * c, stand.pitch)
        x, z, pitch = foot.path.motion(now - foot.began)
        return Ankle(x.position, y, z.position, pitch.position)

    def _sole(self, ankle: Ankle) -> SolePose:
        height, s, c = self._shape.l_an, math.sin(ankle.pitch), math.cos(ankle.pitch)
        return SolePose(ankle.x - height * s, ankle.y, ankle.z - height * c, pitch=ankle.pitch)

    def _standing(self, body: Body) -> tuple[float, tuple[float, float], float]:
        """The stand whose centre of mass is over the soles' middle.

        Returns:
            x of the hip from the ankles; centre of mass from the hip, x and y; its height; m.
        """
        feet = self._initial_feet()
        left, right = self._ankle("L", HuangFoot(feet[0]), 0.0), self._ankle("R", HuangFoot(feet[1]), 0.0)
        ahead, base = 0.0, feet[0].z
        for _ in range(30):  # a fixed point, as in `walker.gaits.pose`
            hip = (ahead, 0.0, self.parameters.H_min + base)
            com = self.bodies.centre_of_mass(self.bodies.frames(hip, left, right))
            ahead += body.foot.centre[0] - float(com[0])
        return ahead, (float(com[0]) - hip[0], float(com[1]) - hip[1]), float(com[2]) - base
