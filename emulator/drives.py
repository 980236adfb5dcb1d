"""The drives' part in a physics step: the equations of `emulator.servo.servo`, joint by joint, as machine code.

One record holds constants and state of a drive, so that a step takes one array: of one robot, or of many at
once.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bridge.types import Array
from emulator.compiled import compilable, compiled

BRUSH_REACH: Final = 0.001
"""Deflection of the dry friction's brush, rad: less than one count of the encoder (assumed)."""

DRIVE: Final = np.dtype(
    [
        (name, np.float64)
        for name in (
            # state
            "request",  # of the angle, rad
            "motor_angle",  # theta, counted at the joint, rad
            "twist",  # x, of the gear, rad
            "brush",  # foot a of the brush of the dry friction, rad
            "squares",  # sum of tau^2 since the cycle began, (N m)^2
            "work",  # sum of tau qd, W
            # the last cycle
            "mean_square",  # of tau, (N m)^2
            "power",  # drawn from the battery, W
            # position loop and motor
            "gain",  # full voltages per error, 1/rad
            "lead",  # full voltages per speed, s/rad
            "stride",  # way without load at full voltage in a step, rad; 0 without stiffness
            "limit",  # of the torque by stiffness, strength and brake, N m
            "droop",  # way that a torque takes away in a step, rad/(N m)
            # gear
            "half_backlash",  # rad
            "reach",  # largest angle between motor and joint, rad
            "memory",  # r = relaxation / step
            "spring",  # of motor and gear in series, N m/rad
            # dry friction
            "friction",  # F, N m
            "load_friction",  # its share of the torque
            "brush_stiffness",  # N m/rad
            "brush_damping",  # N m s/rad
            # data sheet
            "stall_torque",  # N m
            "no_load_speed",  # rad/s
            "no_load_stride",  # way without load at full voltage in a step, rad
            "brake",  # fraction of the stall torque up to which the motor brakes at stiffness 0
            "compliance",  # of the gear, rad/(N m)
            # set from outside: requests, heat and faults
            "next_request",  # of the angle, that `take_over` puts in force, rad
            "next_wanted",  # stiffness, likewise
            "wanted",  # stiffness asked for
            "derating",  # factor of the stiffness by the heat protection
            "strength",  # fraction of its torque that the motor has
            "backlash",  # width of the dead zone, rad
            # in force
            "stiffness",  # the one asked for, lowered by the heat protection
        )
    ]
)
"""One drive."""


class Drives:
    """The drives of one robot.

    Args:
        rotor_inertia: Of each motor, reflected to its joint, (n,), in the order of `bridge.body.joint_tree`,
            kg m^2.
    """

    def __init__(self, rotor_inertia: Array) -> None:
        self.rotor_inertia = rotor_inertia
        self.records: NDArray[Any] = np.zeros(len(rotor_inertia), DRIVE)
        """Constants and state, (n,), of `DRIVE`; a drive of zeros has no torque. An engine may move them."""
        self.change = -1
        """Step of the next run, from 0, before which the drives take over their next request; -1: none."""

    def move(self, records: NDArray[Any]) -> None:
        """Keep the records in this memory, (n,), from now on."""
        records[:] = self.records
        self.records = records


@compiled
def run_drives(drives: NDArray[Any], position: Array, velocity: Array, torque: Array) -> None:
    """Run the drives for one physics step.

    Args:
        drives: Of `DRIVE`, (n,); the state changes.
        position: Joint angles, (n,), rad.
        velocity: Joint velocities, (n,), rad/s.
        torque: For the joints, (n,), N m; written.
    """
    for i in range(len(drives)):
        drive, q, qd = drives[i], position[i], velocity[i]
        # Voltage: u = clip((request - theta - lead qd) / full_voltage_error, -1, 1). Without load the motor
        # would turn by u no_load_speed dt in this step (0 without stiffness); `gap` is then its angle theta - q
        # before the joint.
        u = (drive.request - drive.motor_angle) * drive.gain - qd * drive.lead
        gap = drive.motor_angle - q + max(min(u, 1.0), -1.0) * drive.stride
        # Torque: the part of the gap beyond the dead zone, x = gap - clip(gap, -backlash/2, backlash/2), twists
        # gear and motor in series. Implicit Euler of both, with r = relaxation / dt:
        # tau = ((1 + r) x - r x_before) / (c + (1 + r) dt no_load_speed / stall), |tau| <= stiffness * stall.
        x = gap - max(min(gap, drive.half_backlash), -drive.half_backlash)
        tau = (x * (1.0 + drive.memory) - drive.twist * drive.memory) * drive.spring
        tau = max(min(tau, drive.limit), -drive.limit)
        # Motor: the torque holds it back by tau dt no_load_speed / stall. It stays within reach of the joint,
        # half the dead zone and the twist at the limit; a larger load turns it. Its new angle is q + gap.
        gap = gap - tau * drive.droop
        gap = max(min(gap, drive.reach), -drive.reach)
        drive.twist = gap - max(min(gap, drive.half_backlash), -drive.half_backlash)
        drive.motor_angle = q + gap
        # Heat and currents: sums of tau^2 and of the power tau qd over the cycle.
        drive.squares += tau * tau
        drive.work += tau * qd
        # Dry friction: a brush that bends by q - a before it slides, the foot a dragged along at its reach:
        # f = -clip(k (q - a) + d qd, -F, F).
        bend = max(min(q - drive.brush, BRUSH_REACH), -BRUSH_REACH)
        drive.brush = q - bend
        # The load presses the teeth together: it adds to F and to the brush's stiffness.
        load = drive.load_friction * abs(tau)
        f = bend * (drive.brush_stiffness + load / BRUSH_REACH) + qd * drive.brush_damping
        torque[i] = tau - max(min(f, drive.friction + load), -drive.friction - load)


@compiled
def take_over(drives: NDArray[Any]) -> None:
    """Put the next request of each drive in force.

    Args:
        drives: Of `DRIVE`, (n,); changed.
    """
    for i in range(len(drives)):
        drive = drives[i]
        drive.request, drive.wanted = drive.next_request, drive.next_wanted
        put_in_force(drive)


@compilable
def put_in_force(drive: Any) -> None:
    """Put the stiffness asked for, heat protection, `strength` and `backlash` of a drive in force."""
    stiffness = drive.wanted
    if stiffness > 0.0:
        stiffness *= drive.derating
    fraction = drive.brake if stiffness == 0.0 else max(stiffness, 0.0)
    drive.stiffness = stiffness
    drive.limit = drive.stall_torque * drive.strength * fraction
    drive.stride = drive.no_load_stride if stiffness > 0.0 else 0.0
    drive.half_backlash = 0.5 * drive.backlash
    drive.reach = drive.half_backlash + drive.limit * drive.compliance
