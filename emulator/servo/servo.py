"""The joints' drives at torque level: position loop, DC motor, gear with backlash, stiffness as current limit.

Each motor board closes a position loop on the motor's voltage (fraction u of the full one) around the motor's
own angle theta, counted at the joint. Behind the gear the motor has the torque-speed line of a DC motor; gear
and backlash are a damped spring c^-1 through a dead zone of width `backlash`:

    u   = clip((request - theta - lead qd) / full_voltage_error, -1, 1)
    tau = stall (u - theta' / no_load_speed)          |tau| <= stiffness * stall
    tau = (x + relaxation x') / c,  x = dead_zone(theta - q)

Stall torque and no-load speed come from the data sheet. The engine makes each joint feel its rotor's
inertia (`emulator.engine.multibody`), so the motor side here has none, and both lines meet in one implicit
Euler step: without the stiff state of a rotor of its own, and stable with any backlash and any gear, a rigid
one (c = 0) included. The price: within the backlash the link keeps the rotor's inertia.

With |tau| at the limit the motor is driven back by its load. Without stiffness it has no voltage.

HipYawPitch: one motor, two joints. The joints are geared together in the model; each gets half of the
motor's torque, so that the pair stalls where the one motor stalls.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.body.quantities import joint_no_load_speed, joint_nominal_torque, joint_stall_torque
from emulator.servo.friction import DryFriction
from emulator.servo.heat import MotorHeat
from emulator.servo.limits import RequestLimits
from emulator.servo.parameters import ServoParameters

Vector = NDArray[np.float64]


class Servo:
    """Drives of all mechanical joints of a body.

    Args:
        body: Data sheet.
        joints: Mechanical joints in the order of every vector here.
        parameters: Properties that the data sheet does not give.
        position: Request and motor angle of all joints at the start, rad.
        step: Time between two calls of `torque`, s.
    """

    def __init__(
        self, body: Body, joints: Sequence[str], parameters: ServoParameters, position: Vector, step: float
    ) -> None:
        fraction = np.array([0.5 if name.endswith("HipYawPitch") else 1.0 for name in joints])
        self.stall = np.array([joint_stall_torque(body, name) for name in joints]) * fraction
        """Maximum torque at each joint, N m."""
        self.no_load_speed = np.array([joint_no_load_speed(body, name) for name in joints])
        """rad/s"""
        self.backlash = np.array([parameters.backlash.of(name) for name in joints])
        """Width of each dead zone, rad; may be set from outside (a fault)."""
        self.strength = np.ones(len(joints))
        """Fraction of its torque that each motor has; may be set from outside (a fault)."""
        self.heat = MotorHeat(
            parameters.heating, np.array([joint_nominal_torque(body, name) for name in joints]) * fraction
        )
        self._slots = np.array([INDEX_WITH_MIRROR[name] for name in joints])
        self._limits = RequestLimits(body, joints)
        self._step = step
        self._gain = 1.0 / parameters.full_voltage_error
        # one step more, because the loop below takes the motor's angle of the last step
        self._lead = (parameters.lead + step) * self._gain
        self._back_emf = self.stall / self.no_load_speed
        self.rotor_inertia = parameters.motor_time_constant * self._back_emf
        """Rotor inertia reflected to each joint, kg m^2."""
        # One motor drives both hips: its whole current flows for the two halves of its torque.
        self._ampere = self.no_load_speed / (parameters.supply_voltage * fraction)
        self._voltage = parameters.supply_voltage
        self._yield = step / self._back_emf
        # implicit Euler for both lines: tau = ((1 + r) x - r x_before) * spring, x before the motor gives way
        self._memory = parameters.gear_relaxation / step
        self._spring = 1.0 / (parameters.gear_compliance + (1.0 + self._memory) * self._yield)
        self._compliance = parameters.gear_compliance
        self._brake = parameters.brake
        self._queue: deque[tuple[int, Vector, Vector]] = deque()
        self._delay = round(parameters.delay / step)
        self._clock = 0
        self._request: Vector = position.copy()
        self.motor_angle = position.copy()
        """Angle of each motor behind its gear, rad: the joint angle follows it with backlash and twist."""
        self._wanted: Vector = np.ones(len(joints))
        self._friction = None
        if parameters.dry_friction > 0.0:
            limit = np.full(len(joints), parameters.dry_friction)
            self._friction = DryFriction(limit, self.rotor_inertia, position)
        self._torque, self._out, self._gap, self._work, self._twist = np.zeros((5, len(joints)))
        self._squares, self._mean_square, self._works, self._mean_power = np.zeros((4, len(joints)))
        self._samples = 0
        self.apply_power()

    def latch(self, position: Sequence[float], stiffness: Sequence[float]) -> None:
        """Take over a request at the start of a cycle.

        Args:
            position: 25 angles in frame order, rad; clipped to the joints' ranges.
            stiffness: 25 values in frame order; clipped to at most 1.
        """
        request = self._limits.clip(np.array(position)[self._slots])
        wanted = np.minimum(np.array(stiffness)[self._slots], 1.0)
        self._queue.append((self._clock + self._delay, request, wanted))

    def start(self, position: Vector) -> None:
        """Hold these angles (rad) from now on with full stiffness, at rest; what was on its way is dropped."""
        self._queue.clear()
        self._request, self.motor_angle = position.copy(), position.copy()
        self._wanted = np.ones(len(position))
        self._twist[:] = 0.0
        self.apply_power()

    def apply_power(self) -> None:
        """Put stiffness, heat protection, `strength` and `backlash` in force; for whoever has set one."""
        self.stiffness = np.where(self._wanted > 0.0, self._wanted * self.heat.stiffness_factor(), self._wanted)
        """Stiffness in force: the request's, lowered by the heat protection."""
        fraction = np.where(self.stiffness == 0.0, self._brake, np.maximum(self.stiffness, 0.0))
        self._limit = self.stall * self.strength * fraction
        self._min_torque = -self._limit
        self._stride = np.where(self.stiffness > 0.0, self.no_load_speed * self._step, 0.0)
        self._half_backlash = 0.5 * self.backlash
        self._min_backlash = -self._half_backlash
        self._reach = self._half_backlash + self._limit * self._compliance
        self._min_reach = -self._reach

    def torque(self, position: Vector, velocity: Vector) -> Vector:
        """Torques for the next physics step; to be called once per step.

        Args:
            position: Joint angles, (n,), rad.
            velocity: Joint velocities, (n,), rad/s.

        Returns:
            Joint torques, (n,), N m; the next call overwrites the vector.
        """
        if self._queue and self._queue[0][0] <= self._clock:
            _, self._request, self._wanted = self._queue.popleft()
            self.apply_power()
        self._clock += 1
        torque, gap, work = self._torque, self._gap, self._work
        # Voltage: u = clip((request - theta - lead qd) / full_voltage_error, -1, 1). Without load the motor
        # would turn by u no_load_speed dt in this step (0 without stiffness); `gap` is then its angle theta - q
        # before the joint.
        np.subtract(self._request, self.motor_angle, out=work)
        work *= self._gain
        np.multiply(velocity, self._lead, out=gap)
        work -= gap
        np.minimum(work, 1.0, out=work)
        np.maximum(work, -1.0, out=work)
        work *= self._stride
        np.subtract(self.motor_angle, position, out=gap)
        gap += work
        # Torque: the part of the gap beyond the dead zone, x = gap - clip(gap, -backlash/2, backlash/2), twists
        # gear and motor in series. Implicit Euler of both, with r = relaxation / dt:
        # tau = ((1 + r) x - r x_before) / (c + (1 + r) dt no_load_speed / stall), |tau| <= stiffness * stall.
        np.minimum(gap, self._half_backlash, out=work)
        np.maximum(work, self._min_backlash, out=work)
        np.subtract(gap, work, out=torque)
        torque *= 1.0 + self._memory
        np.multiply(self._twist, self._memory, out=work)
        torque -= work
        torque *= self._spring
        np.minimum(torque, self._limit, out=torque)
        np.maximum(torque, self._min_torque, out=torque)
        # Motor: the torque holds it back by tau dt no_load_speed / stall. It stays within reach of the joint,
        # half the dead zone and the twist at the limit; a larger load turns it. Its new angle is q + gap.
        np.multiply(torque, self._yield, out=work)
        gap -= work
        np.minimum(gap, self._reach, out=gap)
        np.maximum(gap, self._min_reach, out=gap)
        np.minimum(gap, self._half_backlash, out=work)
        np.maximum(work, self._min_backlash, out=work)
        np.subtract(gap, work, out=self._twist)
        np.add(position, gap, out=self.motor_angle)
        # Heat and currents: sums of tau^2 and of the power tau qd over the cycle.
        np.multiply(torque, torque, out=work)
        self._squares += work
        np.multiply(torque, velocity, out=work)
        self._works += work
        self._samples += 1
        if self._friction is None:
            return torque
        np.copyto(self._out, torque)
        self._friction.resist(position, velocity, self._out)
        return self._out

    def end_cycle(self) -> None:
        """Take stock of the torques since the last call: currents and heat."""
        np.divide(self._squares, max(self._samples, 1), out=self._mean_square)
        np.divide(self._works, max(self._samples, 1), out=self._mean_power)
        if self.heat.active:
            self.heat.update(self._mean_square, self._samples * self._step)
            if self.heat.lowers:
                self.apply_power()
        self._squares[:] = 0.0
        self._works[:] = 0.0
        self._samples = 0

    def current(self) -> Vector:
        """Effective motor currents of the last cycle, A: torque over torque constant, at the motor shaft."""
        return np.sqrt(self._mean_square) * self._ampere

    def drawn(self) -> float:
        """Current that all motors drew from the battery in the last cycle, A.

        A motor on the fraction u of the full voltage draws u times its current. The power is the heat in the
        armature's resistance, tau^2 / (stall / no-load speed), and the work tau qd. Power that a driven motor
        returns is lost in its board (assumed).
        """
        power = self._mean_square / self._back_emf + self._mean_power
        return float(np.maximum(power, 0.0).sum()) / self._voltage
