"""The stabilising controllers on top of a plan: which joint angles to ask for in this cycle.

In order: the leg admittances move the planned feet up or down; inverse kinematics; the bend of the hips in a
capture step back; joint compliance compensation; torso control turns the ankles of the stance leg, the ankle
admittances those of the swing leg; joint ranges.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from bridge.body import Body
from bridge.body.inverse_kinematics import UnreachableError
from bridge.body.joints import INDEX
from bridge.body.leg_limits import AnkleRange
from bridge.messages import SensorFrame
from bridge.planar import Pose2D
from bridge.types import SIDES, Side, Vec2
from walker.estimation.contact import Contacts, SupportState
from walker.estimation.ground import Corrections
from walker.gaits.plan import OTHER_SIDE, Plan, SolePose, Support
from walker.gaits.pose import PoseMaker
from walker.mechanisms.admittance import AnkleAdmittance, AnkleLimits, LegAdmittances
from walker.mechanisms.capture_step import BackwardStep
from walker.mechanisms.compliance import JointCompliance
from walker.mechanisms.stance_ankle import StanceAnkle
from walker.mechanisms.swing_foot import SwingFootCorrection, SwingFootOrientation
from walker.mechanisms.torso_control import TorsoControl
from walker.monitor import Estimate
from walker.parameters import ControllerParameters

_ALIGNED_TOLERANCE: Final = math.radians(0.5)
"""Difference of the plan's ground from that found at which the walk may begin, rad."""


class Stabilizer:
    """Turns plans into joint angles, corrected by feedback.

    Args:
        body: data sheet.
        parameters: which controllers are on, and their numbers.
        pose: inverse kinematics of the plan.
        cycle: of the robot, s.

    Raises:
        ConfigurationError: there is no torso controller for this cycle time.
    """

    def __init__(self, body: Body, parameters: ControllerParameters, pose: PoseMaker, cycle: float) -> None:
        self._pose = pose
        self.stiffness = 1.0
        """Stiffness of all joints in the walk."""
        self.failure = ""
        """Why it cannot go on: never."""
        on = parameters.switches
        self._backward_step = BackwardStep(parameters.backward_step, body)
        self._compliance = JointCompliance(parameters.compliance, body, cycle, parameters.latency)
        self._compensates = on.joint_compliance
        self._ranges = {side: AnkleRange(body, side) for side in SIDES}
        self._legs = self._ankles = self._orientation = None
        if on.leg_admittance:
            self._legs = LegAdmittances(parameters.leg, body.lengths.FootHeight)
        if on.ankle_admittance:
            self._ankles = {side: AnkleAdmittance(parameters.ankle, body, side) for side in SIDES}
        if on.swing_foot_orientation:
            self._orientation = SwingFootOrientation(parameters.swing_foot_orientation, parameters.landed_foot)
        self._common_rate = parameters.ground.common_rate if on.common_ankle_tilt else 0.0
        self._ground_rate = parameters.ground.max_rate if on.ground_tilt else 0.0
        self._ground: Vec2 = (0.0, 0.0)
        self._solved: tuple[float, ...] = ()
        self._torso = _torso_control(parameters, cycle)
        self._predicts_lean = on.gyroscope_lean
        self._stance_ankle = StanceAnkle(
            parameters.damping,
            parameters.lean_feedback,
            cycle,
            on_rate=on.gyroscope_damping,
            on_lean=on.lean_feedback,
        )

    def holding(self, frame: SensorFrame) -> tuple[float, ...]:
        """See `JointCompliance.holding`."""
        return self._compliance.holding(frame)

    def settle(self, estimate: Estimate) -> None:
        """One cycle that corrects nothing: the filters follow the estimate and are settled for the walk."""
        if self._torso is not None:
            self._torso.update(estimate.base.angle[1], "both")

    def update(
        self, plan: Plan, support_state: SupportState, estimate: Estimate, frame: SensorFrame, dt: float
    ) -> tuple[tuple[float, ...], Corrections]:
        """One cycle, once per received frame.

        Args:
            plan: the plan.
            support_state: roles of the legs.
            estimate: contacts and state of the robot.
            frame: newest sensor frame.
            dt: time since the last one, s.

        Returns:
            25 joint angles within their ranges, rad, and the corrections in them.
        """
        lean = estimate.base.lean_ahead if self._predicts_lean else estimate.base.angle
        feedback = estimate.feedback
        self._backward_step.update(plan, feedback.capture_step, dt)
        lean = lean[0], lean[1] - self._backward_step.bend  # of the legs: the torso is bent ahead of them
        swing = dict.fromkeys(SIDES, SwingFootCorrection())
        if self._orientation is not None:
            swing = self._orientation.update(
                lean,
                plan,
                support_state,
                estimate.contacts,
                dt,
                landed=feedback.landed,
                gyroscope=estimate.base.angular_velocity,
            )
        left, right = self._lift(plan, support_state, frame, estimate.delay, dt)
        lift = left + swing["L"].lift, right + swing["R"].lift
        torso = (0.0, 0.0)
        if self._torso is not None:
            torso = self._torso.update(
                estimate.base.angle[1], _sole_support(support_state.support, estimate.contacts)
            )
        offsets = self._stance_ankle.update(
            estimate.base.angular_velocity, lean, support_state.support, plan.progress
        )
        torso = torso[0] + offsets.pitch[0], torso[1] + offsets.pitch[1]
        ground_alignment_active = self._align_to_ground(estimate, dt)
        common = self._release_common(dt)
        angles = self._solve(plan, lift)
        self._backward_step.add(angles)
        if self._compensates:
            if self._pose.by_pose:  # slow: the encoders lag by deflection, not by delay
                self._compliance.adapt(frame.position, dt)
            self._compliance.compensate(angles, plan)
        turns = [
            self._turn_ankle(
                side,
                angles,
                in_foot_axes(plan, side, (swing[side].roll, swing[side].pitch)),
                in_foot_axes(plan, side, (offsets.roll[i], torso[i])),
                support_state,
                frame,
                dt,
            )
            for i, side in enumerate(SIDES)
        ]
        (left_roll, left_pitch), (right_roll, right_pitch) = turns
        if self._compensates:
            self._compliance.sent(angles)
        roll, pitch = (left_roll, right_roll), (left_pitch, right_pitch)
        return tuple(angles), Corrections(lift, roll, pitch, torso, common, ground_alignment_active)

    def _lift(
        self, plan: Plan, support_state: SupportState, frame: SensorFrame, delay: float, dt: float
    ) -> Vec2:
        """Height of both feet over the plan by the leg admittance, m."""
        if self._legs is None:
            return 0.0, 0.0
        forces = sum(frame.fsr[:4]), sum(frame.fsr[4:])
        return self._legs.update(plan, support_state, forces, dt, delay=delay)

    def _align_to_ground(self, estimate: Estimate, dt: float) -> bool:
        """Turn the plan onto the estimated ground.

        Returns:
            Whether the plan is still off the ground.
        """
        found, step = estimate.ground, self._ground_rate * dt
        self._ground = tuple(  # type: ignore[assignment]
            now + min(max(goal - now, -step), step) for now, goal in zip(self._ground, found, strict=True)
        )
        return step > 0.0 and any(
            abs(goal - now) > _ALIGNED_TOLERANCE for now, goal in zip(self._ground, found, strict=True)
        )

    def _release_common(self, dt: float) -> Vec2:
        """Release the common turn of both ankles into the ground's tilt; the stance feet keep their angles.

        A plan turned one way and both soles turned the other cancel, so the two would drift apart.
        """
        if self._ankles is None:
            return 0.0, 0.0
        bound = self._common_rate * dt
        left, right = self._ankles["L"].held, self._ankles["R"].held
        roll = _common(left[0], right[0], bound)
        pitch = _common(left[1], right[1], bound)
        for ankle in self._ankles.values():
            ankle.reduce(roll, pitch)
        self._ground = self._ground[0] + roll, self._ground[1] + pitch
        return roll, pitch

    def _solve(self, plan: Plan, lift: Vec2) -> list[float]:
        """Angles as corrected; where out of reach, as planned on level ground; then those of the last cycle.

        Before a walk its plan is checked to be in reach; a capture step is not.
        """
        for planned, ground in ((_lifted(plan, lift), self._ground), (plan, None)):
            try:
                self._solved = self._pose.unlimited_angles(planned, ground)
                break
            except UnreachableError:
                continue
        return list(self._solved)

    def _turn_ankle(
        self,
        side: Side,
        angles: list[float],
        swing: Vec2,
        torso: Vec2,
        support_state: SupportState,
        frame: SensorFrame,
        dt: float,
    ) -> Vec2:
        """Add the corrections to one ankle's joints, in place.

        Args:
            side: of the ankle.
            angles: of the joints, 25 slots, rad.
            swing: turn of the swing foot, roll and pitch, rad.
            torso: offsets by torso control and damping, likewise.
            support_state: roles of the legs.
            frame: newest sensor frame.
            dt: time since the last cycle, s.

        Returns:
            Offsets of roll and pitch without torso control, rad.
        """
        pitch_slot, roll_slot = INDEX[f"{side}AnklePitch"], INDEX[f"{side}AnkleRoll"]
        ankle = self._ranges[side]
        pitch = ankle.clip_pitch(angles[pitch_slot] + swing[1] + torso[1])
        roll = ankle.clip_roll(angles[roll_slot] + swing[0] + torso[0], pitch)
        turn = (0.0, 0.0)
        if self._ankles is not None:
            # The ranges less the planned angles: an offset of zero is always allowed, so that a plan cut off by
            # its range is not stored as an offset.
            lower, upper = ankle.roll_range(pitch)
            limits = AnkleLimits(lower - roll, upper - roll, ankle.lower - pitch, ankle.upper - pitch)
            forces = frame.fsr[:4] if side == "L" else frame.fsr[4:]
            turn = self._ankles[side].update(
                forces, support_state.role(side), dt, limits, progress=support_state.progress
            )
        angles[pitch_slot] = ankle.clip_pitch(pitch + turn[1])
        angles[roll_slot] = ankle.clip_roll(roll + turn[0], angles[pitch_slot])
        return swing[0] + turn[0], swing[1] + turn[1]


def _sole_support(support: Support, contacts: Contacts) -> Support:
    """The planned support; `both` while the swing foot touches: torso control acts until then (thesis 4.2)."""
    return "both" if support != "both" and contacts.of(OTHER_SIDE[support]) else support


def in_foot_axes(plan: Plan, side: Side, turn: Vec2) -> Vec2:
    """A small turn about the torso's axes, which head along the mean of both soles, about those of a foot."""
    return Pose2D(yaw=plan.middle.yaw - plan.foot(side).yaw).point(*turn)


def _common(left: float, right: float, bound: float) -> float:
    """Common part of two numbers, at most `bound`."""
    if left * right <= 0.0:
        return 0.0
    return math.copysign(min(abs(left), abs(right), bound), left)


def _lifted(plan: Plan, lift: Vec2) -> Plan:
    if lift == (0.0, 0.0):
        return plan
    return replace(plan, left=_raised(plan.left, lift[0]), right=_raised(plan.right, lift[1]))


def _raised(foot: SolePose, by: float) -> SolePose:
    return foot._replace(z=foot.z + by)


def _torso_control(parameters: ControllerParameters, cycle: float) -> TorsoControl | None:
    method = parameters.switches.torso
    if method == "none":
        return None
    controller = parameters.torso_design.controller(method, cycle)
    return TorsoControl(controller, parameters.torso_limits)
