"""The calibrated robot as a MuJoCo model (MJCF)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bridge.body import Body, joint_tree
from bridge.body.joints import INDEX_WITH_MIRROR
from emulator.engine.mujoco.export import Drive, mjcf
from emulator.servo.servo import Servo
from emulator.wear import WearProfile
from emulator.world.world import WOOD


def drives_of(body: Body, wear: WearProfile) -> list[Drive]:
    """Drives of all mechanical joints in the tree's order."""
    joints, parameters = tuple(joint_tree(body)), wear.servo
    servo = Servo(body, joints, parameters, np.zeros(len(joints)), step=0.001)
    return [
        Drive(
            joint=name,
            stall=float(servo.stall[i]),
            no_load_speed=float(servo.no_load_speed[i]),
            rotor_inertia=float(servo.drives.rotor_inertia[i]),
            full_voltage_error=parameters.full_voltage_error,
            lead=parameters.lead,
            delay=parameters.delay,
            backlash=float(servo.backlash[i]),
            compliance=parameters.gear_compliance,
            relaxation=parameters.gear_relaxation,
            friction=parameters.dry_friction,
        )
        for i, name in enumerate(joints)
    ]


def to_mjcf(body: Body, wear: WearProfile, poses: Mapping[str, Sequence[float]], notice: str) -> str:
    """The robot on a wooden floor as an MJCF file's text.

    Args:
        body: Data sheet.
        wear: State of the drives; the sensors are ideal.
        poses: Key frames by name: 25 angles in frame order, rad.
        notice: At the head of the file.
    """
    slots = {name: INDEX_WITH_MIRROR[name] for name in joint_tree(body)}
    angles = {key: {name: pose[slot] for name, slot in slots.items()} for key, pose in poses.items()}
    return mjcf(body, drives_of(body, wear), WOOD, angles, notice)
