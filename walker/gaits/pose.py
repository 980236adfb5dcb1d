"""Inverse kinematics of a plan in the walk frame: place the torso, then solve the legs.

The torso stays upright, and its place follows from the planned centre of mass, which the thesis takes as
fixed in the torso (3.3.1). Taken from the standing pose, it is 15 mm off towards the swing leg in single
support on an H21: a margin of 27 mm is left to the inner edge of the sole. With `by_pose` the torso is shifted
after the centre of mass of the pose itself, as far as HipRoll allows: 8 of those 15 mm at l_GH = 170 mm.

The torso heads along the mean of both soles' yaws, so that the one HipYawPitch motor turns both legs by
half the angle between the soles (2.24). In legs that lean to one side the same motor angle turns both soles by
some degrees more in common; the torso is turned back by that.
"""

from __future__ import annotations

import math
from typing import Final

from bridge.body import Body
from bridge.body.inverse_kinematics import FootPose, solve_legs
from bridge.body.joints import INDEX, LEG_SLOTS, N_JOINTS
from bridge.body.kinematics import CentreOfMass
from bridge.body.leg_limits import AnkleRange
from bridge.planar import Pose2D
from bridge.rotations import rotation_rows
from bridge.types import Matrix3, Vec2, Vec3
from walker.gaits.plan import Plan, SolePose

ARMS: Final = {
    "LShoulderPitch": 1.5,
    "LShoulderRoll": 0.15,
    "LElbowYaw": -1.2,
    "LElbowRoll": -0.4,
    "RShoulderPitch": 1.5,
    "RShoulderRoll": -0.15,
    "RElbowYaw": 1.2,
    "RElbowRoll": 0.4,
}
"""Arms hanging at the sides, elbows a little bent, clear of the legs; rad."""


_REFINEMENTS: Final = 2
"""Rounds, at most, of placing the torso by the centre of mass of the pose, each leaves a third of 15 mm, and
of turning it, each leaves a hundredth of the 3 degrees where the mass is not placed again, else a quarter."""
_TURN_TOLERANCE: Final = 1e-4
"""Remaining turn of both feet that is ignored, rad: under a tenth of an encoder's step. Solving the legs again
takes a tenth of a tick."""
_ROLL_RESERVE: Final = math.radians(1.0)
"""Kept free of the HipRoll's range for the corrections, rad."""

_LEAST_KNEE: Final = math.radians(12.0)
"""Angle of the knee at which a leg counts as stretched, rad: a straight one has no speed left along itself."""


class PoseMaker:
    """Turns plans into 25 joint angles.

    Args:
        body: data sheet.
        stand: the standing plan, whose centre of mass in the torso is kept.
        by_pose: place the torso by the centre of mass of each pose instead. For gaits in which the planned
            centre of mass is at rest over a foot; in a dynamic one the masses' inertia counts as much.

    Raises:
        UnreachableError: the standing plan is out of the legs' reach.
    """

    def __init__(self, body: Body, stand: Plan, *, by_pose: bool = False) -> None:
        self._body = body
        self.by_pose = by_pose
        """The torso is placed by the centre of mass of each pose."""
        self._hip = body.lengths.HipOffsetZ
        self._foot_height = body.lengths.FootHeight
        self._angles = [0.0] * N_JOINTS
        for joint, angle in ARMS.items():
            self._angles[INDEX[joint]] = angle
        self._ankles = {"L": AnkleRange(body, "L"), "R": AnkleRange(body, "R")}
        self._com = CentreOfMass(body)
        self._lean = math.tan(-body.joints["LHipRoll"].lower - _ROLL_RESERVE)
        thigh, tibia = body.lengths.ThighLength, body.lengths.TibiaLength
        self._stretched = math.sqrt(thigh**2 + tibia**2 + 2.0 * thigh * tibia * math.cos(_LEAST_KNEE))
        self._half_hip = body.lengths.HipOffsetY
        self._com_in_torso = self._standing_com(stand)

    def angles(self, plan: Plan) -> tuple[float, ...]:
        """Joint angles for a plan within the joints' ranges, 25 slots, rad.

        Raises:
            UnreachableError: a foot is out of the leg's reach.
        """
        angles = list(self.unlimited_angles(plan))
        for side, ankle in self._ankles.items():
            pitch, roll = INDEX[f"{side}AnklePitch"], INDEX[f"{side}AnkleRoll"]
            angles[pitch] = ankle.clip_pitch(angles[pitch])
            angles[roll] = ankle.clip_roll(angles[roll], angles[pitch])
        return tuple(angles)

    def unlimited_angles(self, plan: Plan, ground: Vec2 | None = None) -> tuple[float, ...]:
        """As `angles`, the joints' ranges left aside, on ground that may be tilted.

        Args:
            plan: the plan, in a frame on the ground.
            ground: roll and pitch of the ground as `GroundTilt` finds them, rad. The torso stays upright with
                its centre of mass over the planned point, and sinks where a foot would be out of reach.
                None: level ground, as planned.

        Raises:
            UnreachableError: a foot is out of the leg's reach.
        """
        tilt = rotation_rows(*ground, 0.0) if ground is not None and any(ground) else None
        give = ground is not None
        heading, com = plan.middle.yaw, self._com_in_torso
        left_over = self._place(plan, heading, com, tilt, give=give)
        # Soles of equal heading need no turn of the torso. On tilted ground they keep the remaining turn.
        turned = plan.left.yaw != plan.right.yaw
        for _ in range(_REFINEMENTS):
            if not (self.by_pose or (turned and abs(left_over) > _TURN_TOLERANCE)):
                break
            if self.by_pose:
                place = self._com(self._angles)
                com = float(place[0]), float(place[1])
            if turned:
                heading -= left_over
            left_over = self._place(plan, heading, com, tilt, give=give)
        return tuple(self._angles)

    def _place(
        self, plan: Plan, heading: float, com_in_torso: Vec2, tilt: Matrix3 | None, *, give: bool = False
    ) -> float:
        """Solve the legs for the torso over the plan.

        Args:
            plan: the plan.
            heading: of the torso, rad.
            com_in_torso: the centre of mass in the torso, x and y, m.
            tilt: rotation of the ground in a frame with z up; None: level.
            give: lower the torso where a foot would be out of reach.

        Returns:
            Turn of both feet beyond the planned yaw, rad.
        """
        # Frame of the feet here: z up, x along the heading, origin at the planned point on the ground.
        origin = Pose2D(*plan.com, heading)
        left = self._ankle(plan.left.expressed_in(origin), tilt)
        right = self._ankle(plan.right.expressed_in(origin), tilt)
        height, half = plan.hip_height, self._half_hip
        # A leg that leans inwards ends at its HipRoll's range.
        upper = left.place[1] - half + self._lean * (height - (left.place[2] - plan.left.z))
        lower = right.place[1] + half - self._lean * (height - (right.place[2] - plan.right.z))
        x, y = -com_in_torso[0], min(max(-com_in_torso[1], lower), upper)
        if give:
            reach = self._highest(left.place, x, y + half), self._highest(right.place, x, y - half)
            height = min(height, *reach)
        torso = (x, y, height + self._hip)
        legs = solve_legs(self._body, _expressed_in(left, torso), _expressed_in(right, torso))
        for side, solved in (("L", legs.left), ("R", legs.right)):
            for slot, angle in zip(LEG_SLOTS[side], solved, strict=True):
                self._angles[slot] = angle
        return legs.yaw

    def _ankle(self, foot: SolePose, tilt: Matrix3 | None) -> FootPose:
        """Ankle (frame 8) in a frame with z up, of a sole in one on tilted ground."""
        axes = rotation_rows(foot.roll, foot.pitch, foot.yaw)
        x, y, z = foot.x, foot.y, foot.z
        if tilt is not None:
            axes = _product(tilt, axes)
            x, y, z = (a * x + b * y + c * z for a, b, c in tilt)
        (_, _, a_x), (_, _, a_y), (_, _, a_z) = axes
        h = self._foot_height
        return FootPose((x + h * a_x, y + h * a_y, z + h * a_z), axes)

    def _highest(self, ankle: Vec3, x: float, y: float) -> float:
        """Greatest height of the hip joint at (x, y) over an ankle, m."""
        across = self._stretched**2 - (ankle[0] - x) ** 2 - (ankle[1] - y) ** 2
        return ankle[2] + math.sqrt(max(across, 0.0))

    def _standing_com(self, stand: Plan) -> Vec2:
        """Centre of mass in the torso of the pose that brings it over the planned point, x and y, m."""
        offset = (0.0, 0.0)
        for _ in range(30):  # a fixed point: the legs lag the torso with a third of its mass, 3^-30 is nothing
            self._place(stand, stand.middle.yaw, offset, None)
            place = self._com(self._angles)
            offset = (float(place[0]), float(place[1]))
        return offset


def _product(a: Matrix3, b: Matrix3) -> Matrix3:
    (b00, b01, b02), (b10, b11, b12), (b20, b21, b22) = b
    first, second, third = (
        (x * b00 + y * b10 + z * b20, x * b01 + y * b11 + z * b21, x * b02 + y * b12 + z * b22) for x, y, z in a
    )
    return first, second, third


def _expressed_in(foot: FootPose, torso: Vec3) -> FootPose:
    (x, y, z), (t_x, t_y, t_z) = foot.place, torso
    return FootPose((x - t_x, y - t_y, z - t_z), foot.axes)
