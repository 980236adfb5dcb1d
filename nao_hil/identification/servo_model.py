"""The emulator's drives with one joint each behind them: no engine, no other joint, machine code.

A joint has the inertia and the gravity of its load, see `loads`; the drive is `emulator.servo`'s.

Load of each joint of a robot with a held torso: gravity and inertia of all links behind it.

Other joints are taken where they are measured, and at rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body, joint_tree
from bridge.body.joints import INDEX, INDEX_WITH_MIRROR, TORSO
from bridge.body.quantities import GRAVITY, tensor_matrix
from bridge.types import Array
from emulator.compiled import compiled
from emulator.drives import run_drives
from emulator.engine.settings import PhysicsSettings
from emulator.servo.parameters import ServoParameters
from emulator.servo.servo import Servo
from nao_hil.identification.readings import Signals

STEP: Final = PhysicsSettings().step
"""Time step of drives and joints, s."""


@dataclass(frozen=True)
class JointLoad:
    """Load of one joint over time, (n,) each; its angle is q, the measured one q_m."""

    cosine: Array
    """Torque of gravity is cosine cos(q - q_m) + sine sin(q - q_m), N m."""
    sine: Array
    inertia: Array
    """About the axis, without the rotor, kg m^2."""


def joint_loads(body: Body, position: Array, angle: Array) -> dict[str, JointLoad]:
    """Loads of all mechanical joints.

    Args:
        body: Data sheet.
        position: Measured angles, (n, 25), rad.
        angle: Roll and pitch of the torso, (n, 2), rad; NaN: upright.
    """
    tree = joint_tree(body)
    turn, place = _poses(body, position)
    roll, pitch = np.nan_to_num(angle).T
    # gravity in the torso frame: R^T (0, 0, -g) with R = R_y(pitch) R_x(roll)
    down = np.stack([np.sin(pitch), -np.sin(roll) * np.cos(pitch), -np.cos(roll) * np.cos(pitch)], axis=1)
    parent = {name: tree[name].parent for name in tree}
    loads = {}
    for joint, node in tree.items():
        axis = turn[joint] @ np.asarray(node.axis)
        moment, inertia = np.zeros_like(down), np.zeros(len(down))
        for link in (name for name in tree if _carries(parent, joint, name)):
            sheet = body.links[link]
            arm = place[link] + turn[link] @ np.asarray(sheet.com) - place[joint]
            moment += sheet.mass * arm
            own = np.einsum("nji,nj->ni", turn[link], axis)
            inertia += np.einsum("ni,ij,nj->n", own, tensor_matrix(sheet.inertia), own)
            inertia += sheet.mass * np.square(np.cross(axis, arm)).sum(axis=1)
        loads[joint] = JointLoad(
            cosine=GRAVITY * np.einsum("ni,ni->n", axis, np.cross(moment, down)),
            sine=GRAVITY * np.einsum("ni,ni->n", axis, np.cross(np.cross(axis, moment), down)),
            inertia=inertia,
        )
    return loads


def _poses(body: Body, position: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Rotation (n, 3, 3) and origin (n, 3) of each joint's link in the torso frame."""
    count = len(position)
    turn: dict[str, Array] = {TORSO: np.broadcast_to(np.eye(3), (count, 3, 3))}
    place: dict[str, Array] = {TORSO: np.zeros((count, 3))}
    for joint, node in joint_tree(body).items():
        x, y, z = node.axis
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        q = position[:, INDEX_WITH_MIRROR[joint], None, None]
        own = np.eye(3) + np.sin(q) * cross + (1.0 - np.cos(q)) * (cross @ cross)
        place[joint] = place[node.parent] + turn[node.parent] @ np.asarray(node.offset)
        turn[joint] = turn[node.parent] @ own
    return turn, place


def _carries(parent: Mapping[str, str], joint: str, link: str) -> bool:
    """The link is behind the joint, or its own."""
    while link != TORSO:
        if link == joint:
            return True
        link = parent[link]
    return False


class ServoModel:
    """Predicts the joint angles of a recording of a robot whose torso does not move.

    The two hips that share a motor are one joint: half the motor and the mean of both legs.

    Args:
        body: Data sheet.
        signals: Commands and measurements; every command is there, the stiffness is one over time.
    """

    def __init__(self, body: Body, signals: Signals) -> None:
        self._body = body
        self._names = tuple(joint_tree(body))
        """Mechanical joints, the order of the drives."""
        self.joints = tuple(name for name in self._names if name in INDEX)
        """Joints that are predicted, the columns of `predict`."""
        self._steps = round(signals.cycle / STEP)
        self._rows = [self._names.index(name) for name in self.joints]
        slots = [INDEX_WITH_MIRROR[name] for name in self._names]
        self._request = np.ascontiguousarray(signals.command[:, slots])
        self._measured = np.ascontiguousarray(signals.position[:, slots])
        self._stiffness = np.median(signals.stiffness[:, slots], axis=0)
        loads = joint_loads(body, signals.position, signals.angle)
        self._cosine, self._sine, self._inertia = (
            np.stack([getattr(_shared(loads, name), field) for name in self._names], axis=1)
            for field in ("cosine", "sine", "inertia")
        )

    def predict(self, parameters: ServoParameters) -> Array:
        """Joint angles at the rows of the recording, (n, joints), rad.

        Args:
            parameters: Of the drives; the delay need not be whole steps.
        """
        servo = Servo(self._body, self._names, parameters, self._measured[0], STEP)
        servo.strength[:] = self._stiffness
        servo.apply_power()
        out = np.empty_like(self._measured)
        _simulate(
            servo.drives.records,
            self._request,
            self._measured,
            self._cosine,
            self._sine,
            self._inertia + servo.drives.rotor_inertia,
            self._steps,
            parameters.delay / STEP,
            STEP,
            out,
        )
        return out[:, self._rows]


def _shared(loads: dict[str, JointLoad], joint: str) -> JointLoad:
    """The load of a joint, for the two hips with one motor the mean of both."""
    if not joint.endswith("HipYawPitch"):
        return loads[joint]
    left, right = loads["LHipYawPitch"], loads["RHipYawPitch"]
    return JointLoad(
        0.5 * (left.cosine + right.cosine), 0.5 * (left.sine + right.sine), 0.5 * (left.inertia + right.inertia)
    )


@compiled
def _simulate(
    drives: NDArray[Any],
    command: Array,
    measured: Array,
    cosine: Array,
    sine: Array,
    inertia: Array,
    steps: int,
    delay: float,
    step: float,
    out: Array,
) -> None:
    """Run drives and joints under the commands.

    Args:
        drives: At rest in the first measured angles, (m,); the state changes.
        command: Angles asked for in each cycle, (n, m), rad.
        measured: At which the loads hold, (n, m), rad.
        cosine: Loads, (n, m), see `loads.JointLoad`.
        sine: Likewise.
        inertia: With the rotor, (n, m), kg m^2.
        steps: In a cycle.
        delay: Of the commands in steps; within a step it takes a share of the new command.
        step: s
        out: Angles at the cycles' boundaries, (n, m), rad; written.
    """
    count, joints = command.shape
    angle, speed, torque = measured[0].copy(), np.zeros(joints), np.zeros(joints)
    before = measured[0].copy()
    whole = int(delay)
    part = delay - whole
    for row in range(count):
        out[row] = angle
        for number in range(steps):
            at = row * steps + number - whole
            if at >= 0 and at % steps == 0:
                for i in range(joints):
                    new = command[at // steps, i]
                    drives[i].request = new + part * (before[i] - new)
                    before[i] = new
            elif at >= 0 and at % steps == 1:
                for i in range(joints):
                    drives[i].request = before[i]
            run_drives(drives, angle, speed, torque)
            for i in range(joints):
                turned = angle[i] - measured[row, i]
                gravity = cosine[row, i] * (1.0 - 0.5 * turned * turned) + sine[row, i] * turned
                speed[i] += step * (torque[i] + gravity) / inertia[row, i]
                angle[i] += step * speed[i]
