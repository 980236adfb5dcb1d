"""Links, centre of mass and feet of a robot whose torso has a pose in the world (a floating base)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bridge.body import Body
from bridge.body.sole import foot_centre, sole_hull
from bridge.types import SIDES, Array, Side
from walker.model.com import CentreOfMass
from walker.model.transforms import Transform


@dataclass(frozen=True)
class RobotPose:
    """A robot in the world, z up, m."""

    frames: Array
    """Of all links, shape (links, 4, 4), in the order of `FloatingBase.links`."""
    feet: dict[Side, Transform]
    """AnkleRoll frames."""
    mass: CentreOfMass
    """Of the body."""

    @cached_property
    def com(self) -> Array:
        """Centre of mass, shape (3,)."""
        return self.mass.of_frames(self.frames)


class FloatingBase:
    """Forward kinematics of all links of a body in the world.

    Args:
        body: The data sheet.
    """

    def __init__(self, body: Body) -> None:
        self.body = body
        """The data sheet."""
        self._mass = CentreOfMass(body)
        self._newest: tuple[tuple[float, ...], Array] | None = None
        """Joint angles of the last call of `in_torso`, and their link frames."""
        self.links = self._mass.tree.links
        """The Torso, then the joints whose links follow."""
        self._feet = {side: self.links.index(f"{side}AnkleRoll") for side in SIDES}
        self.soles: dict[Side, Array] = {}
        """Corners of each sole's bottom, homogeneous, AnkleRoll frame, shape (n, 4), m."""
        for side in SIDES:
            hull = sole_hull(body, side)
            low = np.full(len(hull), -body.lengths.FootHeight)
            self.soles[side] = np.column_stack([hull, low, np.ones(len(hull))])
        self.centres: dict[Side, Array] = {
            side: np.array([*foot_centre(body, side), -body.lengths.FootHeight, 1.0]) for side in SIDES
        }
        """Middle of each sole (FM), as `soles`, shape (4,)."""

    def in_torso(self, position: Sequence[float]) -> Array:
        """Link frames in the Torso frame, computed once for all who ask for them in a cycle.

        Args:
            position: the 25 joint angles of a frame, rad.

        Returns:
            Shape (links, 4, 4), m; not to be written to.
        """
        angles = tuple(position)
        if self._newest is None or self._newest[0] != angles:
            self._newest = angles, self._mass.tree.frames(angles)
        return self._newest[1]

    def foot(self, in_torso: Array, side: Side) -> Transform:
        """Pose of one AnkleRoll frame in the Torso frame, shape (4, 4), m.

        Args:
            in_torso: link frames as `in_torso` gives them.
            side: of the foot.
        """
        frame: Transform = in_torso[self._feet[side]]
        return frame

    def place(self, in_torso: Array, torso: Transform) -> RobotPose:
        """The robot with its torso at a pose in the world.

        Args:
            in_torso: link frames as `in_torso` gives them.
            torso: pose of the Torso frame in the world, shape (4, 4), m.
        """
        frames = torso @ in_torso
        feet = {side: frames[i] for side, i in self._feet.items()}
        return RobotPose(frames, feet, self._mass)

    def sole_in_world(self, side: Side, foot: Transform) -> Array:
        """Corners of a sole, shape (n, 3), m.

        Args:
            side: of the foot.
            foot: pose of its AnkleRoll frame in the world, shape (4, 4), m.
        """
        corners: Array = (self.soles[side] @ foot.T)[:, :3]
        return corners
