"""The robot's state in MuJoCo."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bridge.body import TORSO
from bridge.types import Array, Quaternion, Vec3
from emulator.compiled import compiled
from emulator.engine.base import Multibody
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.scene import MujocoScene
from emulator.engine.mujoco.shapes import wxyz, xyzw
from emulator.engine.mujoco.simulation import HOOK, MujocoModel, Simulation
from emulator.engine.values import TorsoState
from emulator.poses import Pose
from emulator.vectors import Rotation, rotate

MAX_CONTACT_DISTANCE: Final = 0.001
"""Distance up to which MuJoCo reports two things as touching, m."""


class MujocoRobot(Multibody):
    """A robot in a simulation.

    Args:
        description: The robot's part of the simulation's description.
        simulation: With the robot.
        scene: Its surroundings.
    """

    def __init__(self, description: MujocoModel, simulation: Simulation, scene: MujocoScene) -> None:
        self.joints = description.joints
        self._description, self._simulation, self._scene = description, simulation, scene
        self._version = -1
        self.find()
        self.read()

    def find(self) -> None:
        """Look up addresses in a newly compiled simulation."""
        model = self._simulation.model
        if self._version == self._simulation.version:
            return
        self._version = self._simulation.version
        data = self._simulation.data
        joints = [model.joint(name) for name in self.joints]
        self._angles = np.array([joint.qposadr[0] for joint in joints])
        self._dofs = np.array([joint.dofadr[0] for joint in joints])
        self._bodies = {name: int(model.body(name).id) for name in (TORSO, *self.joints)}
        self._qpos, self._qvel, self._force = data.qpos, data.qvel, data.qfrc_applied
        self._pushes = data.xfrc_applied
        self._positions, self._turns, self._matrices = data.xpos, data.xquat, data.xmat
        self._torso = self._bodies[TORSO]
        # place of the free joint's velocity; none if the torso is held
        self._free = -1 if self._description.held else int(model.joint(TORSO).dofadr[0])

    def arrays(self) -> tuple[NDArray[Any], ...]:
        """Places of the joints in MuJoCo's vectors, and these: of `steps.run_steps`."""
        return self._angles, self._dofs, self._qpos, self._qvel, self._force, self._pushes

    def _update_placements(self) -> None:
        """Update the poses of all bodies."""
        self._simulation.bring_up_to_date()
        self.find()

    def poses(self) -> tuple[Array, Array]:
        """Positions, m, and quaternions w, x, y, z of all bodies now, in MuJoCo's order."""
        self._update_placements()
        return self._positions, self._turns

    def read(self) -> None:
        """Take over the joints' state from MuJoCo."""
        self.position = self._qpos[self._angles]
        self.velocity = self._qvel[self._dofs]

    def set_joints(self, position: Sequence[float]) -> None:
        """See `Multibody`."""
        self.find()
        self._qpos[self._angles] = position
        self._qvel[self._dofs] = 0.0
        self._placed()

    def set_torso(self, pose: Pose) -> None:
        """See `Multibody`."""
        self.find()
        data = self._simulation.data
        if self._description.held:
            number = int(self._simulation.model.body(TORSO).mocapid[0])
            data.mocap_pos[number], data.mocap_quat[number] = pose.position, wxyz(pose.orientation)
            self._description.torso.pos = pose.position
            self._description.torso.quat = wxyz(pose.orientation)
        else:
            free = data.joint(TORSO)
            free.qpos = (*pose.position, *wxyz(pose.orientation))
            free.qvel = 0.0
        self._placed()

    def hold_torso(self, held: bool) -> None:
        """See `Multibody`."""
        hook = self._description.hook
        if hook is None:
            return
        model, data, pose = self._simulation.model, self._simulation.data, self.link_pose(TORSO)
        number = int(model.body(HOOK).mocapid[0])
        data.mocap_pos[number], data.mocap_quat[number] = pose.position, wxyz(pose.orientation)
        data.eq_active[model.equality(HOOK).id] = held
        # a new compilation begins from the description
        hook.active, body = held, self._simulation.spec.body(HOOK)
        body.pos, body.quat = pose.position, wxyz(pose.orientation)

    def _placed(self) -> None:
        """The solver's guess belongs to another state."""
        self._simulation.data.qacc_warmstart[:] = 0.0
        self._simulation.moved()
        self.read()

    def torso(self) -> TorsoState:
        """See `Multibody`."""
        self._update_placements()
        return TorsoState(
            *_frame(self._positions, self._turns, self._matrices, self._qvel, self._torso, self._free)
        )

    def link_pose(self, link: str) -> Pose:
        """See `Multibody`."""
        self._update_placements()
        body = self._bodies[link]
        x, y, z = self._positions[body].tolist()
        return Pose((x, y, z), xyzw(self._turns[body]))

    def link_com(self, link: str) -> Vec3:
        """See `Multibody`."""
        x, y, z = self._simulation.now.xipos[self._bodies[link]].tolist()
        return x, y, z

    def com(self) -> Vec3:
        """See `Multibody`."""
        x, y, z = self._simulation.now.subtree_com[self._bodies[TORSO]].tolist()
        return x, y, z

    def energy(self) -> float:
        """See `Multibody`."""
        data, model = self._simulation.now, self._simulation.model
        mujoco.mj_crb(model, data)
        speed: Any = np.zeros(model.nv)
        speed[self._dofs] = data.qvel[self._dofs]
        if not self._description.held:
            free = slice(self._free, self._free + 6)
            speed[free] = data.qvel[free]
        momentum = np.zeros(model.nv)
        mujoco.mj_mulM(model, data, momentum, speed)
        bodies = list(self._bodies.values())
        height = model.body_mass[bodies] @ data.xipos[bodies, 2]
        return float(0.5 * speed @ momentum + self._simulation.settings.gravity * height)

    def push(self, link: str, force: Vec3) -> None:
        """See `Multibody`."""
        self.find()
        self._simulation.data.xfrc_applied[self._bodies[link], :3] += force

    def lock(self, joints: Collection[str], torque: float) -> None:
        """See `Multibody`. A blocked joint has dry friction up to the torque."""
        for name in self.joints:
            friction = torque if name in joints else 0.0
            self._description.hinges[name].frictionloss = friction
            self._simulation.model.joint(name).frictionloss[0] = friction

    def lock_torque(self) -> Array:
        """See `Multibody`."""
        data = self._simulation.data
        held = np.zeros(self._simulation.model.nv)
        friction = data.efc_type == mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF
        held[data.efc_id[friction]] = data.efc_force[friction]
        return np.asarray(held[self._dofs])

    def distance(self, name: str) -> float:
        """See `Multibody`."""
        own = [number for body in self._bodies.values() for number in self._geoms_of(body)]
        return self._depths(itertools.product(own, self._scene.geoms(name)))

    def overlap(self) -> float:
        """See `Multibody`."""
        model = self._simulation.model
        pairs = [(model.geom(a).id, model.geom(b).id) for a, b in self._description.pairs]
        return max(0.0, -self._depths(pairs))

    def _geoms_of(self, body: int) -> range:
        model = self._simulation.model
        return range(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body])

    def _depths(self, pairs: Iterable[tuple[int, int]]) -> float:
        """Least distance of pairs of geoms that touch, m; infinite if none does."""
        model, data = self._simulation.model, self._simulation.now
        distances = [mujoco.mj_geomDistance(model, data, a, b, MAX_CONTACT_DISTANCE, None) for a, b in pairs]
        return min((float(d) for d in distances if d <= 0.0), default=np.inf)


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
