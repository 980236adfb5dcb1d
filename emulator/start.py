"""Where the robot stands when it starts: joint angles, and the torso's place over the floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from bridge.datasheet import Body
from bridge.datasheet.postures import POSTURES
from bridge.errors import ConfigurationError
from bridge.joints import INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.messages import Quaternion, Vec3
from emulator.engine import bullet
from emulator.model import RobotModel
from emulator.shapes import sole_points
from emulator.world.world import World

_HERE: Final = (0.0, 0.0, 0.0)
_UPRIGHT: Final = (0.0, 0.0, 0.0, 1.0)


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
    model: RobotModel,
    body: Body,
    angles: Sequence[float],
    orientation: Quaternion | None,
    lift: float,
    world: World,
    at: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> None:
    """Set the joints, and put the robot at rest on the ground.

    Args:
        model: The robot.
        body: Its data sheet.
        angles: 25 joint angles in frame order, rad.
        orientation: Of the torso; None: the left sole is parallel to the floor and the torso looks along x.
        lift: Height of the lowest corner of the soles above the ground, m.
        world: With the ground; the pose is meant in its floor's frame.
        at: Place of the torso on the floor, x and y in m, and its heading, rad.
    """
    client, robot = model.client, model.robot
    for i, name in enumerate(model.joints):
        bullet.resetJointState(robot, i, angles[INDEX_WITH_MIRROR[name]], 0.0, physicsClientId=client)
    _put_torso(model, _HERE, _UPRIGHT)
    soles = {side: _link_frame(model, link) for side, link in model.feet.items()}
    if orientation is None:
        orientation = _level(soles["L"][1])
    corners = [
        bullet.multiplyTransforms(
            *bullet.multiplyTransforms(_HERE, orientation, position, turn), corner, _UPRIGHT
        )[0]
        for side, (position, turn) in soles.items()
        for corner in sole_points(body, side).tolist()
    ]
    lowest = min(0.0, *(corner[2] for corner in corners))
    where = (at[0], at[1], lift - lowest), bullet.getQuaternionFromEuler((0.0, 0.0, at[2]))
    if world.uneven:
        feet = [bullet.multiplyTransforms(*where, corner, _UPRIGHT)[0] for corner in corners]
        grounds = world.ground([(foot[0], foot[1]) for foot in feet])
        rise = max(ground + lift - foot[2] for ground, foot in zip(grounds, feet, strict=True))
        where = (at[0], at[1], where[0][2] + max(0.0, rise)), where[1]
    position, turn = bullet.multiplyTransforms(*where, _HERE, orientation)
    _put_torso(model, *world.to_world(position, turn))


def _level(sole: Quaternion) -> Quaternion:
    """Orientation of a torso that looks along x and has the given sole, seen from it, level."""
    _, level = bullet.invertTransform(_HERE, sole)
    m = bullet.getMatrixFromQuaternion(level)
    back = bullet.getQuaternionFromEuler((0.0, 0.0, -math.atan2(m[3], m[0])))
    orientation: Quaternion = bullet.multiplyTransforms(_HERE, back, _HERE, level)[1]
    return orientation


def _link_frame(model: RobotModel, link: int) -> tuple[Vec3, Quaternion]:
    state = bullet.getLinkState(model.robot, link, computeForwardKinematics=True, physicsClientId=model.client)
    return state[4], state[5]


def _put_torso(model: RobotModel, position: Vec3, orientation: Quaternion) -> None:
    """PyBullet places the base by its inertial frame."""
    inertial = bullet.multiplyTransforms(position, orientation, model.torso_com, model.torso_principal)
    bullet.resetBasePositionAndOrientation(model.robot, *inertial, physicsClientId=model.client)
