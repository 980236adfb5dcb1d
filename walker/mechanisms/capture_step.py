"""The capture step: a standing robot answers a push by a step to a point of rest; not in the thesis.

1. Trigger (`CaptureEstimator`). Reads joint angles, lean, gyroscope, load of the feet. Gives the measured
   centre of mass and capture point (`Feedback.capture_step`) while toes or heels do not hold the robot; no plan
   gives them then. The row "capture step" of `walker.transitions` begins the step.
2. Pose2D. The gait puts the swing foot where the measured capture point needs it: `_begin_capture_step`
   (which foot), `_follow` and `_target` (where) in `walker/gaits/omni/gait.py`.
3. Hips and arms in a step back (`BackwardStep`). Reads plan and capture point. Bends both hips by one angle and
   swings both arms ahead and up. A robot that tips over its heels leans back as a whole. Its HipPitch then
   reaches its stop (27.7 degrees, data sheet) while the foot that steps is still ahead of where the capture
   point asks for it. Where both hips bend by one angle, the torso turns ahead by it, and the legs stay as they
   are: the stop is as much farther away. Both must begin with the step. They return if the first cycles show a
   weak push, the hips also if it is to a side.
4. Landing. The swing foot is level as it lands, the other one follows (`walker.mechanisms.swing_foot`).
5. Balance over the foot that landed, about the foot's long axis (`landed_foot`, `LandedFootBalance`).
   Reads joint angles, lean, gyroscope, contacts. Gives the turn of the landed sole, and the damping of both
   soles. The foot that stayed hangs in the air for up to half a second, since the torso leans towards the
   landed foot. Meanwhile the robot is an inverted pendulum on one sole. An ankle that keeps its angle pushes
   the robot towards the lean that it had at the landing, and often over the foot that hangs. So the ankle turns
   with the lean, which leaves it without a moment, and beyond it by as much as brings the centre of pressure p
   past the capture point: with xi' = omega (xi - p) and p = k xi, k > 1, the capture point returns over the
   ankle. After a step back, on both feet, the robot tips ahead over a narrow support. Both soles then
   turn against the torso's rate.
"""

from __future__ import annotations

import math
from typing import Final, Literal

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.body.kinematics import FloatingBase
from bridge.body.quantities import GRAVITY, total_mass
from bridge.body.sole import sole_hull
from bridge.types import SIDES, NotNegative, Positive, Side, Vec2, Vec3
from walker.estimation.contact import Contacts
from walker.estimation.state import BaseState
from walker.functions import clip
from walker.gaits.plan import OTHER_SIDE, CaptureStep, LandedFoot, Plan

_STANDING_LOAD: Final = 0.3
"""Part of the weight under both feet from which on the robot counts as on the ground (assumed).

Less than one cell reads at most, 25 N (range of the data sheet): a robot may be on the corner of one sole.
"""


class CaptureParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the trigger."""

    min_time_after_step: NotNegative = 0.1
    """Time after a step of the walk in which no capture step begins, s. The encoders report a foot a latency
    late: while it still swings ahead, the centre of mass seems to move back between the soles."""


class CaptureEstimator:
    """Reports that toes or heels do not hold the centre of mass.

    Args:
        parameters: of the trigger.
        base: kinematics of the body.
        latency: of the prediction, s.
    """

    def __init__(self, parameters: CaptureParameters, base: FloatingBase, latency: float) -> None:
        self._p, self._latency = parameters, latency
        self._base = base
        x, _ = sole_hull(base.body, "L").T
        self._heel, self._toe = float(x.min()), float(x.max())
        self._weight = GRAVITY * total_mass(base.body)
        self._unbalanced = False
        self._since_step = math.inf
        """Time since the last step by the plan, s."""

    def update(self, state: BaseState, load: float, plan: Plan, dt: float) -> CaptureStep | None:
        """One cycle.

        Args:
            state: of the robot.
            load: on both feet, N.
            plan: in force.
            dt: time since the last cycle, s.

        Returns:
            Centre of mass and capture point when this cycle's command is carried out, in the walk frame, while
            the robot makes a capture step; None: it stands, or walks.
        """
        rests = plan.phase in ("stand", "stop")
        self._since_step = self._since_step + dt if plan.support == "both" else 0.0
        if plan.pendulum is None or not (rests or self._unbalanced):
            return None
        sides: tuple[Side, ...] = SIDES if plan.support == "both" else (plan.support,)
        over, omega = state.com.over(*sides), plan.pendulum.omega
        middle = np.mean([self._base.centres[side][:2] for side in sides], axis=0)
        base = plan.middle if plan.support == "both" else plan.foot(plan.support).foothold
        ahead = [base.local(*plan.foot(side)[:2])[0] for side in sides]
        heel, toe = self._heel + min(ahead), self._toe + max(ahead)
        x, y = (middle + over.capture_point(omega)).tolist()
        edge = min(max(x, heel), toe)
        if rests:
            landed = plan.capture is not None or self._since_step > self._p.min_time_after_step
            self._unbalanced = landed and x != edge and load > _STANDING_LOAD * self._weight
        if not self._unbalanced:
            return None
        x = edge + (x - edge) * math.exp(omega * self._latency)
        c_x, c_y = (middle + over.place + self._latency * np.array(over.velocity)).tolist()
        return CaptureStep(base.point(c_x, c_y), base.point(x, y))


class BackwardStepParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Motion of hips and arms in a step back, and the pushes for which they move."""

    hip_angle: NotNegative = 0.35
    """Bend of the torso against the legs, rad."""
    hip_rate: Positive = 4.0
    """Rate of the bend, rad/s: HipPitch turns at 7 rad/s at most (no-load speed)."""
    hip_return_rate: Positive = 2.0
    """Rate of the way back, rad/s: as the leg that landed rights the torso."""
    hip_behind: NotNegative = 0.081
    """Capture point behind the stance ankle beyond which the bend continues, m."""
    arm_angle: NotNegative = 3.4
    """Swing of both arms, rad: from hanging beyond straight up."""
    arm_rate: Positive = 8.8
    """Rate of the swing, rad/s: over ShoulderPitch's no-load speed (7.9 to 8.3 rad/s), its limit."""
    arm_return_rate: Positive = 1.0
    """Rate of the way back, rad/s: a fast one throws the robot again."""
    arm_behind: NotNegative = 0.072
    """Capture point behind the stance ankle beyond which the arms swing on, m."""
    decision: NotNegative = 0.15
    """Fraction of the step at which the capture point must have been that far behind."""
    max_beside: NotNegative = 0.02
    """Capture point to a side of the middle between the feet beyond which the hips stay as they are, m."""


class BackwardStep:
    """Bends both hips and swings both arms up in a capture step straight back.

    Args:
        parameters: how far and when.
        body: data sheet.
    """

    def __init__(self, parameters: BackwardStepParameters, body: Body) -> None:
        self._p = parameters
        self._half_width = body.lengths.HipOffsetY
        self._lower = {
            INDEX[side + name]: body.joints[side + name].lower
            for side in SIDES
            for name in ("HipPitch", "ShoulderPitch")
        }
        self.bend = 0.0
        """Bend of the torso ahead against the legs, rad."""
        self._arms = 0.0
        """Swing of the arms ahead and up, rad."""
        self._arms_rise = False
        self._max_behind = self._max_beside = 0.0
        """Farthest places of the capture point before the decision, m."""

    def update(self, plan: Plan, measured: CaptureStep | None, dt: float) -> None:
        """One cycle.

        Args:
            plan: in force.
            measured: centre of mass and capture point in the walk frame.
            dt: time since the last cycle, s.
        """
        p, goal, rate = self._p, 0.0, self._p.hip_return_rate
        if plan.captures_backward and plan.support != "both":
            rate = p.hip_rate
            undecided = plan.progress <= p.decision
            if undecided and measured is not None:
                x, y = plan.foot(plan.support).foothold.local(*measured.xi)
                self._max_behind = max(self._max_behind, -x)
                self._max_beside = max(self._max_beside, abs(abs(y) - self._half_width))
            needed = undecided or self._max_behind > p.hip_behind
            goal = p.hip_angle if needed and self._max_beside <= p.max_beside else 0.0
            self._arms_rise = undecided or self._max_behind > p.arm_behind
        else:
            self._max_behind = self._max_beside = 0.0
            self._arms_rise = self._arms_rise and self._arms < p.arm_angle
        self.bend += clip(goal - self.bend, -rate * dt, rate * dt)
        swing = p.arm_rate if self._arms_rise else -p.arm_return_rate
        self._arms = clip(self._arms + swing * dt, 0.0, p.arm_angle)

    def add(self, angles: list[float]) -> None:
        """Add bend and swing to the joint angles, within the joints' ranges.

        Args:
            angles: 25 slots, rad; changed in place.
        """
        for name, by in (("HipPitch", self.bend), ("ShoulderPitch", self._arms)):
            if by:
                for side in SIDES:
                    slot = INDEX[side + name]
                    angles[slot] = max(angles[slot] - by, self._lower[slot])


def landed_foot(state: BaseState, plan: Plan, base: FloatingBase, latency: float) -> LandedFoot | None:
    """The capture point over the foot that landed, from the landing of a capture step until the feet close.

    Args:
        state: of the robot.
        plan: in force.
        base: kinematics of the body.
        latency: of the prediction of the roll, s.
    """
    if plan.capture is None or plan.support != "both" or plan.pendulum is None:
        return None
    _, y = state.com.over(plan.capture).capture_point(plan.pendulum.omega)
    roll = state.lean[0] + latency * state.angular_velocity[0]
    return LandedFoot(y + float(base.centres[plan.capture][1]), roll)


class LandedFootParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gains and bounds of the balance after a capture step."""

    gain: Positive = 1.5
    """Centre of pressure over the capture point, both from the ankle."""
    max_offset: NotNegative = 0.03
    """Farthest centre of pressure from the ankle, m; the sole ends at 39 and 50 mm (published outline)."""
    turn: NotNegative = 1.5
    """Turn of the ankle over the centre of pressure that it causes, rad/m. The weight over the stiffness of a
    leg about x gives 1.3, 52 N over 40 N m/rad (read off one walk)."""
    landing_time: NotNegative = 0.03
    """Time after the landing in which the ankle turns with the lean even if both feet touch, s."""
    contact_time: NotNegative = 0.015
    """Contact of the other foot after which the robot is on both, s."""
    standing_time: NotNegative = 0.3
    """Contact of both feet after which the robot stands, s."""
    damping: tuple[NotNegative, NotNegative] = (0.10, 0.06)
    """Turn of both soles about x and y over the torso's rate after a step back, s."""
    max_damping: NotNegative = 0.15
    """Largest such turn, rad."""


class LandedFootBalance:
    """Turns the ankle of the foot that landed.

    Args:
        parameters: gains and bounds.
    """

    def __init__(self, parameters: LandedFootParameters) -> None:
        self._p = parameters
        self._stage: Literal["landing", "alone", "both"] = "landing"
        self._since = 0.0
        """Time since the landing, s."""
        self._touches = 0.0
        """Time for which the other foot has touched, s."""
        self._both = 0.0
        """Time for which both feet have touched, s."""
        self.roll: float | None = None
        """Turn of the landed sole about x at which its ankle brings the centre of pressure to its place, rad;
        None: the robot is not on that foot alone."""
        self.damping: Vec2 = (0.0, 0.0)
        """Addition to the turns of both soles, roll and pitch, rad."""

    @property
    def stands(self) -> bool:
        """Both feet have touched for a while since the landing."""
        return self._both > self._p.standing_time

    def update(
        self, plan: Plan, contacts: Contacts, measured: LandedFoot | None, gyroscope: Vec3, dt: float
    ) -> None:
        """One cycle.

        Args:
            plan: in force.
            contacts: of the feet.
            measured: about the foot that landed.
            gyroscope: angular velocity in the Torso frame, rad/s.
            dt: time since the last cycle, s.
        """
        p = self._p
        self.roll, self.damping = None, (0.0, 0.0)
        if plan.capture is None or plan.support != "both" or measured is None:
            self._stage, self._since, self._touches, self._both = "landing", 0.0, 0.0, 0.0
            return
        touches = contacts.of(OTHER_SIDE[plan.capture])
        self._since += dt
        self._touches = self._touches + dt if touches else 0.0
        self._both = self._both + dt if touches and contacts.of(plan.capture) else 0.0
        if self._stage == "landing" and not touches:
            self._stage = "alone"
        elif self._stage == "alone" and self._touches > p.contact_time:
            self._stage = "both"
        if self._stage == "alone" or (self._stage == "landing" and self._since < p.landing_time):
            # While the other foot bears as well, nothing is to be brought over the landed one.
            cop = 0.0 if touches else clip(p.gain * measured.xi, -p.max_offset, p.max_offset)
            self.roll = -measured.roll - p.turn * cop
        elif plan.captures_backward:
            roll, pitch = (
                clip(gain * rate, -p.max_damping, p.max_damping)
                for gain, rate in zip(p.damping, gyroscope[:2], strict=True)
            )
            self.damping = roll, pitch if self._stage == "both" else 0.0
