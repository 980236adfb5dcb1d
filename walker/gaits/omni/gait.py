"""The omnidirectional gait: a pendulum that changes from foot to foot, by capture-point end conditions.

Order of phases: start (both feet), SSL, SSR, ..., stop (both feet), stand. In `start` a resting ZMP pushes the
capture point to where the first step needs it. At every instant of a step the next foothold is the one that
keeps the walk at the velocity in force bounded, from the capture point that the pendulum will have
(`bounded_capture_point`). The last step closes the feet; it is taken as soon as the foothold beside the stance
foot keeps the walk bounded. In `stop` a resting ZMP leads the capture point to the middle between the feet.

A push at a stand begins a step at once, which follows the measured capture point; then follow stop, start,
a closing step, and stop.

The velocity of a step counts for all the steps planned after it: a new command needs no new plan, only another
foothold.

Functions are pure: of the constants `g`, the state `x`, the command `u`, and the time `dt`.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final

from bridge.body import Body
from bridge.body.sole import sole_hull
from bridge.planar import Pose2D
from bridge.types import Side, Vec2, Vec3
from walker.functions import LinearPendulum, clip, quintic, smoothstep
from walker.gaits.gait import GaitCommand
from walker.gaits.omni.footholds import (
    CLOSING_TOLERANCE,
    bounded_capture_point,
    clip_foothold,
    nominal_foothold,
    rate_limited_velocity,
    steps_to_rest,
    transfer_weight,
    zmp_under,
)
from walker.gaits.omni.parameters import OmniParameters
from walker.gaits.omni.state import REST, Constants, OmniState
from walker.gaits.plan import OTHER_SIDE, SIGN, CaptureStep, Feedback, Pendulum, Phase, Plan, SolePose

_HORIZON: Final = 6
"""Footholds beyond the next one; later ones weigh q^6 = 1e-4."""
_LONGEST_END: Final = 12
"""Steps in which every walk comes to its end: from the top speed it takes six."""
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
        body: gives the soles and the height of the ankle.
    """

    name: Final = "omni"
    quasi_static: Final = False
    adjustable: Final = True

    def __init__(self, parameters: OmniParameters, body: Body) -> None:
        self.limits = parameters
        x, y = sole_hull(body, "L").T
        self._constants = Constants(
            parameters,
            omega := LinearPendulum(parameters.z).nu,
            transfer_weight(omega, parameters.T_DSP),
            float(x.min()),
            float(x.max()),
            float(y.max()),
            parameters.l_GH + body.lengths.FootHeight,
        )

    def initial(self) -> OmniState:
        """The state at rest, the feet side by side."""
        p = self.limits
        swing, half = p.first_swing, 0.5 * p.l_FA
        stance, liftoff_pose = (Pose2D(0.0, -SIGN[swing] * half), Pose2D(0.0, SIGN[swing] * half))
        com = (p.zmp_x, 0.0)
        return OmniState(stance, liftoff_pose, swing, liftoff_pose, com, com, com)

    def step(self, state: OmniState, dt: float, command: GaitCommand) -> tuple[Plan, OmniState]:
        """The plan and the state `dt` seconds later; see `Gait.step`."""
        state = _step(self._constants, state, command, dt)
        return _plan(self._constants, state, command), state


def _step(g: Constants, x: OmniState, u: GaitCommand, dt: float) -> OmniState:
    measured = u.feedback.capture_step
    if measured is not None and x.phase in ("stand", "stop"):
        x = _begin_capture_step(x, measured)
    elif x.phase == "stand" and u.walk:
        x = _start(g, x)
    remaining = dt
    while x.phase != "stand" and remaining > _EPSILON:
        part = min(remaining, max(_duration(g, x) - x.t, 0.0))
        if x.single and x.captures and measured is not None:
            x = _follow(g, x, measured, part)
        else:
            x = _aim(g, _fall(g, x, part), u.feedback)
        remaining -= part
        if x.t >= _duration(g, x) - _EPSILON:
            if u.feedback.extend_step and x.single and not x.captures:
                break
            x = _next_phase(g, x, u)
    return x


# The pendulum: c' = omega (xi - c), xi' = omega (xi - p).


def _drift(xi: Vec2, zmp: Vec2, grow: float) -> Vec2:
    """The capture point after the time in which its distance from a resting ZMP grows by a factor, m."""
    (x, y), (p_x, p_y) = xi, zmp
    return p_x + (x - p_x) * grow, p_y + (y - p_y) * grow


def _fall(g: Constants, x: OmniState, dt: float) -> OmniState:
    """The pendulum `dt` seconds later, over the ZMP of the middle of that time."""
    zmp = _zmp(g, x, x.t + 0.5 * dt)
    grow, shrink = math.exp(g.omega * dt), math.exp(-g.omega * dt)
    c_x, c_y = (
        p + (c - p) * shrink + 0.5 * (xi - p) * (grow - shrink)
        for c, xi, p in zip(x.com, x.xi, zmp, strict=True)
    )
    keep = math.exp(-dt / (g.p.capture_settling_time if x.captures else g.p.catch_up_time))
    com_offset = x.com_offset[0] * keep, x.com_offset[1] * keep
    return x._replace(com=(c_x, c_y), xi=_drift(x.xi, zmp, grow), t=x.t + dt, com_offset=com_offset)


def _zmp(g: Constants, x: OmniState, t: float) -> Vec2:
    """Planned ZMP at a time of the phase, m."""
    if x.captures:
        return x.zmp
    if not x.single:
        return x.xi if x.phase == "stop" and t > g.p.T_start else x.zmp
    share = min(t / g.p.T_DSP, 1.0) if g.p.T_DSP else 1.0
    (x_0, y_0), (x_1, y_1) = x.zmp, _under_stance(g, x)
    return x_0 + share * (x_1 - x_0), y_0 + share * (y_1 - y_0)


def _under_stance(g: Constants, x: OmniState) -> Vec2:
    return zmp_under(g.p, x.support, x.stance)


def _between_feet(g: Constants, x: OmniState) -> Vec2:
    (a_x, a_y), (b_x, b_y) = _under_stance(g, x), zmp_under(g.p, x.swing, x.liftoff_pose)
    return 0.5 * (a_x + b_x), 0.5 * (a_y + b_y)


# Footholds.


def _steady_zmps(g: Constants, foot: Pose2D, side: Side, velocity: Vec3) -> list[Vec2]:
    """ZMPs of a steady walk at a velocity: of a foothold (of the foot `side`) and those after it."""
    zmps = [zmp_under(g.p, side, foot)]
    for _ in range(_HORIZON):
        side = OTHER_SIDE[side]
        foot = nominal_foothold(g.p, foot, side, velocity)
        zmps.append(zmp_under(g.p, side, foot))
    return zmps


@lru_cache(maxsize=16)  # the same in all cycles of a step
def _endless_walk(g: Constants, stance: Pose2D, side: Side, velocity: Vec3) -> tuple[float, Vec2, Vec2]:
    """An endless walk at a velocity whose next foothold, of the foot `side`, is put at the origin.

    Returns:
        Yaw of that foothold, rad; the ZMP under it, and the capture point in which the walk begins, m.
    """
    first = Pose2D(yaw=nominal_foothold(g.p, stance, side, velocity).yaw)
    zmps = _steady_zmps(g, first, side, velocity)
    return first.yaw, zmps[0], bounded_capture_point(g.omega, g.p.T, g.rho, [zmps[0], *zmps])


def _target(g: Constants, x: OmniState) -> Pose2D:
    """Pose2D of the swing foot from which the walk stays bounded with the predicted capture point.

    The condition is linear in the ZMP p_1 under the foothold:
    xi_end = (1 - rho) p_1 + rho p_0 + b, with b from a walk whose p_0 and p_1 both are at the origin.
    """
    zmp = x.zmp if x.captures else _under_stance(g, x)
    end = _drift(x.xi, zmp, math.exp(g.omega * max(_duration(g, x) - x.t, 0.0)))
    yaw, ahead, beyond = _endless_walk(g, x.stance, x.swing, x.corrected_velocity)
    p_x, p_y = (
        (xi - (e - a) - g.rho * p_0) / (1.0 - g.rho) - a
        for xi, p_0, e, a in zip(end, zmp, beyond, ahead, strict=True)
    )
    return clip_foothold(g.p, x.stance, x.swing, Pose2D(p_x, p_y, yaw))


def _aim(g: Constants, x: OmniState, feedback: Feedback) -> OmniState:
    """Put the foothold of a step of the walk where the capture point and its measured deviation need it."""
    if not x.single or x.kind == "closing" or x.t < g.p.T_DSP - _EPSILON:
        return x
    by, target = x.adjustment, _target(g, x)
    if x.t < g.p.T - _FREEZE_TIME:
        by = _adjustment(g, x, target, feedback.deviation)
    return x._replace(target=Pose2D(target.x + by[0], target.y + by[1], target.yaw), adjustment=by)


def _adjustment(g: Constants, x: OmniState, target: Pose2D, deviation: Vec2) -> Vec2:
    """Shift of the foothold by the deviation that is predicted at touch-down, m."""
    p = g.p
    grow = math.exp(g.omega * max(p.T - x.t, 0.0))
    turning = abs(x.velocity[2]) / p.max_velocity[2]
    wished = [
        (straight + turning * (turned - straight)) * grow * math.copysign(max(abs(d) - band, 0.0), d)
        for d, straight, turned, band in zip(
            Pose2D(yaw=-x.stance.yaw).point(*deviation),
            p.foothold_gain,
            p.turning_foothold_gain,
            p.foothold_deadband,
            strict=True,
        )
    ]
    dx, dy = Pose2D(yaw=x.stance.yaw).point(wished[0], wished[1])
    moved = clip_foothold(p, x.stance, x.swing, Pose2D(target.x + dx, target.y + dy, target.yaw))
    return moved.x - target.x, moved.y - target.y


# The capture step.


def _begin_capture_step(x: OmniState, measured: CaptureStep) -> OmniState:
    """Begin a step at once with the foot that the capture point is farther from: it bears less."""
    feet = {x.swing: x.liftoff_pose, x.support: x.stance}
    a, b = (math.dist(measured.xi, feet[side][:2]) for side in ("L", "R"))
    swing: Side = "R" if a < b else "L"
    stance = feet[OTHER_SIDE[swing]]
    return x._replace(
        swing=swing,
        stance=stance,
        liftoff_pose=feet[swing],
        target=feet[swing],
        phase=_phase_of(swing),
        t=0.0,
        velocity=REST,
        correction=REST,
        kind="back" if stance.local(*measured.xi)[0] < 0.0 else "ahead",
    )


def _follow(g: Constants, x: OmniState, measured: CaptureStep, dt: float) -> OmniState:
    """A capture step `dt` seconds later, towards the measured capture point."""
    (m_x, m_y), (c_x, c_y) = measured.com, x.com
    com_offset = c_x + x.com_offset[0] - m_x, c_y + x.com_offset[1] - m_y
    zmp = _edge(g, x, measured.xi)
    x = x._replace(com=measured.com, xi=measured.xi, zmp=zmp, com_offset=com_offset, t=x.t + dt)
    if x.t >= _duration(g, x) - _FREEZE_TIME:
        return x
    target = _target(g, x)
    if x.kind == "back":
        inwards = -SIGN[x.swing] * g.p.backward_capture_inset
        target = target.pose(Pose2D(0.0, inwards))
    return x._replace(target=target)


def _edge(g: Constants, x: OmniState, xi: Vec2) -> Vec2:
    """The point of the stance sole, its inner half left aside, nearest to the capture point, m."""
    ahead, left = x.stance.local(*xi)
    sign = SIGN[x.swing]
    return x.stance.point(clip(ahead, g.heel, g.toe), -sign * clip(-sign * left, 0.0, g.outer))


# Phases.


def _duration(g: Constants, x: OmniState) -> float:
    """Duration of the phase, s."""
    if not x.single:
        return g.p.T_start * (_STOP_DURATION_FACTOR if x.phase == "stop" else 1.0)
    return {"ahead": g.p.T_capture, "back": g.p.T_backward_capture}.get(x.kind, g.p.T)


def _phase_of(swing: Side) -> Phase:
    return "SSL" if swing == "R" else "SSR"


def _next_phase(g: Constants, x: OmniState, u: GaitCommand) -> OmniState:
    if x.phase == "start":
        return _begin_step(g, x, u)
    if x.phase == "stop":
        apart = x.stance.local(*x.liftoff_pose[:2])
        if math.dist(apart, (0.0, SIGN[x.swing] * g.p.l_FA)) > _CLOSED_TOLERANCE:
            return _start(g, x)
        return x._replace(phase="stand", t=0.0, velocity=REST, kind="walk")
    landed = _landed(g, x)
    if x.captures:
        return _rest(g, landed)
    return _stop(g, landed) if x.kind == "closing" else _begin_step(g, landed, u)


def _start(g: Constants, x: OmniState) -> OmniState:
    """Push the capture point by a resting ZMP to where a walk on the spot begins.

    The ZMP z satisfies z + (xi - z) e^(omega T_start) = a + rho (z - c), where a is the walk's need if its
    first transfer began at the centre of mass c.
    """
    zmps = [x.com, *_steady_zmps(g, x.stance, x.support, REST)]
    needed = bounded_capture_point(g.omega, g.p.T, g.rho, zmps)
    grow = math.exp(g.omega * g.p.T_start)
    z_x, z_y = (
        (xi * grow - a + g.rho * c) / (grow - 1.0 + g.rho) for xi, a, c in zip(x.xi, needed, x.com, strict=True)
    )
    return x._replace(phase="start", t=0.0, zmp=(z_x, z_y), heading_correction=0.0, kind="walk")


def _begin_step(g: Constants, x: OmniState, u: GaitCommand) -> OmniState:
    """The next step; the last one is made at no velocity."""
    p, number, last = g.p, x.step + 1, u.last_step or math.inf
    velocity = rate_limited_velocity(p, x.velocity, REST)
    if u.walk:
        wanted = rate_limited_velocity(p, x.velocity, p.clipped(u.velocity or p.velocity))
        begins = x.phase == "start" and number < last
        if begins or number + steps_to_rest(p, wanted) <= last - (wanted == REST):
            velocity = wanted
    ends = velocity == REST and (not u.walk or number >= last)
    correction = REST if ends else _correction(p, velocity, u.feedback, x.heading_correction)
    x = x._replace(phase=_phase_of(x.swing), t=0.0, velocity=velocity, correction=correction)
    closing = ends and (number >= last or _may_close(g, x))
    planned = nominal_foothold(p, x.stance, x.swing, velocity)
    target = nominal_foothold(p, x.stance, x.swing, x.corrected_velocity)
    turned = x.heading_correction + target.yaw - planned.yaw
    return x._replace(target=target, heading_correction=turned, kind="closing" if closing else "walk")


def _may_close(g: Constants, x: OmniState) -> bool:
    """Whether a step that begins at no velocity needs no other foothold than the one beside the stance foot."""
    needed, beside = _target(g, _transferred(g, x)), nominal_foothold(g.p, x.stance, x.swing, REST)
    return math.dist(needed[:2], beside[:2]) < CLOSING_TOLERANCE


def _transferred(g: Constants, x: OmniState) -> OmniState:
    """The beginning of a step as if the ZMP were under the stance foot at once.

    It moves there in T_DSP: as if the capture point were off by rho times that way.
    """
    xi_x, xi_y = (xi + g.rho * (b - a) for xi, a, b in zip(x.xi, x.zmp, _under_stance(g, x), strict=True))
    return x._replace(xi=(xi_x, xi_y))


def _correction(p: OmniParameters, velocity: Vec3, feedback: Feedback, heading_correction: float) -> Vec3:
    """Velocity that holds the commanded one, and the turn back by a share of the heading's error.

    Both are within the limits.
    """
    (x, y, turn), (dx, dy), most = velocity, feedback.velocity, p.max_velocity[2]
    # Wrapped after the sum: the correction adds up over a long walk, and the measured part jumps at pi.
    error = math.remainder(feedback.heading + heading_correction, math.tau)
    back = clip(-p.heading_gain * error / p.T, -p.max_heading_correction, p.max_heading_correction)
    corrected = p.clipped((x + dx, y + dy, turn))
    return corrected[0] - x, corrected[1] - y, clip(turn + back, -most, most) - turn


def _landed(g: Constants, x: OmniState) -> OmniState:
    """The end of a step: the swing foot supports, and the pendulum takes over the shift by feedback."""
    dx, dy = x.adjustment
    old = _under_stance(g, x)
    return x._replace(
        com=(x.com[0] + dx, x.com[1] + dy),
        xi=(x.xi[0] + dx, x.xi[1] + dy),
        moved=(x.moved[0] + dx, x.moved[1] + dy),
        com_offset=(x.com_offset[0] - dx, x.com_offset[1] - dy),
        adjustment=(0.0, 0.0),
        stance=x.target,
        liftoff_pose=x.stance,
        target=x.stance,
        swing=x.support,
        zmp=(old[0] + dx, old[1] + dy),
        step=x.step + 1,
    )


def _rest(g: Constants, x: OmniState) -> OmniState:
    """Stay on both feet after a capture step; the centre of mass moves to the middle between them."""
    middle = _between_feet(g, x)
    com_offset = x.com[0] + x.com_offset[0] - middle[0], x.com[1] + x.com_offset[1] - middle[1]
    return x._replace(phase="stop", t=0.0, com=middle, xi=middle, zmp=middle, com_offset=com_offset)


def _stop(g: Constants, x: OmniState) -> OmniState:
    """Lead the capture point by a resting ZMP to the middle between the feet."""
    grow = math.exp(g.omega * g.p.T_start)
    z_x, z_y = ((m - xi * grow) / (1.0 - grow) for m, xi in zip(_between_feet(g, x), x.xi, strict=True))
    return x._replace(phase="stop", t=0.0, zmp=(z_x, z_y))


# The plan.


def _way(g: Constants, x: OmniState) -> tuple[float, float]:
    """Fractions of its swing, and of its way, that the swing foot has made.

    The drives follow a capture step back at their greatest speed; a slow start would cost time.
    """
    rests = 0.0 if x.captures else g.p.T_DSP
    swung = clip((x.t - rests) / (_duration(g, x) - rests), 0.0, 1.0)
    return swung, swung if x.kind == "back" else smoothstep(swung)


def _swinging(g: Constants, x: OmniState) -> SolePose:
    """The sole in the air: (s (1 - s))^2 in height."""
    a, b, (s, way) = x.liftoff_pose, x.target, _way(g, x)
    # A foot that still turns as it lands spins on the floor: the turn ends flatter than the way.
    turned = way if x.kind == "back" else quintic(0.0, 1.0, 1.0, s).position
    lift = g.p.backward_capture_lift if x.kind == "back" else g.p.l_lift
    return SolePose(
        a.x + way * (b.x - a.x),
        a.y + way * (b.y - a.y),
        lift * (4.0 * s * (1.0 - s)) ** 2,
        yaw=a.yaw + turned * (b.yaw - a.yaw),
    )


def _plan(g: Constants, x: OmniState, u: GaitCommand) -> Plan:
    stance = SolePose(x.stance.x, x.stance.y, yaw=x.stance.yaw)
    other = SolePose(x.liftoff_pose.x, x.liftoff_pose.y, yaw=x.liftoff_pose.yaw)
    stop_poses = _stop_poses(g, x)
    if x.single:
        ahead, (_, way), yaw = u.feedback.foothold_bias, _way(g, x), x.stance.yaw
        other = _ahead(_swinging(g, x), yaw, way * ahead)
        stance = _ahead(stance, yaw, (1.0 - way) * ahead)
        stop_poses = tuple(Pose2D(*Pose2D(e.x, e.y, yaw).point(0.5 * ahead, 0.0), e.yaw) for e in stop_poses)
    left, right = (other, stance) if x.swing == "L" else (stance, other)
    return Plan(
        phase=x.phase,
        support=x.support if x.single else "both",
        progress=min(x.t / _duration(g, x), 1.0),
        step=x.step,
        left=left,
        right=right,
        com=(x.com[0] + x.com_offset[0], x.com[1] + x.com_offset[1]),
        zmp=_zmp(g, x, x.t),
        hip_height=g.hip_height,
        pendulum=Pendulum(x.com, g.omega, x.target, x.moved, x.velocity),
        capture=(x.swing if x.single else x.support) if x.captures else None,
        stop_poses=stop_poses,
    )


def _stop_poses(g: Constants, x: OmniState) -> tuple[Pose2D, ...]:
    """See `Plan.stop_poses`. Feedback counts as moving the next foothold as far as the one under way."""
    remaining = _duration(g, x) - x.t
    if remaining > _FREEZE_TIME or x.kind != "walk" or x.phase in ("stop", "stand"):
        return ()
    if not x.single:
        return (now := _side_by_side(g, x.target, x.swing)), now
    end = _drift(x.xi, _under_stance(g, x), math.exp(g.omega * remaining))
    landed = _landed(g, x._replace(xi=end))
    return _closed(g, landed, x.adjustment, 0), _closed(g, landed, x.adjustment, 1)


def _closed(g: Constants, x: OmniState, by: Vec2, steps: int) -> Pose2D:
    """Middle between the feet at the end of a walk.

    Args:
        g: constants.
        x: a step that has landed.
        by: shift of the next foothold by feedback, m.
        steps: at no velocity before the walk is told to end.
    """
    for _ in range(_LONGEST_END):
        x = _begin_step(g, x._replace(heading_correction=0.0), GaitCommand(walk=steps > 0, velocity=REST))
        if x.kind == "closing":
            break
        x, steps = _transferred(g, x), steps - 1
        target = _target(g, x)
        end = _drift(x.xi, _under_stance(g, x), math.exp(g.omega * g.p.T))
        x = _landed(
            g, x._replace(xi=end, target=Pose2D(target.x + by[0], target.y + by[1], target.yaw), adjustment=by)
        )
        by = (0.0, 0.0)
    return _side_by_side(g, x.target, x.swing)


def _side_by_side(g: Constants, foothold: Pose2D, side: Side) -> Pose2D:
    """Middle between the feet of which one is on a foothold."""
    return foothold.pose(Pose2D(0.0, -0.5 * SIGN[side] * g.p.l_FA))


def _ahead(sole: SolePose, yaw: float, by: float) -> SolePose:
    """A sole moved along a heading."""
    x, y = Pose2D(sole.x, sole.y, yaw).point(by, 0.0)
    return sole._replace(x=x, y=y)
