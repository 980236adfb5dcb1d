"""The omnidirectional gait: a pendulum that changes from foot to foot, by capture-point end conditions.

Order of phases: start (both feet), SSL, SSR, ..., stop (both feet), stand. In `start` a resting ZMP pushes the
capture point to where the first step needs it. At every instant of a step the next foothold is the one that
keeps the walk at the velocity in force bounded, from the capture point that the pendulum will have
(`bounded_capture_point`). In `stop` a resting ZMP leads the capture point to the middle between the feet.

A push at a stand begins a step at once, which follows the measured capture point; then follow stop, start,
a closing step, and stop.

The velocity of a step counts for all the steps planned after it: a new command needs no new plan, only another
foothold.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Final, NamedTuple

from bridge.body import Body
from bridge.body.sole import sole_hull
from bridge.types import Side, Vec2, Vec3
from walker.functions import LinearPendulum, quintic, smoothstep
from walker.gaits.gait import GaitCommand
from walker.gaits.omni.footholds import (
    bounded_capture_point,
    clip_foothold,
    nominal_foothold,
    rate_limited_velocity,
    steps_to_rest,
    transfer_weight,
    zmp_under,
)
from walker.gaits.omni.parameters import OmniParameters
from walker.gaits.plan import OTHER_SIDE, SIGN, CaptureStep, Feedback, Foothold, Pendulum, Phase, Plan, SolePose

REST: Final[Vec3] = (0.0, 0.0, 0.0)
"""No velocity, m/s, m/s, rad/s."""


class OmniState(NamedTuple):
    """State of the gait, in the walk frame, m and s."""

    stance: Foothold
    """Of the stance foot, or of the first one."""
    liftoff_pose: Foothold
    """Pose of the other foot before its swing."""
    swing: Side
    """The other foot."""
    target: Foothold
    """Foothold at the end of the swing under way."""
    com: Vec2
    xi: Vec2
    """Capture point."""
    zmp: Vec2
    """At rest in `start` and `stop`; in a step, that of the step before."""
    velocity: Vec3 = REST
    """Of the step under way, m/s, m/s, rad/s."""
    correction: Vec3 = REST
    """Added by feedback."""
    heading_correction: float = 0.0
    """Angle by which feedback turned the walk since its beginning, rad."""
    phase: Phase = "stand"
    t: float = 0.0
    """Since the beginning of the phase."""
    step: int = 0
    closing: bool = False
    """The step under way brings the feet side by side."""
    capture_step: bool = False
    """The step under way, or the last one, is a capture step: it follows the measured capture point."""
    backward: bool = False
    """The capture step is backward."""
    adjustment: Vec2 = (0.0, 0.0)
    """Shift of the target by feedback, m."""
    com_offset: Vec2 = (0.0, 0.0)
    """Planned centre of mass less the pendulum's, m."""
    moved: Vec2 = (0.0, 0.0)
    """Shift of the pendulum by feedback since the beginning, m."""

    @property
    def single(self) -> bool:
        """A step is under way."""
        return self.phase in ("SSL", "SSR")

    @property
    def corrected_velocity(self) -> Vec3:
        """Of the step under way with its correction, m/s, m/s, rad/s."""
        x, y, turn = (v + c for v, c in zip(self.velocity, self.correction, strict=True))
        return x, y, turn


_HORIZON: Final = 6
"""Footholds beyond the next one; later ones weigh q^6 = 1e-4."""
_EPSILON: Final = 1e-9
"""s; phases end on cycle boundaries in spite of rounding."""
_STOP_DURATION_FACTOR: Final = 3.0
"""Duration of `stop` over that of the capture point's way to the middle."""
_FREEZE_TIME: Final = 0.03
"""s before touch-down in which feedback moves the foothold no more."""
_CLOSED_TOLERANCE: Final = 0.005
"""m; feet farther off their places side by side are closed."""


class OmniGait:
    """The omnidirectional gait.

    Args:
        parameters: of the gait.
        body: gives the height of the ankle.
    """

    name: Final = "omni"
    quasi_static: Final = False
    adjustable: Final = True

    def __init__(self, parameters: OmniParameters, body: Body) -> None:
        self._p = self.limits = parameters
        self._omega = LinearPendulum(parameters.z).nu
        self._rho = transfer_weight(self._omega, parameters.T_DSP)
        x, y = sole_hull(body, "L").T
        self._heel, self._toe, self._outer = float(x.min()), float(x.max()), float(y.max())
        self._hip_height = parameters.l_GH + body.lengths.FootHeight
        # the same in all cycles of a step
        self._endless_walk = lru_cache(maxsize=4)(self._find_endless_walk)

    def initial(self) -> OmniState:
        """The state at rest, the feet side by side."""
        swing, half = self._p.first_swing, 0.5 * self._p.l_FA
        stance, liftoff_pose = (Foothold(0.0, -SIGN[swing] * half), Foothold(0.0, SIGN[swing] * half))
        com = (self._p.zmp_x, 0.0)
        return OmniState(stance, liftoff_pose, swing, liftoff_pose, com, com, com)

    def step(self, state: OmniState, dt: float, command: GaitCommand) -> tuple[Plan, OmniState]:
        """The plan and the state `dt` seconds later; see `Gait.step`."""
        measured = command.feedback.capture_step
        if measured is not None and state.phase in ("stand", "stop"):
            state = self._begin_capture_step(state, measured)
        elif state.phase == "stand":
            if not command.walk:
                return self._plan(state, command), state
            state = self._start(state)
        left = dt
        while state.phase != "stand" and left > _EPSILON:
            part = min(left, max(self._duration(state) - state.t, 0.0))
            if state.single and state.capture_step and measured is not None:
                state = self._follow(state, part, measured)
            else:
                state = self._advance(state, part, command.feedback)
            left -= part
            if state.t >= self._duration(state) - _EPSILON:
                if command.feedback.extend_step and state.single and not state.capture_step:
                    break
                state = self._next_phase(state, command)
        return self._plan(state, command), state

    def _duration(self, state: OmniState) -> float:
        if state.single:
            if state.capture_step:
                return self._p.T_backward_capture if state.backward else self._p.T_capture
            return self._p.T
        return self._p.T_start * (_STOP_DURATION_FACTOR if state.phase == "stop" else 1.0)

    def _advance(self, state: OmniState, dt: float, feedback: Feedback) -> OmniState:
        """The pendulum `dt` seconds later, over the ZMP of the middle of that time; and its foothold."""
        zmp = self._zmp(state, state.t + 0.5 * dt)
        grow, shrink = math.exp(self._omega * dt), math.exp(-self._omega * dt)
        # c' = omega (xi - c), xi' = omega (xi - p)
        (c_x, xi_x), (c_y, xi_y) = (
            (p + (c - p) * shrink + 0.5 * (x - p) * (grow - shrink), p + (x - p) * grow)
            for c, x, p in zip(state.com, state.xi, zmp, strict=True)
        )
        keep = math.exp(-dt / (self._p.capture_settling_time if state.capture_step else self._p.catch_up_time))
        com_offset = (state.com_offset[0] * keep, state.com_offset[1] * keep)
        state = state._replace(com=(c_x, c_y), xi=(xi_x, xi_y), t=state.t + dt, com_offset=com_offset)
        if state.single and not state.closing and state.t >= self._p.T_DSP - _EPSILON:
            target = self._target(state)
            by = state.adjustment
            if state.t < self._p.T - _FREEZE_TIME:
                by = self._adjustment(state, target, feedback)
            adjusted = Foothold(target.x + by[0], target.y + by[1], target.yaw)
            state = state._replace(target=adjusted, adjustment=by)
        return state

    def _begin_capture_step(self, state: OmniState, measured: CaptureStep) -> OmniState:
        """Begin a step at once with the foot that the capture point is farther from: it bears less."""
        feet = {state.swing: state.liftoff_pose, OTHER_SIDE[state.swing]: state.stance}
        a, b = (math.dist(measured.xi, feet[side][:2]) for side in ("L", "R"))
        side: Side = "R" if a < b else "L"
        state = state._replace(
            swing=side, stance=feet[OTHER_SIDE[side]], liftoff_pose=feet[side], target=feet[side]
        )
        phase: Phase = "SSL" if state.swing == "R" else "SSR"
        backward = state.stance.local(*measured.xi)[0] < 0.0
        state = state._replace(phase=phase, t=0.0, velocity=REST, correction=REST, closing=False)
        return state._replace(capture_step=True, backward=backward)

    def _follow(self, state: OmniState, dt: float, measured: CaptureStep) -> OmniState:
        """A step `dt` seconds later, towards the measured capture point."""
        p = self._p
        (x, y), (c_x, c_y) = measured.com, state.com
        com_offset = c_x + state.com_offset[0] - x, c_y + state.com_offset[1] - y
        zmp = self._edge(state, measured.xi)
        state = state._replace(com=measured.com, xi=measured.xi, zmp=zmp, com_offset=com_offset, t=state.t + dt)
        if state.t < self._duration(state) - _FREEZE_TIME:
            target = self._target(state)
            if state.backward:
                inwards = -SIGN[state.swing] * p.backward_capture_inset
                target = Foothold(*target.point(0.0, inwards), target.yaw)
            state = state._replace(target=target)
        return state

    def _edge(self, state: OmniState, xi: Vec2) -> Vec2:
        """The point of the stance sole, its inner half left aside, nearest to the capture point, m."""
        x, y = state.stance.local(*xi)
        sign = SIGN[state.swing]
        outward = min(max(-sign * y, 0.0), self._outer)
        return state.stance.point(min(max(x, self._heel), self._toe), -sign * outward)

    def _zmp(self, state: OmniState, t: float) -> Vec2:
        """Planned ZMP at a time of the phase, m."""
        p = self._p
        if state.capture_step:
            return state.zmp
        if not state.single:
            settling = state.phase == "stop" and t > p.T_start
            return state.xi if settling else state.zmp
        foot = zmp_under(p, OTHER_SIDE[state.swing], state.stance)
        share = min(t / p.T_DSP, 1.0) if p.T_DSP else 1.0
        (x_0, y_0), (x, y) = state.zmp, foot
        return x_0 + share * (x - x_0), y_0 + share * (y - y_0)

    def _steady_zmps(self, foot: Foothold, side: Side, velocity: Vec3) -> Iterator[Vec2]:
        """ZMPs of a steady walk at a velocity: of a foothold (of the foot `side`) and those after it."""
        yield zmp_under(self._p, side, foot)
        for _ in range(_HORIZON):
            side = OTHER_SIDE[side]
            foot = nominal_foothold(self._p, foot, side, velocity)
            yield zmp_under(self._p, side, foot)

    def _target(self, state: OmniState) -> Foothold:
        """Foothold of the swing foot from which the walk stays bounded with the predicted capture point.

        The condition is linear in the ZMP p_1 under the foothold:
        xi_end = (1 - rho) p_1 + rho p_0 + b, with b from a walk whose p_0 and p_1 both are at the origin.
        """
        p, side = self._p, state.swing
        zmp = state.zmp if state.capture_step else zmp_under(p, OTHER_SIDE[side], state.stance)
        grow = math.exp(self._omega * max(self._duration(state) - state.t, 0.0))
        yaw, ahead, beyond = self._endless_walk(state.stance, side, state.corrected_velocity)
        x, y = (
            (p_0 + (xi - p_0) * grow - (e - a) - self._rho * p_0) / (1.0 - self._rho) - a
            for xi, p_0, e, a in zip(state.xi, zmp, beyond, ahead, strict=True)
        )
        return clip_foothold(p, state.stance, side, Foothold(x, y, yaw))

    def _find_endless_walk(self, stance: Foothold, side: Side, velocity: Vec3) -> tuple[float, Vec2, Vec2]:
        """An endless walk at a velocity whose next foothold, of the foot `side`, is put at the origin.

        Returns:
            Yaw of that foothold, rad; the ZMP under it, and the capture point in which the walk begins, m.
        """
        first = Foothold(yaw=nominal_foothold(self._p, stance, side, velocity).yaw)
        zmps = list(self._steady_zmps(first, side, velocity))
        return first.yaw, zmps[0], bounded_capture_point(self._omega, self._p.T, self._rho, [zmps[0], *zmps])

    def _adjustment(self, state: OmniState, target: Foothold, feedback: Feedback) -> Vec2:
        """Shift of the foothold by the deviation that is predicted at touch-down, m."""
        p = self._p
        grow = math.exp(self._omega * max(p.T - state.t, 0.0))
        dx, dy = Foothold(yaw=-state.stance.yaw).point(*feedback.deviation)
        turning = abs(state.velocity[2]) / p.max_velocity[2]
        wished = [
            (straight + turning * (turned - straight)) * grow * math.copysign(max(abs(d) - band, 0.0), d)
            for d, straight, turned, band in zip(
                (dx, dy), p.foothold_gain, p.turning_foothold_gain, p.foothold_deadband, strict=True
            )
        ]
        x, y = Foothold(yaw=state.stance.yaw).point(wished[0], wished[1])
        wish = Foothold(target.x + x, target.y + y, target.yaw)
        moved = clip_foothold(p, state.stance, state.swing, wish)
        return moved.x - target.x, moved.y - target.y

    def _start(self, state: OmniState) -> OmniState:
        """Push the capture point by a resting ZMP to where a walk on the spot begins.

        The ZMP z satisfies z + (xi - z) e^(omega T_start) = a + rho (z - c), where a is the walk's need if its
        first transfer began at the centre of mass c.
        """
        zmps = [state.com, *self._steady_zmps(state.stance, OTHER_SIDE[state.swing], REST)]
        needed = bounded_capture_point(self._omega, self._p.T, self._rho, zmps)
        grow, rho = math.exp(self._omega * self._p.T_start), self._rho
        x, y = (
            (xi * grow - a + rho * c) / (grow - 1.0 + rho)
            for xi, a, c in zip(state.xi, needed, state.com, strict=True)
        )
        return state._replace(
            phase="start", t=0.0, zmp=(x, y), heading_correction=0.0, capture_step=False, backward=False
        )

    def _next_phase(self, state: OmniState, command: GaitCommand) -> OmniState:
        if state.phase == "start":
            return self._begin_step(state, command)
        if state.phase == "stop":
            apart = state.stance.local(*state.liftoff_pose[:2])
            if math.dist(apart, (0.0, SIGN[state.swing] * self._p.l_FA)) > _CLOSED_TOLERANCE:
                return self._start(state)
            state = state._replace(phase="stand", t=0.0, closing=False, velocity=REST)
            return state._replace(capture_step=False, backward=False)
        landed = self._landed(state)
        if state.capture_step:
            return self._rest(landed)
        return self._stop(landed) if state.closing else self._begin_step(landed, command)

    def _landed(self, state: OmniState) -> OmniState:
        """The end of a step: the swing foot supports, and the pendulum takes over the shift by feedback."""
        stance_side = OTHER_SIDE[state.swing]
        dx, dy = state.adjustment
        state = state._replace(
            com=(state.com[0] + dx, state.com[1] + dy),
            xi=(state.xi[0] + dx, state.xi[1] + dy),
            moved=(state.moved[0] + dx, state.moved[1] + dy),
            com_offset=(state.com_offset[0] - dx, state.com_offset[1] - dy),
            adjustment=(0.0, 0.0),
        )
        old = zmp_under(self._p, stance_side, state.stance)
        return state._replace(
            stance=state.target,
            liftoff_pose=state.stance,
            target=state.stance,
            swing=stance_side,
            zmp=(old[0] + dx, old[1] + dy),
            step=state.step + 1,
        )

    def _begin_step(self, state: OmniState, command: GaitCommand) -> OmniState:
        """The next step; the last one is made at no velocity."""
        p, number = self._p, state.step + 1
        last = command.last_step or math.inf
        velocity = rate_limited_velocity(p, state.velocity, REST)
        if command.walk:
            wanted = rate_limited_velocity(p, state.velocity, p.clipped(command.velocity or p.velocity))
            if number + steps_to_rest(p, wanted) <= last - (wanted == REST):
                velocity = wanted
        closing = velocity == REST and (not command.walk or number >= last)
        correction = REST if closing else self._correction(velocity, command.feedback, state.heading_correction)
        phase: Phase = "SSL" if state.swing == "R" else "SSR"
        state = state._replace(phase=phase, t=0.0, velocity=velocity, correction=correction, closing=closing)
        planned = nominal_foothold(p, state.stance, state.swing, velocity)
        target = nominal_foothold(p, state.stance, state.swing, state.corrected_velocity)
        return state._replace(
            target=target, heading_correction=state.heading_correction + target.yaw - planned.yaw
        )

    def _correction(self, velocity: Vec3, feedback: Feedback, heading_correction: float) -> Vec3:
        """Velocity that holds the commanded one, and the turn back by a share of the heading's error.

        Both are within the limits.
        """
        p, (x, y, turn) = self._p, velocity
        (dx, dy), bound, most = feedback.velocity, p.max_heading_correction, p.max_velocity[2]
        # Wrapped after the sum: the correction adds up over a long walk, and the measured part jumps at pi.
        error = math.remainder(feedback.heading + heading_correction, math.tau)
        correction = min(max(-p.heading_gain * error / p.T, -bound), bound)
        corrected = p.clipped((x + dx, y + dy, turn))
        return corrected[0] - x, corrected[1] - y, min(max(turn + correction, -most), most) - turn

    def _rest(self, state: OmniState) -> OmniState:
        """Stay on both feet after a capture step; the centre of mass moves to the middle between them."""
        a = zmp_under(self._p, OTHER_SIDE[state.swing], state.stance)
        b = zmp_under(self._p, state.swing, state.liftoff_pose)
        x, y = middle = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
        com_offset = state.com[0] + state.com_offset[0] - x, state.com[1] + state.com_offset[1] - y
        return state._replace(phase="stop", t=0.0, com=middle, xi=middle, zmp=middle, com_offset=com_offset)

    def _stop(self, state: OmniState) -> OmniState:
        """Lead the capture point by a resting ZMP to the middle between the feet."""
        a = zmp_under(self._p, OTHER_SIDE[state.swing], state.stance)
        b = zmp_under(self._p, state.swing, state.liftoff_pose)
        grow = math.exp(self._omega * self._p.T_start)
        x, y = ((0.5 * (u + v) - xi * grow) / (1.0 - grow) for u, v, xi in zip(a, b, state.xi, strict=True))
        return state._replace(phase="stop", t=0.0, zmp=(x, y))

    def _swung(self, state: OmniState) -> float:
        """Fraction of the swing that has passed."""
        rests = 0.0 if state.capture_step else self._p.T_DSP
        return min(max((state.t - rests) / (self._duration(state) - rests), 0.0), 1.0)

    def _way(self, state: OmniState) -> float:
        """Fraction of its way that the swing foot has made.

        The drives follow a capture step back at their greatest speed; a slow start would cost time.
        """
        swung = self._swung(state)
        return swung if state.backward else smoothstep(swung)

    def _swinging(self, state: OmniState) -> SolePose:
        """The sole in the air: (s (1 - s))^2 in height."""
        p, a, b = self._p, state.liftoff_pose, state.target
        s, way = self._swung(state), self._way(state)
        # A foot that still turns as it lands spins on the floor: the turn ends flatter than the way.
        turned = way if state.backward else quintic(0.0, 1.0, 1.0, s).position
        lift = p.backward_capture_lift if state.backward else p.l_lift
        return SolePose(
            a.x + way * (b.x - a.x),
            a.y + way * (b.y - a.y),
            lift * (4.0 * s * (1.0 - s)) ** 2,
            yaw=a.yaw + turned * (b.yaw - a.yaw),
        )

    def _plan(self, state: OmniState, command: GaitCommand) -> Plan:
        stance = SolePose(state.stance.x, state.stance.y, yaw=state.stance.yaw)
        other = SolePose(state.liftoff_pose.x, state.liftoff_pose.y, yaw=state.liftoff_pose.yaw)
        stop_poses = self._stop_poses(state)
        if state.single:
            other = self._swinging(state)
            ahead, way = command.feedback.foothold_bias, self._way(state)
            other = _ahead(other, state.stance.yaw, way * ahead)
            stance = _ahead(stance, state.stance.yaw, (1.0 - way) * ahead)
            stop_poses = tuple(
                Foothold(*Foothold(e.x, e.y, state.stance.yaw).point(0.5 * ahead, 0.0), e.yaw)
                for e in stop_poses
            )
        left, right = (other, stance) if state.swing == "L" else (stance, other)
        return Plan(
            phase=state.phase,
            support=OTHER_SIDE[state.swing] if state.single else "both",
            progress=min(state.t / self._duration(state), 1.0),
            step=state.step,
            left=left,
            right=right,
            com=(state.com[0] + state.com_offset[0], state.com[1] + state.com_offset[1]),
            zmp=self._zmp(state, state.t),
            hip_height=self._hip_height,
            pendulum=Pendulum(state.com, self._omega, state.target, state.moved, state.velocity),
            capture=(state.swing if state.single else OTHER_SIDE[state.swing]) if state.capture_step else None,
            stop_poses=stop_poses,
        )

    def _stop_poses(self, state: OmniState) -> tuple[Foothold, ...]:
        """See `Plan.stop_poses`. Feedback counts as moving the next foothold as far as the one under way."""
        left = self._duration(state) - state.t
        if left > _FREEZE_TIME or state.closing or state.capture_step or state.phase in ("stop", "stand"):
            return ()
        now = self._side_by_side(state.target, state.swing)
        if not state.single:
            return now, now
        p_0 = zmp_under(self._p, OTHER_SIDE[state.swing], state.stance)
        grow = math.exp(self._omega * left)
        x, y = (p + (xi - p) * grow for xi, p in zip(state.xi, p_0, strict=True))
        dx, dy = state.adjustment
        landed = self._landed(state._replace(xi=(x, y)))
        p_1 = zmp_under(self._p, state.swing, landed.stance)
        # The ZMP moves there in T_DSP: as if the capture point were off by rho times that way.
        x, y = (xi + self._rho * (b - a) for xi, a, b in zip(landed.xi, landed.zmp, p_1, strict=True))
        after = self._target(landed._replace(xi=(x, y), t=0.0, velocity=REST, correction=REST))
        later = self._side_by_side(Foothold(after.x + dx, after.y + dy, after.yaw), landed.swing)
        closes = rate_limited_velocity(self._p, state.velocity, REST) == REST
        return now if closes else later, later

    def _side_by_side(self, foothold: Foothold, side: Side) -> Foothold:
        """Middle between the feet of which one is on a foothold."""
        return Foothold(*foothold.point(0.0, -0.5 * SIGN[side] * self._p.l_FA), foothold.yaw)


def _ahead(sole: SolePose, yaw: float, by: float) -> SolePose:
    """A sole moved along a heading."""
    x, y = Foothold(sole.x, sole.y, yaw).point(by, 0.0)
    return sole._replace(x=x, y=y)
