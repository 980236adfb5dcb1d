"""From a plan in the walk frame to joint angles: place the torso, then solve the legs.

The torso stays upright, and its place follows from the planned centre of mass, which the thesis takes as
fixed in the torso (3.3.1). Taken from the standing pose, it is 15 mm off towards the swing leg in single
support on an H21: a margin of 27 mm is left to the inner edge of the sole. With `by_pose` the torso is shifted
after the centre of mass of the pose itself, as far as HipRoll allows: 8 of those 15 mm at l_GH = 170 mm.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from bridge.datasheet import Body
from bridge.joints import INDEX, LEG_SLOTS, N_JOINTS
from walker.arms import ARMS
from walker.gait import Foot, Reference
from walker.kinematics.com import CentreOfMass
from walker.kinematics.inverse import solve_legs
from walker.kinematics.limits import AnkleRange
from walker.kinematics.transforms import Transform

_REFINEMENTS: Final = 2
"""Rounds of placing the torso by the pose's own centre of mass; each leaves a third of the 15 mm."""
_ROLL_RESERVE: Final = math.radians(1.0)
"""Kept free of the HipRoll's range for what the stabilisers add, rad."""


class PoseMaker:
    """Turns references into 25 joint angles.

    Args:
        body: data sheet.
        stand: the standing plan, whose centre of mass in the torso is kept.
        by_pose: place the torso by the centre of mass of each pose instead. For gaits in which the planned
            centre of mass is at rest over a foot; in a dynamic one the masses' inertia counts as much.

    Raises:
        UnreachableError: the standing plan is out of the legs' reach.
    """

    def __init__(self, body: Body, stand: Reference, *, by_pose: bool = False) -> None:
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
        self._half_hip = body.lengths.HipOffsetY
        self._com_in_torso = self._standing_com(stand)

    def angles(self, reference: Reference) -> tuple[float, ...]:
        """Joint angles for a plan within the joints' ranges, 25 slots, rad.

        Raises:
            UnreachableError: a foot is out of the leg's reach.
        """
        angles = list(self.unlimited_angles(reference))
        for side, ankle in self._ankles.items():
            pitch, roll = INDEX[f"{side}AnklePitch"], INDEX[f"{side}AnkleRoll"]
            angles[pitch] = ankle.clip_pitch(angles[pitch])
            angles[roll] = ankle.clip_roll(angles[roll], angles[pitch])
        return tuple(angles)

    def unlimited_angles(self, reference: Reference) -> tuple[float, ...]:
        """As `angles`, the joints' ranges left aside.

        Raises:
            UnreachableError: a foot is out of the leg's reach.
        """
        self._place(reference, self._com_in_torso)
        for _ in range(_REFINEMENTS if self.by_pose else 0):
            place = self._com(self._angles)
            self._place(reference, (float(place[0]), float(place[1])))
        return tuple(self._angles)

    def _place(self, reference: Reference, com_in_torso: tuple[float, float]) -> None:
        """Solve the legs for the torso over the plan with this centre of mass in the torso, x and y, m."""
        # A leg that leans inwards ends at its HipRoll's range.
        reach = self._lean * (reference.hip_height - self._foot_height)
        torso = (
            reference.com[0] - com_in_torso[0],
            min(
                max(reference.com[1] - com_in_torso[1], reference.right.y + self._half_hip - reach),
                reference.left.y - self._half_hip + reach,
            ),
            reference.hip_height + self._hip,
        )
        legs = solve_legs(self._body, self._target(reference.left, torso), self._target(reference.right, torso))
        for side, solved in (("L", legs.left), ("R", legs.right)):
            for slot, angle in zip(LEG_SLOTS[side], solved, strict=True):
                self._angles[slot] = angle

    def _standing_com(self, stand: Reference) -> tuple[float, float]:
        """Centre of mass in the torso of the pose that brings it over the planned point, x and y, m."""
        found = (0.0, 0.0)
        for _ in range(30):  # a fixed point: the legs lag the torso with a third of its mass, 3^-30 is nothing
            self._place(stand, found)
            place = self._com(self._angles)
            found = (float(place[0]), float(place[1]))
        return found

    def _target(self, foot: Foot, torso: tuple[float, float, float]) -> Transform:
        """Ankle pose (frame 8) in the torso frame of a sole pose in the walk frame, the torso upright."""
        s, c = math.sin(foot.pitch), math.cos(foot.pitch)
        x = foot.x + self._foot_height * s - torso[0]
        z = foot.z + self._foot_height * c - torso[2]
        return np.array(
            [[c, 0.0, s, x], [0.0, 1.0, 0.0, foot.y - torso[1]], [-s, 0.0, c, z], [0.0, 0.0, 0.0, 1.0]]
        )
