"""Where the robot is by its own sensors: forward kinematics, the fused angle, and the foot it stands on.

Nothing on a NAO measures its place or heading. The foot that bears more of the weight is taken to stand still;
what the other links do about it is the way walked. Slip, bent joints and the gyroscope's drift are not seen,
which is why the ground truth stands beside it where there is one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from bridge.datasheet import Body
from bridge.datasheet.model import Side
from bridge.datasheet.sole import foot_centre, sole_hull
from bridge.messages import Quaternion, SensorFrame, TruthFrame
from walker.kinematics.com import CentreOfMass
from walker.kinematics.transforms import Array, R_yaw, Transform, homogeneous, rotation

SWITCH: Final = 0.6
"""Share of the weight at which a foot becomes the one that stands; beyond a half, or it would flicker."""
SIDES: Final[tuple[Side, Side]] = ("L", "R")


class Plane(NamedTuple):
    """A pose on the ground."""

    x: float = 0.0
    """m"""
    y: float = 0.0
    """m"""
    yaw: float = 0.0
    """rad"""

    @property
    def transform(self) -> Transform:
        """Shape (4, 4)."""
        return homogeneous(R_yaw(self.yaw), (self.x, self.y, 0.0))

    def point(self, point: Sequence[float]) -> tuple[float, float]:
        """A point of this pose's frame in the frame of the pose, x and y, m."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return self.x + c * point[0] - s * point[1], self.y + s * point[0] + c * point[1]


class Placed(NamedTuple):
    """A robot in the world, z up, m."""

    frames: Array
    """Of all links, shape (links, 4, 4), in the order of `Figure.links`."""
    com: Array
    """Centre of mass, shape (3,)."""
    feet: dict[Side, Transform]
    """AnkleRoll frames."""


class Floor(NamedTuple):
    """A tilted plane through a point under which the world's origin lies."""

    roll: float = 0.0
    """rad; the orientation is Ry(pitch) Rx(roll)."""
    pitch: float = 0.0
    """rad"""
    height: float = 0.0
    """Of the plane at the world's origin, m."""

    @property
    def normal(self) -> Array:
        """Unit vector, shape (3,)."""
        return rotation(self.roll, self.pitch, 0.0)[:, 2]

    def at(self, x: float, y: float) -> float:
        """Height of the floor, m."""
        n = self.normal
        return self.height - float(n[0] * x + n[1] * y) / float(n[2])


LEVEL: Final = Floor()


class Figure:
    """Places a body's links in the world.

    Args:
        body: The data sheet.
    """

    def __init__(self, body: Body) -> None:
        self._com = CentreOfMass(body)
        self.links = self._com.tree.links
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
        """Link frames in the Torso frame, shape (links, 4, 4); `position` are the 25 angles, rad."""
        return self._com.tree.frames(position)

    def place(self, in_torso: Array, torso: Transform) -> Placed:
        """The robot with its torso at a pose of the world, shape (4, 4)."""
        frames = torso @ in_torso
        feet = {side: frames[i] for side, i in self._feet.items()}
        return Placed(frames, self._com.of_frames(frames), feet)

    def true(self, truth: TruthFrame) -> Placed:
        """As the ground truth says."""
        torso = homogeneous(quaternion_rotation(truth.torso_orientation), truth.torso_position)
        return self.place(self.in_torso(truth.joints), torso)

    def sole_middle(self, feet: dict[Side, Transform]) -> Plane:
        """Middle between both soles, and the mean of their headings."""
        x, y = np.mean([(feet[side] @ self.centres[side])[:2] for side in SIDES], axis=0)
        forward = np.sum([feet[side][:2, 0] for side in SIDES], axis=0)
        return Plane(float(x), float(y), math.atan2(forward[1], forward[0]))

    def sole_in_world(self, side: Side, foot: Transform) -> Array:
        """Corners of a sole, shape (n, 3), m."""
        corners: Array = (self.soles[side] @ foot.T)[:, :3]
        return corners


class Odometry:
    """Places the robot frame by frame by its sensors alone.

    Args:
        figure: Of the body.
        start: Where the middle of the soles is at the first frame.
    """

    def __init__(self, figure: Figure, start: Plane = Plane()) -> None:  # noqa: B008 (frozen)
        self._figure = figure
        self._start: Plane | None = start
        self.stance: Side = "L"
        """The foot that is taken to stand."""
        self._at = Plane()

    def update(self, frame: SensorFrame, floor: Floor = LEVEL) -> Placed:
        """One frame; the lowest corner of the standing sole is put on the floor."""
        in_torso = self._figure.in_torso(frame.position)
        level = homogeneous(rotation(*frame.angle, 0.0), (0.0, 0.0, 0.0))
        placed = self._figure.place(in_torso, level)
        if self._start is not None:
            here = self._figure.sole_middle(placed.feet)
            turn = Plane(yaw=self._start.yaw - here.yaw)
            x, y = turn.point((here.x, here.y))
            torso = Plane(self._start.x - x, self._start.y - y, turn.yaw)
            self._start = None
            self._at = self._of_sole(self._figure.place(in_torso, torso.transform @ level))
        placed = self._on_floor(in_torso, self._about_stance(placed) @ level, floor)
        left, right = sum(frame.fsr[:4]), sum(frame.fsr[4:])
        heavier: Side = "L" if left > right else "R"
        if heavier != self.stance and max(left, right) > SWITCH * (left + right):
            self.stance = heavier
            self._at = self._of_sole(placed)
        return placed

    def _about_stance(self, level: Placed) -> Transform:
        """Where the torso is on the ground, so that the standing sole keeps its place and heading."""
        here = self._of_sole(level)
        turn = Plane(yaw=self._at.yaw - here.yaw)
        x, y = turn.point((here.x, here.y))
        return Plane(self._at.x - x, self._at.y - y, turn.yaw).transform

    def _of_sole(self, placed: Placed) -> Plane:
        foot = placed.feet[self.stance]
        x, y = (foot @ self._figure.centres[self.stance])[:2]
        return Plane(float(x), float(y), math.atan2(foot[1, 0], foot[0, 0]))

    def _on_floor(self, in_torso: Array, torso: Transform, floor: Floor) -> Placed:
        foot = self._figure.place(in_torso, torso).feet[self.stance]
        corners = self._figure.sole_in_world(self.stance, foot)
        rise = max(floor.at(x, y) - z for x, y, z in corners)
        raised = torso.copy()
        raised[2, 3] += rise
        return self._figure.place(in_torso, raised)


def quaternion_rotation(xyzw: Quaternion) -> Array:
    """Rotation matrix of a unit quaternion (x, y, z, w), shape (3, 3)."""
    x, y, z, w = xyzw
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
