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
    model: RobotModel, body: Body, angles: Sequence[float], orientation: Quaternion | None, lift: float
) -> None:
    """Set the joints, and put the robot at rest over the world's origin.

    Args:
        model: The robot.
        body: Its data sheet.
        angles: 25 joint angles in frame order, rad.
        orientation: Of the torso in the world; None: the left sole is level and the torso looks along x.
        lift: Height of the lowest corner of the soles above z = 0, m.
    """
    client, robot = model.client, model.robot
    for i, name in enumerate(model.joints):
        bullet.resetJointState(robot, i, angles[INDEX_WITH_MIRROR[name]], 0.0, physicsClientId=client)
    _put_torso(model, _HERE, _UPRIGHT)
    soles = {side: _link_frame(model, link) for side, link in model.feet.items()}
    if orientation is None:
        orientation = _level(soles["L"][1])
    lowest = 0.0
    for side, (position, turn) in soles.items():
        foot = bullet.multiplyTransforms(_HERE, orientation, position, turn)
        for corner in sole_points(body, side).tolist():
            lowest = min(lowest, bullet.multiplyTransforms(*foot, corner, _UPRIGHT)[0][2])
    _put_torso(model, (0.0, 0.0, lift - lowest), orientation)


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
