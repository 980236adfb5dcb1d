"""The joints' drives at torque level: position loop, DC motor with gear, stiffness as a current limit.

Each motor board closes a position loop on the motor's voltage:

    u   = clip((request - q) / full_voltage_error - lead * qd / full_voltage_error, -1, 1)
    tau = stall * (u - qd / no_load_speed), |tau| <= stiffness * stall

which is the torque-speed line of a DC motor (torque falls linearly to zero at the no-load speed) at every
voltage, seen behind the gear. Stall torque and no-load speed come from the data sheet; the loop is assumed.

HipYawPitch: one motor, two joints. The joints are geared together in the model; each gets half of the
motor's torque, so that the pair stalls where the one motor stalls.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from bridge.datasheet import Body
from bridge.joints import INDEX_WITH_MIRROR

Vector = NDArray[np.float64]


class ServoParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the data sheet does not say about a drive; all assumed."""

    full_voltage_error: float = 0.025
    """Position error at which the loop gives full voltage, rad."""
    lead: float = 0.0025
    """Derivative time of the loop, s."""
    delay_cycles: int = 0
    """Cycles from a request to its use in the loop."""
    motor_time_constant: float = 0.004
    """Mechanical time constant of the motors, rotor inertia x no-load speed / stall torque, s: gives the rotor
    inertia that each joint feels behind its gear."""
    dry_friction: float = 0.0
    """Dry friction of each joint, N m: PyBullet's velocity motor at rest with this torque."""
    supply_voltage: float = 21.6
    """V; gives the torque constant: volts per no-load speed."""


class Servo:
    """Drives of all mechanical joints of a body.

    Args:
        body: Data sheet.
        joints: Mechanical joints in the order of every vector here.
        parameters: The assumed part of the drives.
        position: Request of all joints at the start, rad.
    """

    def __init__(
        self, body: Body, joints: Sequence[str], parameters: ServoParameters, position: Vector
    ) -> None:
        sheets = [body.joints[name] for name in joints]
        motors = [body.motors[sheet.motor] for sheet in sheets]
        gears = np.array([sheet.gear_ratio for sheet in sheets])
        share = np.array([0.5 if name.endswith("HipYawPitch") else 1.0 for name in joints])
        motor_speed = np.array([motor.no_load_speed_rpm for motor in motors]) * (2.0 * math.pi / 60.0)
        self.stall = np.array([motor.stall_torque for motor in motors]) * gears * share
        """Largest torque at each joint, N m."""
        self.no_load_speed = motor_speed / gears
        """rad/s"""
        self._lower = np.array([sheet.lower for sheet in sheets])
        self._upper = np.array([sheet.upper for sheet in sheets])
        self._slots = np.array([INDEX_WITH_MIRROR[name] for name in joints])
        self._gain = 1.0 / parameters.full_voltage_error
        self._damping = parameters.lead / parameters.full_voltage_error
        self._back_emf = self.stall / self.no_load_speed
        self.rotor_inertia = parameters.motor_time_constant * self._back_emf
        """Rotor inertia reflected to each joint, kg m^2."""
        # One motor drives both hips: its whole current flows for the two halves of its torque.
        self._ampere = motor_speed / (parameters.supply_voltage * gears * share)
        self._queue: deque[tuple[Vector, Vector]] = deque()
        self._delay = parameters.delay_cycles
        self._request = position.copy()
        self.stiffness = np.ones(len(joints))
        """Stiffness in force."""
        self._limit = self.stall.copy()
        self._torque = np.zeros(len(joints))

    def latch(self, position: Sequence[float], stiffness: Sequence[float]) -> None:
        """Take over a request at the start of a cycle: 25 positions (rad) and stiffnesses in frame order.

        Positions are clipped to the joints' limits, stiffnesses to at most 1.
        """
        request = np.clip(np.array(position)[self._slots], self._lower, self._upper)
        self._queue.append((request, np.minimum(np.array(stiffness)[self._slots], 1.0)))

    def begin_cycle(self) -> None:
        """Put the request in force that has waited long enough, if there is one."""
        if len(self._queue) > self._delay:
            self._request, self.stiffness = self._queue.popleft()
            self._limit = self.stall * np.maximum(self.stiffness, 0.0)

    def torque(self, position: Vector, velocity: Vector) -> Vector:
        """Torques for the next physics step, N m, from the joints' angles (rad) and speeds (rad/s).

        The vector is overwritten by the next call.
        """
        voltage = (self._request - position) * self._gain
        voltage -= velocity * self._damping
        np.minimum(voltage, 1.0, out=voltage)
        np.maximum(voltage, -1.0, out=voltage)
        torque = self._torque
        np.multiply(voltage, self.stall, out=torque)
        torque -= self._back_emf * velocity
        np.minimum(torque, self._limit, out=torque)
        np.maximum(torque, -self._limit, out=torque)
        return torque

    def current(self) -> Vector:
        """Motor currents of the last step, A, absolute: torque over the torque constant, at the motor shaft."""
        return np.asarray(np.abs(self._torque) * self._ampere)
