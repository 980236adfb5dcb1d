"""The robot in MuJoCo's description, built from the data sheet when it starts.

Link frames are the zero-pose aligned joint frames of the data sheet.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from bridge.body import TORSO, Body, joint_tree
from bridge.body.model import Link
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.shapes import (
    STIFF,
    TIME_CONSTANT_STEPS,
    add_link_shape,
    add_sole_points,
    let_limbs_meet,
)
from emulator.engine.mujoco.simulation import Simulation
from emulator.engine.multibody import Vector
from emulator.engine.shapes import FOOT_LINKS, collision_pairs, link_shapes

GEAR: Final = "hips"
"""Name of the equality that couples the two HipYawPitch joints."""
HOOK: Final = "hook"
"""Name of what can hold the torso, body and equality."""


@dataclass(frozen=True)
class MujocoModel:
    """What a robot added to the description."""

    joints: tuple[str, ...]
    """Mechanical joints in the data sheet's order."""
    held: bool
    torso: Any
    """Description of the torso's body."""
    hinges: dict[str, Any]
    """Descriptions of the joints by name."""
    pairs: tuple[tuple[str, str], ...]
    """Links that meet each other."""
    hook: Any
    """Description of the weld that can hold a free torso; None: the torso is held for good."""


def describe_robot(simulation: Simulation, body: Body, rotor_inertia: Vector, *, held: bool) -> MujocoModel:
    """Add a robot in its zero pose, torso upright at the world's origin.

    Args:
        simulation: Without a robot.
        body: Data sheet.
        rotor_inertia: Reflected to each joint, (n,), in the tree's order, kg m^2; MuJoCo's armature.
        held: The torso is where it is put.
    """
    spec, step = simulation.spec, simulation.settings.step
    torso = spec.worldbody.add_body(name=TORSO, mocap=held)
    if not held:
        torso.add_freejoint(name=TORSO)
    bodies, hinges = {TORSO: torso}, {}
    for (name, joint), rotor in zip(joint_tree(body).items(), rotor_inertia.tolist(), strict=True):
        link = bodies[joint.parent].add_body(name=name, pos=joint.offset)
        sheet = body.joints[name]
        hinges[name] = link.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=joint.axis,
            armature=rotor,
            limited=True,
            range=(sheet.lower, sheet.upper),
            solref_limit=(TIME_CONSTANT_STEPS * step, 1.0),
            solimp_limit=STIFF,
            # of a blocked joint
            solref_friction=(2.0 * step, 1.0),
            solimp_friction=(0.999, 0.9999, 0.001, 0.5, 2.0),
        )
        bodies[name] = link
    for name, link in bodies.items():
        _set_inertia(link, body.links[name])
    for name, shape in link_shapes(body).items():
        add_link_shape(spec, bodies[name], name, shape, step)
    for side, name in FOOT_LINKS.items():
        add_sole_points(body, side, bodies[name], step)
    let_limbs_meet(spec, body, step)
    # one motor turns both HipYawPitch joints by the same angle
    gear = spec.add_equality(
        name=GEAR, type=mujoco.mjtEq.mjEQ_JOINT, name1="LHipYawPitch", name2="RHipYawPitch"
    )
    gear.objtype = mujoco.mjtObj.mjOBJ_JOINT
    gear.data[:5] = (0.0, 1.0, 0.0, 0.0, 0.0)
    gear.solref, gear.solimp = (TIME_CONSTANT_STEPS * step, 1.0), STIFF
    hook = None if held else _add_hook(spec, step)
    simulation.changed()
    return MujocoModel(tuple(hinges), held, torso, hinges, tuple(sorted(collision_pairs(body))), hook)


def _add_hook(spec: Any, step: float) -> Any:
    """A weld that can hold a free torso to a place of the world; open at first."""
    spec.worldbody.add_body(name=HOOK, mocap=True)
    weld = spec.add_equality(name=HOOK, type=mujoco.mjtEq.mjEQ_WELD, name1=HOOK, name2=TORSO, active=False)
    weld.objtype = mujoco.mjtObj.mjOBJ_BODY
    # anchor; the torso in the hook's frame, position and quaternion; weight of the rotation
    weld.data[:11] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    weld.solref, weld.solimp = (TIME_CONSTANT_STEPS * step, 1.0), STIFF
    return weld


def _set_inertia(body: Any, link: Link) -> None:
    body.explicitinertial = True
    body.mass, body.ipos, body.fullinertia = link.mass, link.com, link.inertia
