"""The robot with its drives as one MuJoCo model that needs nothing of this project.

Every mechanical joint is two hinges about one axis. The first, with the joint's name, is the motor behind its
gear: rotor inertia as armature, back-EMF as damping, a position servo with a torque limit and a delay. The
second, `<joint> gear`, is free within the backlash; its ends are springs with the gear's compliance. The fixed
tendon of the joint's name is their sum, the joint's true angle; dry friction acts on it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from bridge.body import TORSO, Body
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.scene import FLOOR, MujocoScene
from emulator.engine.mujoco.shapes import spring
from emulator.engine.mujoco.simulation import HOOK, MujocoModel, Simulation, describe_robot
from emulator.engine.settings import PhysicsSettings
from emulator.engine.shapes import FOOT_LINKS
from emulator.engine.values import Surface, Surroundings

_LEAST_GEAR_RANGE: Final = 1e-6
"""Width of a gear's range without backlash, rad: MuJoCo takes no empty one."""


@dataclass(frozen=True)
class Drive:
    """A joint's drive in numbers; see `emulator.servo.parameters`."""

    joint: str
    stall: float
    """Stall torque, N m."""
    no_load_speed: float
    """Speed without load, rad/s."""
    rotor_inertia: float
    """At the joint, kg m^2."""
    full_voltage_error: float
    """Position error that gets the full voltage, rad."""
    lead: float
    """Lead of the loop, s."""
    delay: float
    """Delay of a request, s."""
    backlash: float
    """Backlash of the gear, rad."""
    compliance: float
    """rad/(N m)"""
    relaxation: float
    """Relaxation time of the gear, s."""
    friction: float
    """Dry friction, N m."""

    @property
    def geared(self) -> bool:
        """The joint has a gear that gives way."""
        return self.backlash > 0.0 or self.compliance > 0.0


def mjcf(
    body: Body,
    drives: Sequence[Drive],
    surface: Surface,
    poses: Mapping[str, Mapping[str, float]],
    comment: str,
) -> str:
    """The model as a file's text.

    Args:
        body: Data sheet.
        drives: In the order of `bridge.body.joint_tree`.
        surface: Of the floor.
        poses: Key frames: angles of the mechanical joints by name, rad; the left sole is flat on the floor.
        comment: At the head of the file.
    """
    simulation = Simulation(PhysicsSettings())
    scene = MujocoScene(simulation)
    gravity = (0.0, 0.0, -simulation.settings.gravity)
    scene.surround(Surroundings(gravity, surface))
    rotors = np.array([drive.rotor_inertia for drive in drives])
    robot = describe_robot(simulation, body, rotors, held=False)
    scene.add_robot(robot)
    spec = simulation.spec
    spec.modelname, spec.comment = body.name, comment
    spec.delete(robot.hook)
    spec.delete(spec.body(HOOK))
    spec.body(FLOOR).mocap = False
    for drive in drives:
        _add_gear(spec, robot.hinges[drive.joint], drive)
    _add_actuators(spec, body, drives)
    _add_sensors(spec, body, robot, drives)
    _settle_springs(simulation, drives)
    model = spec.compile()
    for name, angles in poses.items():
        qpos = _stand(model, body, angles)
        ctrl = [angles[model.actuator(i).name] for i in range(model.nu)]
        spec.add_key(name=name, qpos=qpos, ctrl=ctrl)
    # without a key frame it begins on straight legs; inside the floor it would be flung away
    spec.body(TORSO).pos = _stand(model, body, {})[:3]
    spec.compile()
    return str(spec.to_xml())


def _gear(joint: str) -> str:
    return f"{joint} gear"


def _add_gear(spec: Any, motor: Any, drive: Drive) -> None:
    motor.damping = (drive.stall / drive.no_load_speed, 0.0, 0.0)
    tendon = spec.add_tendon(name=drive.joint, frictionloss=drive.friction)
    tendon.wrap_joint(drive.joint, 1.0)
    tendon.solref_friction, tendon.solimp_friction = motor.solref_friction, motor.solimp_friction
    if drive.geared:
        half = 0.5 * max(drive.backlash, _LEAST_GEAR_RANGE)
        spec.body(drive.joint).add_joint(
            name=_gear(drive.joint),
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=motor.axis,
            limited=True,
            range=(-half, half),
            solref_limit=motor.solref_limit,
            solimp_limit=motor.solimp_limit,
        )
        tendon.wrap_joint(_gear(drive.joint), 1.0)


def _add_actuators(spec: Any, body: Body, drives: Sequence[Drive]) -> None:
    """A position servo for each motor; one motor with both halves of the torque turns both hips."""
    for drive in drives:
        if drive.joint == "RHipYawPitch":
            continue
        stall = drive.stall * (2.0 if drive.joint == "LHipYawPitch" else 1.0)
        gain = stall / drive.full_voltage_error
        sheet, step = body.joints[drive.joint], spec.option.timestep
        steps = round(drive.delay / step)
        actuator = spec.add_actuator(
            name=drive.joint,
            target=drive.joint,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            ctrllimited=True,
            ctrlrange=(sheet.lower, sheet.upper),
            forcelimited=True,
            forcerange=(-stall, stall),
        )
        actuator.set_to_position(kp=gain, kv=gain * drive.lead)
        actuator.nsample, actuator.delay = steps, steps * step


def _add_sensors(spec: Any, body: Body, robot: MujocoModel, drives: Sequence[Drive]) -> None:
    """Joint angles, and the inertial unit."""
    for drive in drives:
        spec.add_sensor(
            name=drive.joint,
            type=mujoco.mjtSensor.mjSENS_TENDONPOS,
            objtype=mujoco.mjtObj.mjOBJ_TENDON,
            objname=drive.joint,
        )
    unit = body.inertial_unit
    for name, kind, place in (
        ("accelerometer", mujoco.mjtSensor.mjSENS_ACCELEROMETER, unit.accelerometer),
        ("gyroscope", mujoco.mjtSensor.mjSENS_GYRO, unit.gyroscope),
    ):
        robot.torso.add_site(name=name, pos=place)
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=name)


def _settle_springs(simulation: Simulation, drives: Sequence[Drive]) -> None:
    """Write the springs of soles and gears, which depend on the compiled model, into the description."""
    model, spec = simulation.model, simulation.spec
    for geom in spec.geoms:
        if geom.name.startswith(tuple(FOOT_LINKS.values())):
            compiled = model.geom(geom.name)
            geom.solref, geom.solimp, geom.friction = compiled.solref, compiled.solimp, compiled.friction
    for drive in drives:
        if drive.compliance > 0.0:
            dof = model.joint(_gear(drive.joint)).dofadr[0]
            inertia, step = model.dof_invweight0[dof], simulation.settings.step
            gear = spec.joint(_gear(drive.joint))
            gear.solref_limit, gear.solimp_limit = spring(
                1.0 / drive.compliance, drive.relaxation, step, inertia
            )


def _stand(model: Any, body: Body, angles: Mapping[str, float]) -> Any:
    """State with these joint angles, the left sole flat on the floor."""
    data = mujoco.MjData(model)
    for name, angle in angles.items():
        data.joint(name).qpos = angle
    mujoco.mj_kinematics(model, data)
    foot = data.body(FOOT_LINKS["L"])
    turn = foot.xmat.reshape(3, 3).T
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, turn.ravel())
    height = body.lengths.FootHeight - float((turn @ foot.xpos)[2])
    data.joint(TORSO).qpos = (0.0, 0.0, height, *quaternion)
    return data.qpos.copy()
