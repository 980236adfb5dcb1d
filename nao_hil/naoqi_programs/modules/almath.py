# ruff: noqa: N801, N816  the vendor's names
"""The module `almath` of the vendor's Python SDK, as far as samples use it: poses, positions, transforms.

Rotations are Rz(wz) Ry(wy) Rx(wx). Lengths in m, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

PI, PI_2, PI_4, _2_PI_ = math.pi, 0.5 * math.pi, 0.25 * math.pi, 2.0 * math.pi
TO_RAD, TO_DEG = math.pi / 180.0, 180.0 / math.pi
AXIS_MASK_X, AXIS_MASK_Y, AXIS_MASK_Z = 1, 2, 4
AXIS_MASK_WX, AXIS_MASK_WY, AXIS_MASK_WZ = 8, 16, 32
AXIS_MASK_NONE, AXIS_MASK_XY, AXIS_MASK_VEL, AXIS_MASK_ROT, AXIS_MASK_ALL = 0, 3, 7, 56, 63


class _Vector:
    """Named numbers with the arithmetic of a vector."""

    NAMES: tuple[str, ...] = ()

    def __init__(self, *values: Any) -> None:
        given = list(values[0]) if len(values) == 1 and isinstance(values[0], Sequence | _Vector) else values
        if given and len(given) != len(self.NAMES):
            raise RuntimeError(f"{type(self).__name__} takes {len(self.NAMES)} numbers, not {len(given)}.")
        for name, value in zip(self.NAMES, given or (0.0,) * len(self.NAMES), strict=True):
            setattr(self, name, float(value))

    def __iter__(self) -> Any:
        return iter(self.toVector())

    def __len__(self) -> int:
        return len(self.NAMES)

    def __getitem__(self, index: int) -> float:
        return self.toVector()[index]

    def toVector(self) -> list[float]:
        """The numbers."""
        return [getattr(self, name) for name in self.NAMES]

    def __add__(self, other: Any) -> Any:
        return type(self)([a + b for a, b in zip(self, other, strict=True)])

    def __sub__(self, other: Any) -> Any:
        return type(self)([a - b for a, b in zip(self, other, strict=True)])

    def __mul__(self, factor: Any) -> Any:
        return type(self)([a * factor for a in self])

    __rmul__ = __mul__

    def __truediv__(self, divisor: float) -> Any:
        return self * (1.0 / divisor)

    def __neg__(self) -> Any:
        return self * -1.0

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and self.toVector() == other.toVector()

    def __hash__(self) -> int:
        return hash(tuple(self))

    def isNear(self, other: Any, epsilon: float = 1e-4) -> bool:
        """Whether each number is within `epsilon` of the other's."""
        return all(abs(a - b) <= epsilon for a, b in zip(self, other, strict=True))

    def norm(self) -> float:
        """Length of the vector."""
        return math.hypot(*self)

    def normalize(self) -> Any:
        """The vector of length 1 in this direction."""
        return self / self.norm()

    def distance(self, other: Any) -> float:
        """Distance of the positions."""
        return math.dist(self.toVector()[:3], other.toVector()[:3])

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({', '.join(f'{n}={v:g}' for n, v in zip(self.NAMES, self, strict=True))})"
        )


class Position2D(_Vector):
    """x, y."""

    NAMES = ("x", "y")
    x: float
    y: float


class Position3D(_Vector):
    """x, y, z."""

    NAMES = ("x", "y", "z")

    def dotProduct(self, other: Any) -> float:
        """The dot product."""
        return float(np.dot(self.toVector(), list(other)))

    def crossProduct(self, other: Any) -> Position3D:
        """The cross product."""
        return Position3D(np.cross(self.toVector(), list(other)).tolist())


class Rotation3D(_Vector):
    """wx, wy, wz."""

    NAMES = ("wx", "wy", "wz")


class Velocity6D(_Vector):
    """xd, yd, zd, wxd, wyd, wzd."""

    NAMES = ("xd", "yd", "zd", "wxd", "wyd", "wzd")


class Position6D(_Vector):
    """x, y, z, wx, wy, wz."""

    NAMES = ("x", "y", "z", "wx", "wy", "wz")


class Pose2D(_Vector):
    """x, y, theta; `a * b` is the pose or position b of the frame a, where a is."""

    NAMES = ("x", "y", "theta")
    x: float
    y: float
    theta: float

    def __mul__(self, other: Any) -> Any:
        if not isinstance(other, Pose2D | Position2D):
            return super().__mul__(other)
        c, s = math.cos(self.theta), math.sin(self.theta)
        place = (self.x + c * other.x - s * other.y, self.y + s * other.x + c * other.y)
        return Pose2D([*place, self.theta + other.theta]) if isinstance(other, Pose2D) else Position2D(place)

    def inverse(self) -> Pose2D:
        """The pose of the frame of reference in this pose's frame."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose2D([-c * self.x - s * self.y, s * self.x - c * self.y, -self.theta])

    def diff(self, other: Pose2D) -> Pose2D:
        """The pose of another one in this pose's frame."""
        diff: Pose2D = self.inverse() * other
        return diff

    def getAngle(self) -> float:
        """Direction from the origin to the pose, rad."""
        return math.atan2(self.y, self.x)


class _List(list[Any]):
    """A list with the names of C++'s vector."""

    push_back = list.append
    size = list.__len__


class vectorFloat(_List):
    """Numbers."""


class vectorPosition2D(_List):
    """Positions on the floor."""


class vectorPose2D(_List):
    """Poses on the floor."""


class vectorPosition6D(_List):
    """Positions with angles."""


class Transform:
    """A homogeneous transform; of 12 or 16 numbers row by row, or of a position."""

    def __init__(self, *values: Any) -> None:
        self.matrix = np.eye(4)
        if len(values) == 3:
            self.matrix[:3, 3] = values
        elif values:
            given = list(values[0].toVector()) if isinstance(values[0], Transform) else list(values[0])
            if len(given) not in (12, 16):
                raise RuntimeError(f"Transform takes 12 or 16 numbers, not {len(given)}.")
            self.matrix[:3] = np.array(given[:12]).reshape(3, 4)

    @classmethod
    def of(cls, matrix: Any) -> Transform:
        """The transform with this matrix, (4, 4)."""
        made = cls()
        made.matrix = np.array(matrix, dtype=float)
        return made

    @classmethod
    def fromPosition(cls, x: float, y: float, z: float, *angles: float) -> Transform:
        """The transform of x, y, z, and of wx, wy, wz if given."""
        return transformFromPosition6D(Position6D(x, y, z, *(angles or (0.0, 0.0, 0.0))))

    @classmethod
    def fromRotX(cls, angle: float) -> Transform:
        """A turn about x."""
        return cls.from3DRotation(angle, 0.0, 0.0)

    @classmethod
    def fromRotY(cls, angle: float) -> Transform:
        """A turn about y."""
        return cls.from3DRotation(0.0, angle, 0.0)

    @classmethod
    def fromRotZ(cls, angle: float) -> Transform:
        """A turn about z."""
        return cls.from3DRotation(0.0, 0.0, angle)

    @classmethod
    def from3DRotation(cls, wx: float, wy: float, wz: float) -> Transform:
        """Turns about x, then y, then z."""
        return cls.fromPosition(0.0, 0.0, 0.0, wx, wy, wz)

    def toVector(self) -> list[float]:
        """16 numbers, row by row."""
        return [float(value) for value in self.matrix.flat]

    def isNear(self, other: Transform, epsilon: float = 1e-4) -> bool:
        """Whether each number is within `epsilon` of the other's."""
        return bool(np.all(np.abs(self.matrix - other.matrix) <= epsilon))

    def norm(self) -> float:
        """Length of the translation."""
        return float(np.linalg.norm(self.matrix[:3, 3]))

    def distance(self, other: Transform) -> float:
        """Distance of the positions."""
        return float(np.linalg.norm(self.matrix[:3, 3] - other.matrix[:3, 3]))

    def diff(self, other: Transform) -> Transform:
        """The other transform in this one's frame."""
        return Transform.of(self.inverse().matrix @ other.matrix)

    def inverse(self) -> Transform:
        """The inverse."""
        return Transform.of(np.linalg.inv(self.matrix))

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Position3D):
            return Position3D((self.matrix @ (*other, 1.0))[:3].tolist())
        return Transform.of(self.matrix @ other.matrix)

    def __repr__(self) -> str:
        return "\n".join(" ".join(f"{value:g}" for value in row) for row in self.matrix.tolist())

    def __getattr__(self, name: str) -> float:
        """`r1_c4` and its like: the element of a row and a column."""
        if len(name) == 5 and name[0] == "r" and name[2:4] == "_c":
            return float(self.matrix[int(name[1]) - 1, int(name[4]) - 1])
        raise AttributeError(name)

    def __setattr__(self, name: str, value: Any) -> None:
        if len(name) == 5 and name[0] == "r" and name[2:4] == "_c":
            self.matrix[int(name[1]) - 1, int(name[4]) - 1] = value
        else:
            super().__setattr__(name, value)


# as the vendor's wrapper names them, too
transformFromRotX = Transform_fromRotX = Transform.fromRotX
transformFromRotY = Transform_fromRotY = Transform.fromRotY
transformFromRotZ = Transform_fromRotZ = Transform.fromRotZ
transformFrom3DRotation = Transform_from3DRotation = Transform.from3DRotation
transformFromPosition = Transform_fromPosition = Transform.fromPosition
transformInverse, areTransformsNear, pose2DInverse = Transform.inverse, Transform.isNear, Pose2D.inverse


def transformFromPosition3D(position: Position3D) -> Transform:
    """The transform of a position."""
    return Transform(*position)


def transformFromPosition6D(position: Position6D) -> Transform:
    """The transform of a position with angles."""
    x, y, z, wx, wy, wz = position
    (cx, sx), (cy, sy), (cz, sz) = ((math.cos(a), math.sin(a)) for a in (wx, wy, wz))
    return Transform(
        [
            *(cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx, x),
            *(sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx, y),
            *(-sy, cy * sx, cy * cx, z),
        ]
    )


def position6DFromTransform(transform: Transform) -> Position6D:
    """Position and angles of a transform."""
    H = transform.matrix
    angles = (
        math.atan2(H[2, 1], H[2, 2]),
        -math.asin(max(-1.0, min(1.0, H[2, 0]))),
        math.atan2(H[1, 0], H[0, 0]),
    )
    return Position6D(*H[:3, 3].tolist(), *angles)


def position3DFromTransform(transform: Transform) -> Position3D:
    """Position of a transform."""
    return Position3D(transform.matrix[:3, 3].tolist())


def rotation3DFromTransform(transform: Transform) -> Rotation3D:
    """Angles of a transform."""
    return Rotation3D(position6DFromTransform(transform).toVector()[3:])


def position2DFromPose2D(pose: Pose2D) -> Position2D:
    """Position of a pose."""
    return Position2D(pose.x, pose.y)


def transformFromPose2D(pose: Pose2D) -> Transform:
    """The transform of a pose on the floor."""
    return Transform.fromPosition(pose.x, pose.y, 0.0, 0.0, 0.0, pose.theta)


def pose2DFromTransform(transform: Transform) -> Pose2D:
    """The pose on the floor of a transform."""
    H = transform.matrix
    return Pose2D(float(H[0, 3]), float(H[1, 3]), math.atan2(H[1, 0], H[0, 0]))


def modulo2PI(angle: float) -> float:
    """The angle in (-pi, pi], rad."""
    return math.pi - (math.pi - angle) % math.tau


def clipData(lower: float, upper: float, value: float) -> float:
    """The value within the bounds."""
    return max(lower, min(upper, value))


def clipFootWithEllipse(maxFootX: float, maxFootY: float, move: Pose2D) -> bool:
    """Move a step back onto an ellipse, along its direction; whether it was outside.

    Args:
        maxFootX: half axis of the ellipse along x, m.
        maxFootY: half axis along y, m.
        move: the step; changed.
    """
    norm = math.hypot(move.x / maxFootX, move.y / maxFootY)
    if norm < 1.00001:
        return False
    move.x, move.y = move.x / norm, move.y / norm
    return True


def avoidFootCollision(
    lFootBox: Sequence[Any], rFootBox: Sequence[Any], isLeftSupport: bool, move: Pose2D
) -> bool:
    """Turn a step back until the foot does not touch the other one, to 1/32 of its turn; whether it did.

    Args:
        lFootBox: corners of the left foot in its own frame, around it clockwise, m.
        move: the step, in the frame of the support foot; changed.
    """
    fixed, moving = (lFootBox, rFootBox) if isLeftSupport else (rFootBox, lFootBox)

    def touches(turn: float) -> bool:
        """Whether no line parts the feet: one along a side of either would (separating axes)."""
        pose = Pose2D(move.x, move.y, turn)
        boxes = [[(p.x, p.y) for p in fixed], [(q.x, q.y) for q in (pose * p for p in moving)]]
        sides = [(a, b) for box in boxes for a, b in zip(box, box[1:] + box[:1], strict=True)]
        for (ax, ay), (bx, by) in sides:
            spans = [[(x - ax) * (by - ay) - (y - ay) * (bx - ax) for x, y in box] for box in boxes]
            if max(spans[0]) < min(spans[1]) or max(spans[1]) < min(spans[0]):
                return False
        return True

    if not touches(move.theta):
        return False
    free, touching = 0.0, move.theta
    for _ in range(5):
        middle = 0.5 * (free + touching)
        free, touching = (free, middle) if touches(middle) else (middle, touching)
    move.theta = free
    return True


def getDubinsSolutions(goal: Pose2D, radius: float) -> list[Pose2D]:
    """The shortest way from the origin to a pose by an arc, a line and an arc of this radius (Dubins 1957).

    Returns:
        Poses at the line's beginning and end, and the goal.
    """
    found = []
    for a in (1.0, -1.0):
        for b in (1.0, -1.0):
            x = goal.x - b * radius * math.sin(goal.theta)
            y = goal.y + b * radius * math.cos(goal.theta) - a * radius
            length, across = math.hypot(x, y), radius * abs(a - b)
            if length < across:
                continue
            line = math.sqrt(length**2 - across**2)
            heading = math.atan2(y, x) + a * math.atan2(across, line)
            turn = (a * heading) % math.tau + (b * (goal.theta - heading)) % math.tau
            begin = (a * radius * math.sin(heading), a * radius * (1.0 - math.cos(heading)))
            end = (begin[0] + line * math.cos(heading), begin[1] + line * math.sin(heading))
            found.append((line + radius * turn, [Pose2D(*begin, heading), Pose2D(*end, heading), Pose2D(goal)]))
    return min(found, key=lambda way: way[0])[1]
