"""ALMotion's Cartesian control: motions of effectors to poses, directly or along paths.

Inverse kinematics gives the joint angles; a target out of reach is approached as closely as the joints' ranges
allow. Both feet stay in place under a moving torso. No controller balances the robot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from typing import Annotated, Any, Final, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from bridge.adapters.naoqi.core.frames import from_position6
from bridge.adapters.naoqi.core.inverse import Goal, InverseKinematics, masked_axes
from bridge.adapters.naoqi.core.joints import CHAINS
from bridge.adapters.naoqi.core.motion_tasks import MotionTask
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import MAX_DURATION, Fraction, number, offers
from bridge.body import TORSO
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.body.kinematics import homogeneous, inverse
from bridge.body.model import Lengths
from bridge.body.quantities import HANDS
from bridge.errors import NaoqiRefused
from bridge.types import Array

EFFECTORS: Final = (*CHAINS, TORSO)
STEP_TIME: Final = 0.04
"""s between two points of a path: two cycles of ALMotion, so that the search costs the robot's cycle little."""
_FEET: Final = ("LLeg", "RLeg")
_STRAIGHT_ELBOW: Final = 0.035
"""rad of a straight elbow: the end of its range."""
_FLAT_FOOT_MASK: Final = 59
"""Mask of a foot that keeps its angles and its place except for the height."""
_STANCE_WEIGHT: Final = 3.0
"""Weight of a stance foot's pose over that of a moving foot (assumed)."""
ITERATIONS: Final = 30
"""Most steps of the search for one place."""
ITERATIONS_ON_PATH: Final = 4
"""For the next pose of a path, which is near."""


class _Path(NamedTuple):
    """Path of an effector."""

    effector: str
    space: int
    mask: int
    start: Array
    """In the space, (4, 4)."""
    targets: list[Array]
    times: list[float]

    def at(self, moment: float) -> Array:
        """The pose at a time, s: from point to point, at rest in each, on a line and about one axis."""
        begins, froms = [0.0, *self.times], [self.start, *self.targets]
        for begin, end, a, b in zip(begins, self.times, froms, self.targets, strict=False):
            if moment < end:
                part = max(0.0, (moment - begin) / (end - begin))
                part = part * part * (3.0 - 2.0 * part)
                turn = Rotation.from_matrix(b[:3, :3] @ a[:3, :3].T).as_rotvec()
                R = Rotation.from_rotvec(part * turn).as_matrix() @ a[:3, :3]
                return homogeneous(R, a[:3, 3] + part * (b[:3, 3] - a[:3, 3]))
        return self.targets[-1]


class _Space(NamedTuple):
    """A space at the beginning of a motion."""

    code: int
    frame: Array
    """In the Torso frame, (4, 4)."""
    feet: dict[str, Array]
    """Frames of the soles in the space, (4, 4), constant while the torso moves."""


def _effectors(names: Any, _: str = "") -> list[str]:
    chosen = names if isinstance(names, list) else [names]
    for name in chosen:
        if not isinstance(name, str) or name not in EFFECTORS:
            raise NaoqiRefused(f"{name!r:.60} is no effector; {', '.join(EFFECTORS)} are.")
    if not chosen or len(set(chosen)) < len(chosen):
        raise NaoqiRefused("ALMotion: each effector may be named once, and at least one.")
    return list(chosen)


Effectors = Annotated[list[str], _effectors]
"""One effector or several."""


class Cartesian(Service):
    """Cartesian methods of `ALMotion`."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._inverse = InverseKinematics(robot.body, robot.frames)

    @offers("ALMotion.setPosition", "ALMotion.setPositions", kind="joints")
    @offers("ALMotion.setTransform", "ALMotion.setTransforms", kind="joints")
    def move(self, names: Effectors, spaces: Any, values: Any, speed: Fraction, masks: Any) -> None:
        """Send effectors towards poses; does not wait.

        Args:
            values: positions (6 numbers) or transforms (12 or 16), one or one for each effector.
            speed: fraction of the joints' largest.
        """
        effectors, count = names, len(names)
        rows = [values] if count == 1 and _flat(values) else _of_each(values, count, "positions")
        places = [_place(row) for row in rows]
        self._send(effectors, _codes(spaces, count), places, _masks(masks, count), speed)

    @offers("ALMotion.changePosition", "ALMotion.changeTransform", kind="joints")
    def change(self, name: Effectors, space: Any, value: Any, speed: Fraction, mask: Any) -> None:
        """As `move` for one effector, relative to its commanded pose.

        Args:
            space: Its code: 0 torso, 1 world, 2 robot.
            value: Change of the pose, six numbers, m and rad, or a transform of 12 or 16.
            speed: Fraction of the joints' maximum speed.
            mask: Axes that count, sum of 1 (x), 2 (y), 4 (z), 8, 16, 32 (turns about them).
        """
        if len(name) != 1:
            raise NaoqiRefused("ALMotion: one effector is expected.")
        code = _codes(space, 1)
        place = _changed(self._commanded_pose(name[0], code[0]), _place(value))
        self._send(name, code, [place], _masks(mask, 1), speed)

    def _send(
        self,
        names: Sequence[str],
        codes: Sequence[int],
        places: Sequence[Array],
        masks: Sequence[int],
        share: float,
    ) -> None:
        wanted = self._solved(names, self._spaces(codes), places, masks, ITERATIONS)
        targets = {joint: wanted[INDEX_WITH_MIRROR[joint]] for joint in self._moved_joints(names)}
        seconds = self._motion.time_to(list(targets), list(targets.values()), share)
        for joint, angle in targets.items():  # together, so that the feet stay flat during the motion
            self._joints.put_position(joint, [(seconds, angle)])

    def solved(self, name: str, code: int, place: Array) -> list[float]:
        """The 25 positions with an effector at a pose of a space, rad.

        Args:
            code: Of the space: 0 torso, 1 world, 2 robot.
            place: Of the effector in it, (4, 4), m.
        """
        return self._solved([name], self._spaces([code]), [place], [63], ITERATIONS)

    def feet(self) -> dict[str, Array]:
        """Frames of the soles in the Torso frame as commanded, (4, 4)."""
        return self._spaces([0])[0].feet

    def on_flat_feet(self, angles: Mapping[str, float], feet: Mapping[str, Array]) -> list[float]:
        """The 25 positions with leg joints at angles, rad, and soles in place except for the height.

        Args:
            angles: joint -> angle, rad.
            feet: as `feet`.
        """
        position = self._frames.position(False)
        pinned = {INDEX_WITH_MIRROR[joint]: angle for joint, angle in angles.items()}
        for slot, angle in pinned.items():
            position[slot] = angle
        goals = [Goal(leg, place, masked_axes(_FLAT_FOOT_MASK, np.eye(3))) for leg, place in feet.items()]
        return self._inverse.solve(position, goals, ITERATIONS_ON_PATH, pinned)

    def _commanded_pose(self, name: str, code: int) -> Array:
        return self._frames.transform(name, code, False)

    def _moved_joints(self, names: Sequence[str]) -> list[str]:
        """Joints that move for these effectors."""
        legs = CHAINS["LLeg"] + CHAINS["RLeg"]
        chains = dict.fromkeys(legs if name in (TORSO, *_FEET) else CHAINS[name] for name in names)
        there = set(self._joints.names.all) - set(HANDS)
        return [joint for chain in chains for joint in chain if joint in there]

    def _spaces(self, codes: Sequence[int]) -> list[_Space]:
        """The present spaces, which a moving foot does not change."""
        links = self._frames.links(self._frames.position(False))
        found = []
        for code in codes:
            H = self._frames.space(code, links, False)
            feet = {leg: inverse(H) @ self._frames.in_torso(leg, links) for leg in _FEET}
            found.append(_Space(code, H, feet))
        return found

    def _solved(
        self,
        names: Sequence[str],
        spaces: Sequence[_Space],
        places: Sequence[Array],
        masks: Sequence[int],
        most: int,
    ) -> list[float]:
        """The 25 positions for poses of effectors in their spaces, from the commanded ones."""
        torso = {
            s.code: inverse(place) for n, s, place in zip(names, spaces, places, strict=True) if n == TORSO
        }
        goals = []
        for name, space, place, mask in zip(names, spaces, places, masks, strict=True):
            H = torso.get(space.code, space.frame)
            if name == TORSO:
                goals += [Goal(leg, H @ foot, masked_axes(63, np.eye(3))) for leg, foot in space.feet.items()]
            else:
                goals.append(Goal(name, H @ place, masked_axes(mask, H[:3, :3])))
        if len(legs := [name for name in names if name in _FEET]) == 1 and not torso:
            # the hips share a motor: the goal of the other foot keeps it in place
            other, space = _FEET[1 - _FEET.index(legs[0])], spaces[names.index(legs[0])]
            goals.append(
                Goal(other, space.frame @ space.feet[other], _STANCE_WEIGHT * masked_axes(63, np.eye(3)))
            )
        return self._inverse.solve(self._frames.position(False), goals, most)

    @offers("ALMotion.positionInterpolation", "ALMotion.positionInterpolations", kind="joints")
    @offers("ALMotion.transformInterpolation", "ALMotion.transformInterpolations", kind="joints")
    def along(
        self, names: Effectors, spaces: Any, paths: Any, masks: Any, times: Any, absolute: bool = True
    ) -> Future[Any]:
        """Send effectors along paths; waits for the end.

        Args:
            paths: for each effector a list of poses, which are positions or transforms; for one effector that
                list, or one pose.
            times: for each effector a list of times, s; for one effector that list, or one time.
            absolute: whether the poses are absolute; otherwise they are relative to the effector's.
        """
        effectors, count = names, len(names)
        codes, axes = _codes(spaces, count), _masks(masks, count)
        rows = [paths] if count == 1 and not _nested(paths, 3) else _of_each(paths, count, "paths")
        moments = [times] if count == 1 and not _nested(times, 2) else _of_each(times, count, "times")
        found = []
        for name, code, mask, row, when in zip(effectors, codes, axes, rows, moments, strict=True):
            start = self._commanded_pose(name, code)
            places = [_place(place) for place in ([row] if _flat(row) else row)]
            if not absolute:
                places = [_changed(start, place) for place in places]
            found.append(_Path(name, code, mask, start, places, _times(when, len(places))))
        joints = self._moved_joints(effectors)
        return self._tasks.begin(self._follow(found, joints), "positionInterpolations", joints, locks=True)

    def _follow(self, paths: list[_Path], joints: list[str]) -> MotionTask:
        paths = [path._replace(start=self._commanded_pose(path.effector, path.space)) for path in paths]
        names, spaces = [path.effector for path in paths], self._spaces([path.space for path in paths])
        masks, began = [path.mask for path in paths], self._joints.now
        end = max(path.times[-1] for path in paths)
        moment = 0.0
        while moment < end:
            moment = min(end, moment + STEP_TIME)
            last = moment >= end
            places = [path.at(moment) for path in paths]
            wanted = self._solved(names, spaces, places, masks, ITERATIONS if last else ITERATIONS_ON_PATH)
            due = began + round(1000.0 * moment)
            left = max(0.0, 0.001 * (due - self._joints.now))
            for joint in joints:
                self._joints.put_position(joint, [(left, wanted[INDEX_WITH_MIRROR[joint]])])
            yield due
        return None


def _nested(value: Any, depth: int) -> bool:
    """Whether a value is a list in which first items are nested this deep."""
    for _ in range(depth):
        if not isinstance(value, list) or not value:
            return False
        value = value[0]
    return True


def _flat(value: Any) -> bool:
    return isinstance(value, list) and not any(isinstance(item, list) for item in value)


def _of_each(values: Any, count: int, label: str) -> list[Any]:
    if not isinstance(values, list) or len(values) != count:
        raise NaoqiRefused(f"{label} is {values!r:.60}; a list with one entry for each of {count} is expected.")
    return values


def _codes(spaces: Any, count: int) -> list[int]:
    codes = _of_each(spaces, count, "spaces") if isinstance(spaces, list) else [spaces] * count
    return [round(number(code, "space", 0, 2)) for code in codes]


def _masks(masks: Any, count: int) -> list[int]:
    all_ = _of_each(masks, count, "axisMask") if isinstance(masks, list) else [masks] * count
    return [round(number(mask, "axisMask", 1, 63)) for mask in all_]


def _times(value: Any, count: int) -> list[float]:
    times = value if isinstance(value, list) else [value]
    moments = [number(time, "times", 0.0, MAX_DURATION) for time in times]
    if len(moments) != count or any(a >= b for a, b in zip([0.0, *moments], moments, strict=False)):
        raise NaoqiRefused(
            f"times are {value!r:.60} for {count} places; as many, increasing ones above 0 are expected."
        )
    return moments


def _place(value: Any) -> Array:
    """A pose, (4, 4), of 6 numbers (position and angles) or of 12 or 16 (a transform, row by row)."""
    if not _flat(value) or len(value) not in (6, 12, 16):
        raise NaoqiRefused(
            f"{value!r:.60} was given; a position (6 numbers) or a transform (12 or 16) is expected."
        )
    numbers = [number(item, f"number {i} of a place", -100.0, 100.0) for i, item in enumerate(value)]
    if len(numbers) == 6:
        return from_position6(numbers)
    H = np.array(numbers[:12]).reshape(3, 4)
    left, sizes_, right = np.linalg.svd(H[:, :3])
    if abs(sizes_ - 1.0).max() > 0.05 or np.linalg.det(H[:, :3]) < 0.0:
        raise NaoqiRefused(f"{value!r:.60} is no transform: its first three columns are no rotation.")
    return homogeneous(left @ right, H[:, 3])


def _changed(place: Array, change: Array) -> Array:
    """A pose shifted and turned in the axes of its space."""
    return homogeneous(change[:3, :3] @ place[:3, :3], place[:3, 3] + change[:3, 3])


def look_angles(point: Sequence[float], neck: float, camera: Array) -> tuple[float, float]:
    """HeadYaw and HeadPitch with which a camera's axis intersects a point, rad.

    Args:
        point: in the Torso frame, m.
        neck: height of the head's joints in the Torso frame, m.
        camera: its frame in HeadPitch's, (4, 4).
    """
    x, y, z = point
    tilt = -math.asin(float(camera[2, 0]))
    ahead, up = math.hypot(x, y), z - neck
    pitch = 0.0
    for _ in range(20):
        c, s = math.cos(pitch), math.sin(pitch)
        seen_ahead = ahead - (c * camera[0, 3] + s * camera[2, 3])
        seen_up = up - (c * camera[2, 3] - s * camera[0, 3])
        pitch = -math.atan2(seen_up, seen_ahead) - tilt
    return math.atan2(y, x), pitch


def pointing_angles(point: Sequence[float], arm: str, lengths: Lengths) -> dict[str, float]:
    """Angles of a straight arm that points at a place, rad; the elbow's offset of 15 mm is left out.

    Args:
        point: in the Torso frame, m.
        arm: `LArm` or `RArm`.
        lengths: of the body, m.
    """
    sign = 1.0 if arm == "LArm" else -1.0
    x, y, z = point[0], point[1] - sign * lengths.ShoulderOffsetY, point[2] - lengths.ShoulderOffsetZ
    angles = (-math.atan2(z, x), math.atan2(y, math.hypot(x, z)), 0.0, -sign * _STRAIGHT_ELBOW)
    joints = ("ShoulderPitch", "ShoulderRoll", "ElbowYaw", "ElbowRoll")
    return {f"{arm[0]}{joint}": angle for joint, angle in zip(joints, angles, strict=True)}
