"""The stabilising controllers on top of a plan: which joint angles to ask for in this cycle.

In order: the leg admittances move the planned feet up or down; inverse kinematics; what the drives will give
way by is added; torso control turns the ankles of the stance leg, the ankle admittances those of the swing
leg; joint ranges.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final, NamedTuple

from bridge.datasheet import Body
from bridge.datasheet.model import Side
from bridge.joints import INDEX
from bridge.messages import SensorFrame, Vec2
from walker.admittance import AnkleAdmittance, AnkleLimits, LegAdmittance
from walker.errors import UnreachableError
from walker.estimation import Estimate
from walker.footing import Footing
from walker.gait import Foot, Reference
from walker.kinematics.limits import AnkleRange
from walker.levelling import Level, Levelling
from walker.parameters.model import ControllerParameters
from walker.pose import PoseMaker
from walker.sag import Sag
from walker.torso.damping import Damping, GyroDamping
from walker.torso.filter import TorsoControl

_SIDES: Final[tuple[Side, Side]] = ("L", "R")
_RIGHTED: Final = math.radians(0.5)
"""Difference of the plan's ground from that found at which the walk may begin, rad."""


class Corrections(NamedTuple):
    """What the stabilisers added to the plan, left and right."""

    lift: Vec2 = (0.0, 0.0)
    """Height of the feet over the plan (leg admittance, levelling), m."""
    ankle_roll: Vec2 = (0.0, 0.0)
    """AnkleRoll (ankle admittance, levelling), rad."""
    ankle_pitch: Vec2 = (0.0, 0.0)
    """AnklePitch (ankle admittance, levelling), rad."""
    torso: Vec2 = (0.0, 0.0)
    """AnklePitch (torso control, its damping included), rad."""
    shared: Vec2 = (0.0, 0.0)
    """What both ankles held in common and gave up to the ground's tilt in this cycle, roll and pitch, rad."""

    @property
    def soles(self) -> tuple[Vec2, Vec2]:
        """Roll and pitch by which the left and the right sole were turned against the plan, rad."""
        return (self.ankle_roll[0], self.ankle_pitch[0]), (self.ankle_roll[1], self.ankle_pitch[1])


class Stabiliser:
    """Turns plans into joint angles, corrected by what the sensors say.

    Args:
        body: data sheet.
        parameters: which controllers are on, and their numbers.
        pose: inverse kinematics of the plan.
        cycle: of the robot, s.

    Raises:
        ConfigurationError: no torso controller can be designed to the specification.
    """

    def __init__(self, body: Body, parameters: ControllerParameters, pose: PoseMaker, cycle: float) -> None:
        self._pose = pose
        self._sag = Sag(parameters.sag, body, cycle) if parameters.sag.share else None
        self._foot_height = body.lengths.FootHeight
        self._ranges = {side: AnkleRange(body, side) for side in _SIDES}
        self._legs = self._ankles = None
        if parameters.admittance:
            self._legs = {side: LegAdmittance(parameters.leg) for side in _SIDES}
            self._levelling = Levelling(parameters.levelling)
        if parameters.admittance and parameters.ankle_admittance:
            self._ankles = {side: AnkleAdmittance(parameters.ankle, body, side) for side in _SIDES}
        self._shared_rate = parameters.ground.shared_rate if parameters.ground.time_constant else 0.0
        self._ground_rate = parameters.ground.rate if parameters.admittance else 0.0
        self._ground: Vec2 = (0.0, 0.0)
        self.righting = False
        """The plan is more than half a degree off the ground as it was found, and is being turned onto it."""
        self._level_rate = parameters.level_rate
        self._torso = _torso_control(parameters, cycle)
        self._damping = GyroDamping(parameters.damping, cycle) if parameters.torso == "robust" else None
        self.corrections = Corrections()
        """Of the last cycle."""

    def watch(self, estimate: Estimate) -> None:
        """Take in a cycle in which nothing is to be corrected yet, so that the filters settle."""
        if self._torso is not None:
            self._torso.update(estimate.angle[1], "both")

    def angles(
        self, reference: Reference, footing: Footing, estimate: Estimate, frame: SensorFrame, dt: float
    ) -> tuple[float, ...]:
        """One cycle, once per received frame.

        Args:
            reference: the plan.
            footing: roles of the legs.
            estimate: contacts and torso angle.
            frame: newest sensor frame.
            dt: time since the last one, s.

        Returns:
            25 joint angles within their ranges, rad.
        """
        levels = dict.fromkeys(_SIDES, Level())
        if self._legs is not None:
            angle = estimate.angle if self._torso is not None else (estimate.angle[0], 0.0)
            levels = self._levelling.update(angle, reference, footing, estimate.contacts, dt)
        left, right = self._lift(reference, footing, frame, estimate.delay, dt)
        lift = left + levels["L"].lift, right + levels["R"].lift
        torso = (
            self._torso.update(estimate.angle[1], footing.support) if self._torso is not None else (0.0, 0.0)
        )
        damping = Damping()
        if self._damping is not None:
            damping = self._damping.update(frame.gyroscope, footing.support)
            torso = torso[0] + damping.pitch[0], torso[1] + damping.pitch[1]
        self._lay_on_ground(estimate, dt)
        shared = self._share(dt)
        angles = self._solve(reference, lift)
        if self._sag is not None:
            if self._pose.by_pose:  # slow: what the encoders lag by is sag, not delay
                self._sag.learn(frame.position, dt)
            self._sag.compensate(angles, reference)
        turns = [
            self._turn_ankle(side, angles, levels[side], (damping.roll[i], torso[i]), footing, frame, dt)
            for i, side in enumerate(_SIDES)
        ]
        (left_roll, left_pitch), (right_roll, right_pitch) = turns
        if self._sag is not None:
            self._sag.sent(angles)
        self.corrections = Corrections(lift, (left_roll, right_roll), (left_pitch, right_pitch), torso, shared)
        return tuple(angles)

    def _lift(
        self, reference: Reference, footing: Footing, frame: SensorFrame, delay: float, dt: float
    ) -> Vec2:
        """Height of both feet over the plan by the leg admittance, m."""
        if self._legs is None:
            return 0.0, 0.0
        lift = []
        self._keep_level(self._legs["L"], self._legs["R"], dt)
        for side, foot, fsr in (
            (_SIDES[0], reference.left, frame.fsr[:4]),
            (_SIDES[1], reference.right, frame.fsr[4:]),
        ):
            lift.append(
                self._legs[side].update(
                    sum(fsr),
                    footing.role(side),
                    dt,
                    progress=footing.progress,
                    ankle_z=foot.z + self._foot_height - reference.hip_height,
                    search=footing.search,
                    delay=delay,
                )
            )
        return lift[0], lift[1]

    def _keep_level(self, left: LegAdmittance, right: LegAdmittance, dt: float) -> None:
        """Bring the body back to its planned height over the ground where both feet stand off it.

        Each landing of a body that sags towards its swing foot is a little early. Held, that shortens the leg,
        and the other leg lands early by the more: step by step both legs would fold up. What both feet have in
        common is no unevenness of the ground, so both are lowered by it; what differs between them is kept.
        """
        common = min(left.held, right.held)
        if common < 0.0:
            common = min(max(left.held, right.held), 0.0)
        step = self._level_rate * dt
        by = min(max(common, -step), step)
        left.lower(by)
        right.lower(by)

    def _lay_on_ground(self, estimate: Estimate, dt: float) -> None:
        """Turn the plan onto the ground as it was found. Pitch belongs to torso control, as in levelling."""
        found = estimate.ground if self._torso is not None else (estimate.ground[0], 0.0)
        step = self._ground_rate * dt
        self._ground = tuple(  # type: ignore[assignment]
            now + min(max(goal - now, -step), step) for now, goal in zip(self._ground, found, strict=True)
        )
        self.righting = step > 0.0 and any(
            abs(goal - now) > _RIGHTED for now, goal in zip(self._ground, found, strict=True)
        )

    def _share(self, dt: float) -> Vec2:
        """Count as the ground's what both ankles hold in common; the feet that stand do not move by that.

        A plan turned one way and both soles turned the other come to the same, so the two would drift apart.
        """
        if self._ankles is None:
            return 0.0, 0.0
        most = self._shared_rate * dt
        left, right = self._ankles["L"].held, self._ankles["R"].held
        roll = _common(left[0], right[0], most)
        pitch = _common(left[1], right[1], most) if self._torso is not None else 0.0
        for ankle in self._ankles.values():
            ankle.give_up(roll, pitch)
        self._ground = self._ground[0] + roll, self._ground[1] + pitch
        return roll, pitch

    def _solve(self, reference: Reference, lift: Vec2) -> list[float]:
        try:
            return list(self._pose.unlimited_angles(_lifted(reference, lift), self._ground))
        except UnreachableError:
            # The plan alone, on level ground, was found to be in reach before the walk began.
            return list(self._pose.unlimited_angles(reference))

    def _turn_ankle(
        self,
        side: Side,
        angles: list[float],
        level: Level,
        torso: Vec2,
        footing: Footing,
        frame: SensorFrame,
        dt: float,
    ) -> Vec2:
        """Add the corrections to one ankle's joints, in place.

        Returns:
            What was added to roll and pitch, torso control left aside, rad.
        """
        pitch_slot, roll_slot = INDEX[f"{side}AnklePitch"], INDEX[f"{side}AnkleRoll"]
        ankle = self._ranges[side]
        pitch = ankle.clip_pitch(angles[pitch_slot] + level.pitch + torso[1])
        roll = ankle.clip_roll(angles[roll_slot] + level.roll + torso[0], pitch)
        turn = (0.0, 0.0)
        if self._ankles is not None:
            # The ranges less what is planned: an offset of zero is always allowed, so that a plan which its
            # range cuts short is not stored as an offset.
            lower, upper = ankle.roll_range(pitch)
            limits = AnkleLimits(lower - roll, upper - roll, ankle.lower - pitch, ankle.upper - pitch)
            forces = frame.fsr[:4] if side == "L" else frame.fsr[4:]
            turn = self._ankles[side].update(forces, footing.role(side), dt, limits, progress=footing.progress)
        angles[pitch_slot] = ankle.clip_pitch(pitch + turn[1])
        angles[roll_slot] = ankle.clip_roll(roll + turn[0], angles[pitch_slot])
        return level.roll + turn[0], level.pitch + turn[1]


def _common(left: float, right: float, most: float) -> float:
    """What two numbers have in common, at most `most`."""
    if left * right <= 0.0:
        return 0.0
    return math.copysign(min(abs(left), abs(right), most), left)


def _lifted(reference: Reference, lift: Vec2) -> Reference:
    if lift == (0.0, 0.0):
        return reference
    return replace(reference, left=_raised(reference.left, lift[0]), right=_raised(reference.right, lift[1]))


def _raised(foot: Foot, by: float) -> Foot:
    return Foot(foot.x, foot.y, foot.z + by, foot.pitch)


def _torso_control(parameters: ControllerParameters, cycle: float) -> TorsoControl | None:
    if parameters.torso == "none":
        return None
    # Imported late: it takes a second, and a walk without torso control needs none of it.
    from walker.torso.choice import torso_controller

    controller = torso_controller(parameters.torso, parameters.torso_design, cycle)
    return TorsoControl(controller, parameters.torso_limits)
