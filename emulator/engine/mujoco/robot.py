"""The robot's state in MuJoCo."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from bridge.body import TORSO
from bridge.types import Array, Quaternion, Vec3
from emulator.compiled import compiled
from emulator.drives import Drives
from emulator.engine.base import AT_REST, Multibody
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.shapes import wxyz
from emulator.engine.mujoco.simulation import MujocoModel, Simulation
from emulator.engine.values import BodyState
from emulator.poses import Pose, matrix
from emulator.vectors import Rotation, rotate, rotate_back


class MujocoRobot(Multibody):
    """A robot in a simulation.

    Args:
        description: The robot's part of the simulation's description.
        simulation: With the robot.
        drives: Of its joints.
    """

    def __init__(self, description: MujocoModel, simulation: Simulation, drives: Drives) -> None:
        super().__init__(description.body, description.joints, drives)
        self._description, self._simulation = description, simulation
        self._locked: frozenset[str] = frozenset()
        self._version = -1
        self.find()
        self.read()

    def find(self) -> None:
        """Look up addresses in a newly compiled simulation."""
        model = self._simulation.model
        if self._version == self._simulation.version:
            return
        self._version = self._simulation.version
        data, prefix = self._simulation.data, self._description.prefix
        joints = [model.joint(prefix + name) for name in self.joints]
        self.angles = np.array([joint.qposadr[0] for joint in joints])
        """Places of the joints in MuJoCo's positions."""
        self.dofs = np.array([joint.dofadr[0] for joint in joints])
        """Places of the joints in MuJoCo's velocities."""
        self.bodies = {name: int(model.body(prefix + name).id) for name in (TORSO, *self.joints)}
        """MuJoCo's numbers of the links."""
        self._qpos, self._qvel = data.qpos, data.qvel
        self._positions, self._turns, self._matrices = data.xpos, data.xquat, data.xmat
        self._torso = self.bodies[TORSO]
        # place of the free joint's velocity; none if the torso is held
        self._free = -1 if self._description.held else int(model.joint(prefix + TORSO).dofadr[0])

    def _update_placements(self) -> None:
        """Update the poses of all bodies."""
        self._simulation.bring_up_to_date()
        self.find()

    def read(self) -> None:
        """Take over the joints' state from MuJoCo."""
        self.position = self._qpos[self.angles]
        self.velocity = self._qvel[self.dofs]

    def place(
        self,
        pose: Pose,
        velocity: Vec3 = AT_REST,
        spin: Vec3 = AT_REST,
        *,
        joints: Sequence[float] | None = None,
        held: bool = False,
    ) -> None:
        """See `Multibody`."""
        self.find()
        data, position, turn = self._simulation.data, pose.position, wxyz(pose.orientation)
        if joints is not None:
            self._qpos[self.angles] = joints
            self._qvel[self.dofs] = 0.0
        if self._description.held:
            number = int(self._simulation.model.body(self._description.torso.name).mocapid[0])
            data.mocap_pos[number], data.mocap_quat[number] = position, turn
            self._description.torso.pos, self._description.torso.quat = position, turn
        else:
            free = data.joint(self._description.prefix + TORSO)
            free.qpos = (*position, *turn)
            # MuJoCo's angular velocity of a free joint is in the body's frame
            free.qvel = (*velocity, *rotate_back(matrix(pose.orientation), spin))
            self._hang(position, turn, held)
        # the solver's guess belongs to another state
        data.qacc_warmstart[:] = 0.0
        self._simulation.moved()
        self.read()

    def _hang(self, position: Vec3, turn: tuple[float, float, float, float], held: bool) -> None:
        """Hold the torso to a place of the world by its hook, or release it."""
        model, data, hook = self._simulation.model, self._simulation.data, self._description.hook
        number = int(model.body(hook.name).mocapid[0])
        data.mocap_pos[number], data.mocap_quat[number] = position, turn
        data.eq_active[model.equality(hook.name).id] = held
        # a new compilation begins from the description
        hook.active, body = held, self._simulation.spec.body(hook.name)
        body.pos, body.quat = position, turn

    def state(self, link: str = TORSO) -> BodyState:
        """See `Multibody`."""
        self._update_placements()
        body = self.bodies[link]
        if link == TORSO:
            return BodyState(
                *_frame(self._positions, self._turns, self._matrices, self._qvel, body, self._free)
            )
        model, data, velocity = self._simulation.model, self._simulation.data, np.zeros(6)
        mujoco.mj_comVel(model, data)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, velocity, 0)
        wx, wy, wz, vx, vy, vz = velocity.tolist()
        resting = _frame(self._positions, self._turns, self._matrices, self._qvel, body, -1)
        return BodyState(*resting[:3], (vx, vy, vz), (wx, wy, wz))

    def com(self) -> Vec3:
        """See `Multibody`."""
        x, y, z = self._simulation.now.subtree_com[self.bodies[TORSO]].tolist()
        return x, y, z

    def push(self, force: Vec3, link: str = TORSO) -> None:
        """See `Multibody`."""
        self.find()
        self._simulation.data.xfrc_applied[self.bodies[link], :3] += force

    def lock(self, joints: Collection[str], torque: float) -> None:
        """See `Multibody`. A blocked joint has dry friction up to the torque."""
        self._locked, self.lock_torque = frozenset(joints), np.zeros(len(self.joints))
        for name, hinge in self._description.hinges.items():
            hinge.frictionloss = torque if name in joints else 0.0
            self._simulation.model.joint(hinge.name).frictionloss[0] = hinge.frictionloss

    def read_lock(self) -> None:
        """Take over the torques that block joints."""
        if self._locked:
            data = self._simulation.data
            held = np.zeros(self._simulation.model.nv)
            friction = data.efc_type == mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF
            held[data.efc_id[friction]] = data.efc_force[friction]
            self.lock_torque = held[self.dofs]

    @property
    def geoms(self) -> list[int]:
        """MuJoCo's numbers of all its shapes."""
        model = self._simulation.model
        return [
            geom
            for body in self.bodies.values()
            for geom in range(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body])
        ]

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Geoms of its limbs that can touch each other."""
        model, prefix = self._simulation.model, self._description.prefix
        return [(model.geom(prefix + a).id, model.geom(prefix + b).id) for a, b in self._description.pairs]


@compiled
def _frame(
    positions: Array, turns: Array, matrices: Array, qvel: Array, body: int, free: int
) -> tuple[Vec3, Quaternion, Rotation, Vec3, Vec3]:
    """Position, quaternion, rotation matrix, velocity and angular velocity of a body with a free joint.

    Args:
        positions: Of all bodies, world frame.
        turns: Their quaternions, w, x, y, z.
        matrices: Their rotation matrices, row by row.
        qvel: MuJoCo's velocities.
        body: Number.
        free: Place of its free joint in `qvel`; -1: it has none and is at rest.
    """
    p, q, m = positions[body], turns[body], matrices[body]
    rotation = (m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8])
    velocity = spin = (0.0, 0.0, 0.0)
    if free >= 0:
        v = qvel[free : free + 6]
        velocity = (v[0], v[1], v[2])
        # MuJoCo's angular velocity of a free joint is in the body's frame
        spin = rotate(rotation, (v[3], v[4], v[5]))
    return (p[0], p[1], p[2]), (q[1], q[2], q[3], q[0]), rotation, velocity, spin
