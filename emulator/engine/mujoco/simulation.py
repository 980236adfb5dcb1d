"""MuJoCo's model and state, compiled again when something is added to the world or taken away.

The robot in MuJoCo's description, built from the data sheet when it starts.

Link frames are the zero-pose aligned joint frames of the data sheet.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from bridge.body import TORSO, Body, joint_tree
from bridge.body.model import Link
from bridge.types import Array, Vec3
from emulator.compiled import compiled
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.native import mj_com_pos, mj_kinematics
from emulator.engine.mujoco.shapes import (
    HIDDEN_GROUP,
    IMPEDANCE,
    ROBOT_BITS,
    TIME_CONSTANT_STEPS,
    add_limb_pairs,
    add_link_shape,
    add_sole_points,
    contact_options,
)
from emulator.engine.settings import PhysicsSettings
from emulator.engine.shapes import FOOT_LINKS, collision_pairs, link_shapes

_NO_MIDPHASE: Final = int(mujoco.mjtDisableBit.mjDSBL_MIDPHASE)
_MAX_FLAT_GEOMS: Final = 32
"""Geoms of a body up to which testing each is faster than a tree of them."""
GEAR: Final = "hips"
"""Name of the equality that couples the two HipYawPitch joints."""
_FIRST_ROBOT: Final = 1 << ROBOT_BITS.start
MAX_ROBOTS: Final = len(ROBOT_BITS)
"""Each has a bit of its own in MuJoCo's masks."""
HOOK: Final = "hook"
"""Name of the body and of the equality that can hold the torso."""


def _leave(_: Any) -> None:
    """The model stays as the compiler made it."""


@compiled
def _place_bodies(model: int, data: int) -> None:
    """Compute the poses of bodies and geoms; so short that Python's lock is kept.

    Args:
        model: Address of MuJoCo's model.
        data: Address of its state.
    """
    mj_kinematics(model, data)
    mj_com_pos(model, data)


class Simulation:
    """A description of the world, and MuJoCo's model of it, compiled when it is needed.

    Args:
        settings: Of the physics.
    """

    def __init__(self, settings: PhysicsSettings) -> None:
        self.settings = settings
        self.spec = mujoco.MjSpec()
        """The description; call `changed` after a change."""
        self.spec.compiler.degree = False
        option = self.spec.option
        option.timestep = settings.step
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        # a sole's contacts move the joints of one leg: sparse takes two thirds of the time of dense
        option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
        # robot and floor are one island, which need not be searched for
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
        # Newton's own tolerance decides, not that of the search along a line
        option.ls_tolerance = 0.1
        # friction harder than the springs of a soft floor, so that a sole hardly creeps
        option.impratio = 1000.0
        self.tune: Callable[[Any], None] = _leave
        """Called with each newly compiled model, for values that depend on the compiler's results."""
        self._starts: dict[str, float] = {}
        self._stale, self._moved = True, True
        self._model: Any = None
        self._data: Any = None
        self.set_gravity((0.0, 0.0, -settings.gravity))
        self.version = 0
        """Counts the compilations: addresses in model and data hold for one of them."""

    def changed(self) -> None:
        """The description changed; the bodies that are left keep their state."""
        self._stale = True

    def start_at(self, joint: str, position: float) -> None:
        """Give a joint that is not compiled yet an angle other than 0.

        Args:
            joint: Name in the description.
            position: rad.
        """
        self._starts[joint] = position
        self.changed()

    def _compile(self) -> None:
        if self._model is None:
            self._model = self.spec.compile()
            self._data = mujoco.MjData(self._model)
        else:
            self._model, self._data = self.spec.recompile(self._model, self._data)
        self._choose_midphase()
        self.tune(self._model)
        for joint, position in self._starts.items():
            self._data.joint(joint).qpos = position
        self._starts.clear()
        self.version += 1
        self._stale, self._moved = False, True

    def _choose_midphase(self) -> None:
        """Use MuJoCo's tree of geoms only for bodies with many, such as a field of tiles."""
        self._model.opt.disableflags &= ~_NO_MIDPHASE
        if self._model.body_geomnum.max() <= _MAX_FLAT_GEOMS:
            self._model.opt.disableflags |= _NO_MIDPHASE

    @property
    def model(self) -> Any:
        """MuJoCo's model."""
        if self._stale:
            self._compile()
        return self._model

    @property
    def data(self) -> Any:
        """MuJoCo's state; poses and velocities of bodies may be those of a step ago."""
        if self._stale:
            self._compile()
        return self._data

    def bring_up_to_date(self) -> None:
        """Compute the poses of all bodies and geoms as they are now."""
        data = self.data
        if self._moved:
            _place_bodies(self._model._address, data._address)
            self._moved = False

    @property
    def now(self) -> Any:
        """MuJoCo's state with the poses of all bodies and geoms as they are now."""
        self.bring_up_to_date()
        return self._data

    def moved(self) -> None:
        """Note a change of state from outside: poses of bodies must be computed again."""
        self._moved = True

    def set_gravity(self, gravity: Vec3) -> None:
        """World frame, m/s^2."""
        self.spec.option.gravity = gravity
        if self._model is not None:
            self._model.opt.gravity[:] = gravity


@dataclass(frozen=True)
class MujocoModel:
    """A robot's part of the description."""

    body: Body
    """Data sheet."""
    prefix: str
    """Prefix of every name."""
    joints: tuple[str, ...]
    """Mechanical joints in the data sheet's order, without prefix."""
    held: bool
    torso: Any
    """Description of the torso's body."""
    hinges: dict[str, Any]
    """Descriptions of the joints by name."""
    links: dict[str, Any]
    """Descriptions of the links' bodies by name."""
    shapes: dict[str, Any]
    """Descriptions of the shapes of links that have one, by name."""
    twins: dict[str, Any]
    """Further shapes of the soles, for other robots."""
    pairs: tuple[tuple[str, str], ...]
    """Links that can touch each other."""
    hook: Any
    """Description of the weld that can hold a free torso; None: the torso is held for good."""


def describe_robot(
    simulation: Simulation, body: Body, rotor_inertia: Array, *, held: bool, prefix: str = ""
) -> MujocoModel:
    """Add a robot in its zero pose, torso upright at the world's origin.

    Args:
        simulation: To which it is added.
        body: Data sheet.
        rotor_inertia: Reflected to each joint, (n,), in the tree's order, kg m^2; MuJoCo's armature.
        held: The torso is where it is put.
        prefix: Of the names of all its parts; another one for each robot.
    """
    spec, step = simulation.spec, simulation.settings.step
    torso = spec.worldbody.add_body(name=prefix + TORSO, mocap=held)
    if not held:
        torso.add_freejoint(name=prefix + TORSO)
    bodies, hinges = {TORSO: torso}, {}
    for (name, joint), rotor in zip(joint_tree(body).items(), rotor_inertia.tolist(), strict=True):
        link = bodies[joint.parent].add_body(name=prefix + name, pos=joint.offset)
        sheet = body.joints[name]
        hinges[name] = link.add_joint(
            name=prefix + name,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=joint.axis,
            armature=rotor,
            limited=True,
            range=(sheet.lower, sheet.upper),
            solref_limit=(TIME_CONSTANT_STEPS * step, 1.0),
            solimp_limit=IMPEDANCE,
            # of a blocked joint
            solref_friction=(2.0 * step, 1.0),
            solimp_friction=(0.999, 0.9999, 0.001, 0.5, 2.0),
        )
        bodies[name] = link
    for name, link in bodies.items():
        _set_inertia(link, body.links[name])
    shapes = {
        name: add_link_shape(spec, bodies[name], name, shape, step, prefix)
        for name, shape in link_shapes(body).items()
    }
    for side, name in FOOT_LINKS.items():
        add_sole_points(body, side, bodies[name], step, prefix)
    add_limb_pairs(spec, body, step, prefix)
    # one motor turns both HipYawPitch joints by the same angle
    gear = spec.add_equality(
        name=prefix + GEAR,
        type=mujoco.mjtEq.mjEQ_JOINT,
        name1=f"{prefix}LHipYawPitch",
        name2=f"{prefix}RHipYawPitch",
    )
    gear.objtype = mujoco.mjtObj.mjOBJ_JOINT
    gear.data[:5] = (0.0, 1.0, 0.0, 0.0, 0.0)
    gear.solref, gear.solimp = (TIME_CONSTANT_STEPS * step, 1.0), IMPEDANCE
    hook = None if held else _add_hook(spec, step, prefix)
    simulation.changed()
    pairs = tuple(sorted(collision_pairs(body)))
    return MujocoModel(body, prefix, tuple(hinges), held, torso, hinges, bodies, shapes, {}, pairs, hook)


def let_robots_touch(robots: Sequence[MujocoModel], step: float) -> None:
    """Enable contact between all robots; their soles have another shape for it, hard and with friction.

    The friction is that of `Body.shapes.shell_friction`: between shell and sole, between two soles too, and
    its square between two shells.

    Args:
        robots: All of the world.
        step: Physics step, s.
    """
    everyone = sum(_FIRST_ROBOT << number for number in range(len(robots)))
    for number, robot in enumerate(robots):
        own, shell = _FIRST_ROBOT << number, robot.body.shapes.shell_friction
        for name in robot.shapes.keys() & FOOT_LINKS.values() - robot.twins.keys():
            mesh, options = robot.prefix + name, contact_options("shell", step) | {"contype": 0}
            robot.twins[name] = robot.links[name].add_geom(
                type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, group=HIDDEN_GROUP, mass=0.0, **options
            )
        for name, shape in (robot.shapes | robot.twins).items():
            shape.contype, shape.conaffinity = shape.contype | own, everyone & ~own
            shape.friction = (shell if name in robot.twins else shell * shell, 0.0, 0.0)


def _add_hook(spec: Any, step: float, prefix: str) -> Any:
    """A weld that can hold a free torso to a place of the world; open at first."""
    hook = prefix + HOOK
    spec.worldbody.add_body(name=hook, mocap=True)
    weld = spec.add_equality(
        name=hook, type=mujoco.mjtEq.mjEQ_WELD, name1=hook, name2=prefix + TORSO, active=False
    )
    weld.objtype = mujoco.mjtObj.mjOBJ_BODY
    # anchor; the torso in the hook's frame, position and quaternion; weight of the rotation
    weld.data[:11] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    weld.solref, weld.solimp = (TIME_CONSTANT_STEPS * step, 1.0), IMPEDANCE
    return weld


def _set_inertia(body: Any, link: Link) -> None:
    body.explicitinertial = True
    body.mass, body.ipos, body.fullinertia = link.mass, link.com, link.inertia
