"""The robot's start: on its feet, sitting, lying or hanging; its joint angles and its torso's place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import absent_joints, limits
from bridge.errors import ConfigurationError
from bridge.types import Quaternion
from bridge.validation import unknown_name
from emulator.engine.shapes import FOOT_LINKS, link_shapes, lowest_point, sole_points
from emulator.poses import ORIGIN, Pose, compose, inverse, point_of, quaternion, yaw_of
from emulator.scenarios import START_NAMES
from emulator.world.world import World

_ARMS_DOWN: Final = {
    "LShoulderPitch": 1.571,
    "RShoulderPitch": 1.571,
    "LShoulderRoll": 0.2,
    "RShoulderRoll": -0.2,
}
_ARMS_AHEAD: Final = {"RShoulderPitch": 0.6, "LShoulderRoll": 0.2, "RShoulderRoll": -0.2}
"""Of a robot on its side: with the arms down it would roll onto its front."""
_H: Final = 0.7071067811865476
HOOK: Final = 0.10
"""Height of the lowest point of a hanging robot over the floor, m."""


class StartPose(NamedTuple):
    """How a robot begins that does not stand."""

    angles: tuple[float, ...]
    """25 in frame order, rad."""
    orientation: Quaternion | None
    """Of the torso, whose heading is along x where it has one; None: the left sole is level."""
    rest: float
    """Stiffness of all joints once it has settled."""
    settle: float = 2.0
    """Time in which it settles, s."""
    height: float = 0.0
    """Of its lowest point over the ground at first, m."""
    held: bool = False
    """The torso hangs on a hook."""


def _straight(arms: dict[str, float] = _ARMS_DOWN) -> tuple[float, ...]:
    """Legs straight."""
    return tuple(arms.get(name, 0.0) for name in JOINTS)


STAND: Final = "stand"
START_POSES: Final[dict[str, StartPose]] = {
    # SitRelax leans on the hands; a V3 leans by 0.6 rad, its arms are short, and more upright it would roll
    # over when it stands up. A real robot stays sitting limp, and with its knees up too (Sit); the emulated one
    # has round buttocks: it needs some stiffness, and with its knees up it rolls over.
    "sit": StartPose(POSTURES["SitRelax"], quaternion(pitch=-0.5), 0.3),
    # its thighs do not rest on its calves, as a real robot's do
    "crouch": StartPose(POSTURES["Crouch"], None, 0.1),
    "lie-back": StartPose(_straight(), (0.0, -_H, 0.0, _H), 0.0),
    "lie-front": StartPose(_straight(), (0.0, _H, 0.0, _H), 0.0),
    "lie-side": StartPose(_straight(_ARMS_AHEAD), (-_H, 0.0, 0.0, _H), 0.0),
    "hang": StartPose(_straight(), ORIGIN.orientation, 0.0, height=HOOK, held=True),
}
"""By name; `stand` is the scenario's posture, stiff. On its side the robot lies on the left arm.

Legs straight and arms down are rUNSWift's pose for a robot that lies.
"""


def start_pose(name: str) -> StartPose | None:
    """A start pose by its name; None: on its feet.

    Raises:
        ConfigurationError: no such pose.
    """
    if name not in START_NAMES:
        raise ConfigurationError(unknown_name("start pose", name, START_NAMES))
    return START_POSES.get(name)


def random_drop(body: Body, height: float, random: np.random.Generator) -> StartPose:
    """A limp robot over the ground: any orientation and any angles within the joints' ranges are as likely.

    Args:
        body: Data sheet.
        height: Of its lowest point over the ground, m.
        random: Source.
    """
    from scipy.spatial.transform import Rotation  # here: no other start needs SciPy

    absent = absent_joints(body)
    angles = [0.0 if name in absent else float(random.uniform(*limits(body, name))) for name in JOINTS]
    x, y, z, w = Rotation.random(random_state=random).as_quat().tolist()
    return StartPose(tuple(angles), (x, y, z, w), 0.0, height=height)


def start_posture(posture: str | Sequence[float]) -> tuple[float, ...]:
    """25 joint angles in frame order, rad, of a posture given by name or by its angles.

    Raises:
        ConfigurationError: unknown name, or another number of angles.
    """
    if isinstance(posture, str):
        if posture not in POSTURES:
            raise ConfigurationError(f"No posture `{posture}`; known are {', '.join(sorted(POSTURES))}.")
        return POSTURES[posture]
    if len(posture) != N_JOINTS:
        raise ConfigurationError(
            f"A start posture of {len(posture)} angles; {N_JOINTS} are expected: {', '.join(JOINTS)}."
        )
    return tuple(float(angle) for angle in posture)


def place(
    world: World,
    body: Body,
    angles: Sequence[float],
    orientation: Quaternion | None,
    lift: float,
    at: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> None:
    """Set the joints, and put the robot at rest on the ground.

    Args:
        world: With the ground; the pose is meant in its floor's frame.
        body: Data sheet of the robot.
        angles: 25 joint angles in frame order, rad.
        orientation: Of the torso; None: the left sole is parallel to the floor and the torso looks along x.
        lift: Height of the lowest corner of the soles above the ground, m.
        at: Place of the torso on the floor, x and y in m, and its heading, rad.
    """
    robot = world.engine.robot
    robot.set_joints([angles[INDEX_WITH_MIRROR[name]] for name in robot.joints])
    robot.set_torso(ORIGIN)
    soles = {side: robot.link_pose(link) for side, link in FOOT_LINKS.items()}
    turned = Pose(orientation=_level(soles["L"].orientation) if orientation is None else orientation)
    corners = [
        point_of(compose(turned, sole), corner)
        for side, sole in soles.items()
        for corner in sole_points(body, side).tolist()
    ]
    lowest = min(0.0, *(corner[2] for corner in corners))
    where = Pose((at[0], at[1], lift - lowest), quaternion(yaw=at[2]))
    if world.uneven:
        feet = [point_of(where, corner) for corner in corners]
        grounds = world.ground([(foot[0], foot[1]) for foot in feet])
        rise = max(ground + lift - foot[2] for ground, foot in zip(grounds, feet, strict=True))
        where = Pose((at[0], at[1], where.position[2] + max(0.0, rise)), where.orientation)
    robot.set_torso(compose(world.pose, compose(where, turned)))


def lay(world: World, body: Body, pose: StartPose, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
    """Put the robot at rest with its lowest point on or over the ground, or on a hook; then let it settle.

    Args:
        world: With the ground.
        body: Data sheet of the robot.
        pose: Joints and torso.
        at: Place of the torso on the floor, x and y in m, and its heading, rad.
    """
    robot = world.engine.robot
    robot.hold_torso(False)
    if pose.orientation is None:
        place(world, body, pose.angles, None, 0.0, at)
        return
    robot.set_joints([pose.angles[INDEX_WITH_MIRROR[name]] for name in robot.joints])
    turned = compose(Pose((0.0, 0.0, 0.0), quaternion(yaw=at[2])), Pose(orientation=pose.orientation))
    robot.set_torso(turned)
    lowest = min(lowest_point(shape, robot.link_pose(link)) for link, shape in link_shapes(body).items())
    around = [(at[0] + 0.1 * i, at[1] + 0.1 * j) for i in range(-3, 4) for j in range(-3, 4)]
    height = max(world.ground(around)) - lowest + pose.height
    robot.set_torso(compose(world.pose, Pose((at[0], at[1], height), turned.orientation)))
    robot.hold_torso(pose.held)


def _level(sole: Quaternion) -> Quaternion:
    """Orientation of a torso that looks along x and has the given sole, seen from it, level."""
    level = inverse(Pose(orientation=sole))
    back = quaternion(yaw=-yaw_of(level.orientation))
    return compose(Pose(orientation=back), level).orientation
