"""From a plan in the walk frame to joint angles: place the torso, then solve the legs.

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

import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, LEG_SLOTS, N_JOINTS
from bridge.rotations import rotation
from bridge.types import Array, Vec2
from walker.model.arms import ARMS
from walker.model.com import CentreOfMass
from walker.model.inverse import solve_legs
from walker.model.limits import AnkleRange
from walker.model.transforms import Transform, homogeneous
from walker.planning.plan import Foothold, Plan, SolePose

_REFINEMENTS: Final = 2
"""Rounds, at most, of placing the torso by the centre of mass of the pose, each leaves a third of 15 mm, and
of turning it, each leaves a hundredth of the 3 degrees where the mass is not placed anew, else a quarter."""
_TURN_TOLERANCE: Final = 1e-6
"""Turn of both feet that is left as it is, rad: less than a thousandth of an encoder's step."""
_ROLL_RESERVE: Final = math.radians(1.0)
"""Kept free of the HipRoll's range for what the stabilizers add, rad."""

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
            plan: the plan, in a frame that lies on the ground.
            ground: roll and pitch of the ground as `GroundTilt` finds them, rad. The torso stays upright with
                its centre of mass over the planned point, and comes down where a foot would be out of reach.
                None: level ground, as planned.

        Raises:
            UnreachableError: a foot is out of the leg's reach.
        """
        turn = np.eye(3) if ground is None else rotation(*ground, 0.0)
        give = ground is not None
        heading, com = plan.middle.yaw, self._com_in_torso
        left_over = self._place(plan, heading, com, turn, give=give)
        # Soles that point the same way need no turn of the torso. On tilted ground they keep what is left over.
        turned = plan.left.yaw != plan.right.yaw
        for _ in range(_REFINEMENTS):
            if not (self.by_pose or (turned and abs(left_over) > _TURN_TOLERANCE)):
                break
            if self.by_pose:
                place = self._com(self._angles)
                com = float(place[0]), float(place[1])
            if turned:
                heading -= left_over
            left_over = self._place(plan, heading, com, turn, give=give)
        return tuple(self._angles)

    def _place(
        self, plan: Plan, heading: float, com_in_torso: Vec2, turn: Array, *, give: bool = False
    ) -> float:
        """Solve the legs for the torso over the plan.

        Args:
            plan: the plan.
            heading: of the torso, rad.
            com_in_torso: the centre of mass in the torso, x and y, m.
            turn: axes of the ground in a frame with z up, shape (3, 3).
            give: lower the torso where a foot would be out of reach.

        Returns:
            Turn of both feet beyond the planned yaw, rad.
        """
        # Frame of the feet here: z up, x along the heading, origin at the planned point on the ground.
        origin = Foothold(*plan.com, heading)
        left, right = (self._ankle(foot.seen_from(origin), turn) for foot in (plan.left, plan.right))
        height = plan.hip_height
        # A leg that leans inwards ends at its HipRoll's range.
        upper = left[1, 3] - self._half_hip + self._lean * (height - self._standing(plan.left, left))
        lower = right[1, 3] + self._half_hip - self._lean * (height - self._standing(plan.right, right))
        x, y = -com_in_torso[0], min(max(-com_in_torso[1], lower), upper)
        if give:
            height = min(
                height,
                self._highest(left[:3, 3] - (x, y + self._half_hip, 0.0)),
                self._highest(right[:3, 3] - (x, y - self._half_hip, 0.0)),
            )
        torso = (x, y, height + self._hip)
        for ankle in (left, right):
            ankle[:3, 3] -= torso
        legs = solve_legs(self._body, left, right)
        for side, solved in (("L", legs.left), ("R", legs.right)):
            for slot, angle in zip(LEG_SLOTS[side], solved, strict=True):
                self._angles[slot] = angle
        return legs.yaw

    def _ankle(self, foot: SolePose, turn: Array) -> Transform:
        """Ankle pose (frame 8) in a frame with z up, of a sole in one that is turned by `turn` against it."""
        axes = turn @ rotation(foot.roll, foot.pitch, foot.yaw)
        place = turn @ (foot.x, foot.y, foot.z)
        return homogeneous(axes, place + self._foot_height * axes[:, 2])

    def _highest(self, ankle: Array) -> float:
        """Greatest height of a hip joint over an ankle's place below it (x, y from the hip, z), m."""
        across = self._stretched**2 - float(ankle[0]) ** 2 - float(ankle[1]) ** 2
        return float(ankle[2]) + math.sqrt(max(across, 0.0))

    @staticmethod
    def _standing(foot: SolePose, ankle: Transform) -> float:
        """Height of an ankle when its foot stands, m."""
        return float(ankle[2, 3]) - foot.z

    def _standing_com(self, stand: Plan) -> Vec2:
        """Centre of mass in the torso of the pose that brings it over the planned point, x and y, m."""
        found = (0.0, 0.0)
        for _ in range(30):  # a fixed point: the legs lag the torso with a third of its mass, 3^-30 is nothing
            self._place(stand, stand.middle.yaw, found, np.eye(3))
            place = self._com(self._angles)
            found = (float(place[0]), float(place[1]))
        return found
