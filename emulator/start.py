"""The robot's start: joint angles, and the torso's place over the floor."""

from __future__ import annotations

from collections.abc import Sequence

from bridge.body import Body
from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.body.postures import POSTURES
from bridge.errors import ConfigurationError
from bridge.types import Quaternion
from emulator.engine.shapes import FOOT_LINKS, sole_points
from emulator.poses import ORIGIN, Pose, compose, inverse, point_of, quaternion, yaw_of
from emulator.world.world import World


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


def _level(sole: Quaternion) -> Quaternion:
    """Orientation of a torso that looks along x and has the given sole, seen from it, level."""
    level = inverse(Pose(orientation=sole))
    back = quaternion(yaw=-yaw_of(level.orientation))
    return compose(Pose(orientation=back), level).orientation
