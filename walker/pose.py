"""From a plan in the walk frame to joint angles: place the torso, then solve the legs.

The torso stays upright. Its horizontal place follows from the planned centre of mass: the thesis takes the
centre of mass as fixed in the torso (3.3.1); here the multi-body centre of mass of the commanded pose is
used, brought up to date once a cycle (a fixed-point iteration that contracts about fourfold per cycle,
because the legs below the hips carry about a quarter of the mass that moves against the torso).
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bridge.datasheet import Body
from bridge.joints import INDEX, LEG_SLOTS, N_JOINTS
from walker.gait import Foot, Reference
from walker.kinematics import CentreOfMass, FootTarget, solve_legs

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


class PoseMaker:
    """Turns references into 25 joint angles.

    Args:
        body: data sheet.
    """

    def __init__(self, body: Body) -> None:
        self._body = body
        self._com = CentreOfMass(body)
        self._hip = body.lengths.HipOffsetZ
        self._foot_height = body.lengths.FootHeight
        self._angles = [0.0] * N_JOINTS
        for joint, angle in ARMS.items():
            self._angles[INDEX[joint]] = angle
        self._com_in_torso: tuple[float, float] | None = None

    def angles(self, reference: Reference) -> tuple[float, ...]:
        """Joint angles for a plan, 25 slots, rad.

        Raises:
            UnreachableError: a foot is out of the leg's reach.
        """
        if self._com_in_torso is None:
            self._com_in_torso = (0.0, 0.0)
            for _ in range(20):
                self._solve(reference)
        return self._solve(reference)

    def _solve(self, reference: Reference) -> tuple[float, ...]:
        assert self._com_in_torso is not None
        torso = (
            reference.com[0] - self._com_in_torso[0],
            reference.com[1] - self._com_in_torso[1],
            reference.hip_height + self._hip,
        )
        left, right = solve_legs(
            self._body, self._target(reference.left, torso), self._target(reference.right, torso)
        )
        for side, solved in (("L", left), ("R", right)):
            for slot, angle in zip(LEG_SLOTS[side], solved, strict=True):
                self._angles[slot] = angle
        angles = tuple(self._angles)
        com = self._com(np.asarray(angles))
        self._com_in_torso = (float(com[0]), float(com[1]))
        return angles

    def _target(self, foot: Foot, torso: tuple[float, float, float]) -> FootTarget:
        """Ankle pose of a sole pose, in the torso frame."""
        raise NotImplementedError
