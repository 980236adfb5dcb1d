"""The joints' drives at torque level: limits of requests, position loop, motor, gear with backlash.

Each motor board closes a position loop on the motor's voltage (fraction u of the full one) around the motor's
own angle theta, counted at the joint. Behind the gear the motor has the torque-speed line of a DC motor; gear
and backlash are a damped spring c^-1 through a dead zone of width `backlash`:

    u   = clip((request - theta - lead qd) / full_voltage_error, -1, 1)
    tau = stall (u - theta' / no_load_speed)          |tau| <= stiffness * stall
    tau = (x + relaxation x') / c,  x = dead_zone(theta - q)

Stall torque and no-load speed are from the data sheet. The engine makes each joint feel its rotor's
inertia (`emulator.engine.base`), so the motor side here has none, and both lines meet in one implicit
Euler step: without the stiff state of a rotor of its own, and stable with any backlash and any gear, a rigid
one (c = 0) included. The price: within the backlash the link keeps the rotor's inertia.

With |tau| at the limit the motor is driven back by its load. Without stiffness it has no voltage.

Dry friction of the gear is a brush that bends before it slides:

    f = -clip(k (q - a) + d qd, -F, F),   the foot a of the brush dragged along at |q - a| = F / k
    F = dry_friction + load_friction |tau|

Within the brush's reach a joint sticks like a spring, beyond it the friction is Coulomb's. PyBullet's own
velocity motors would hold it without that millirad of deflection, but on every joint they make a physics step
two to three times as long (measured).

One heat store per motor, simulated from the current as the robot's own boards do: temperature - room approaches
rise x (torque / nominal torque)^2 with one time constant. Status 0 is cool; from `warm` (1) the stiffness falls
linearly to 70 % at `hot` (2) and from there to nothing at `critical` (3). The three meanings are the vendor's;
the temperatures and the lines between are assumed.

HipYawPitch: one motor, two joints. The joints are geared together in the model; each gets half of the
motor's torque, so that the pair stalls where the one motor stalls.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.body.quantities import (
    COUPLED_TO,
    CoupledRange,
    joint_no_load_speed,
    joint_nominal_torque,
    joint_stall_torque,
)
from bridge.types import Array, Vec3
from emulator.compiled import compilable, compiled
from emulator.drives import BRUSH_REACH, Drives, put_in_force
from emulator.servo.parameters import Heating, ServoParameters

HOT_FACTOR: Final = 0.7
"""Factor of the stiffness at status 2 (vendor: lowered by more than 30 %)."""


class MotorHeat:
    """Temperatures of all motors.

    Args:
        heating: Numbers of the model.
        nominal: Torque at each joint that the motor bears for ever, N m.
    """

    def __init__(self, heating: Heating, nominal: Array) -> None:
        self.active = heating.rise > 0.0
        """Temperatures change at all."""
        self.temperature = np.full(len(nominal), heating.room)
        """Degrees Celsius; may be set from outside (a fault)."""
        self._heating = heating
        self._rise = heating.rise / nominal**2
        self.levels = (heating.warm, heating.hot, heating.critical)
        """Temperature at which the status changes, degrees Celsius."""

    def update(self, mean_square_torque: Array, dt: float) -> None:
        """Heat and cool for a while.

        Args:
            mean_square_torque: Of each joint's motor, (n,), (N m)^2.
            dt: s.
        """
        gain = -math.expm1(-dt / self._heating.time_constant)
        _approach(self.temperature, mean_square_torque, self._rise, self._heating.room, gain)

    def status(self) -> list[int]:
        """0 cool, 1 stiffness lowered, 2 by more than 30 %, 3 none left."""
        levels: list[int] = np.searchsorted(self.levels, self.temperature, side="right").tolist()
        return levels


@compiled
def _approach(temperature: Array, square: Array, rise: Array, room: float, gain: float) -> None:
    for i in range(len(temperature)):
        temperature[i] += (room + rise[i] * square[i] - temperature[i]) * gain


@compiled
def stiffness_factor(temperature: float, levels: Vec3) -> float:
    """Factor by which the protection lowers a requested stiffness.

    Args:
        temperature: Of the motor, degrees Celsius.
        levels: `MotorHeat.levels`.
    """
    warm, hot, critical = levels
    if temperature < warm:
        return 1.0
    if temperature < hot:
        return (HOT_FACTOR - 1.0) / (hot - warm) * (temperature - warm) + 1.0
    if temperature < critical:
        return (0.0 - HOT_FACTOR) / (critical - hot) * (temperature - hot) + HOT_FACTOR
    return 0.0


class RequestLimits:
    """Clips requests as the robot's boards do.

    A coupled joint's range follows the *request* of the joint it is coupled to (assumed: the tables' page
    leaves open whether request or measurement counts).

    Args:
        body: Data sheet.
        joints: Mechanical joints in the order of the requests.
    """

    def __init__(self, body: Body, joints: Sequence[str]) -> None:
        self._lower = np.array([body.joints[name].lower for name in joints])
        self._upper = np.array([body.joints[name].upper for name in joints])
        coupled = [(a, b) for a, b in COUPLED_TO.items() if a in joints and b in joints]
        places = [(joints.index(a), joints.index(b)) for a, b in coupled]
        self._places = np.array(places, dtype=np.int64).reshape(-1, 2)
        tables = [np.array(CoupledRange(body, joint).table).T.copy() for joint, _ in coupled]
        self._tables = np.concatenate([np.zeros((3, 0)), *tables], axis=1)
        """One after the other."""
        self._ends = np.cumsum([0, *(table.shape[1] for table in tables)])

    def clip(self, request: Array) -> Array:
        """The nearest allowed request, rad."""
        return _clip(request, self._lower, self._upper, self._places, self._tables, self._ends)


@compiled
def _clip(
    request: Array,
    lower: Array,
    upper: Array,
    places: NDArray[np.int64],
    tables: Array,
    ends: NDArray[np.int64],
) -> Array:
    allowed: Array = np.minimum(np.maximum(request, lower), upper)
    for i in range(len(places)):
        # clip the request of a joint by that of the other, linear between the table's rows (assumed)
        joint, other, table = places[i, 0], places[i, 1], tables[:, ends[i] : ends[i + 1]]
        at = allowed[other]
        low, high = _between(at, table[0], table[1]), _between(at, table[0], table[2])
        allowed[joint] = min(max(allowed[joint], low), high)
    return allowed


@compilable
def _between(at: float, places: Array, values: Array) -> float:
    """Linear between the rows of a table, its end values outside."""
    if at <= places[0]:
        return float(values[0])
    for i in range(1, len(places)):
        if at < places[i]:
            slope = (values[i] - values[i - 1]) / (places[i] - places[i - 1])
            return float(slope * (at - places[i - 1]) + values[i - 1])
    return float(values[-1])


@compiled
def set_power(drives: NDArray[Any], temperature: Array, levels: Vec3) -> None:
    """Put the stiffness asked for, heat protection, `strength` and `backlash` in force.

    Args:
        drives: Of `DRIVE`, (n,); changed.
        temperature: Of the motors, (n,), degrees Celsius.
        levels: For `stiffness_factor`.
    """
    for i in range(len(drives)):
        drives[i].derating = stiffness_factor(temperature[i], levels)
        put_in_force(drives[i])


@compiled
def end_cycle(drives: NDArray[Any], steps: int) -> None:
    """Take stock of a cycle and begin the next.

    Args:
        drives: Of `DRIVE`, (n,); changed.
        steps: Of the cycle.
    """
    for i in range(len(drives)):
        drive = drives[i]
        drive.mean_square = drive.squares / steps
        # A motor on the fraction u of the full voltage draws u times its current: the heat in the armature's
        # resistance, and the work. Power that a driven motor returns is lost in its board (assumed).
        heat = drive.mean_square / (drive.stall_torque / drive.no_load_speed)
        drive.power = max(heat + drive.work / steps, 0.0)
        drive.squares = drive.work = 0.0


class Servo:
    """Drives of all mechanical joints of a body.

    Args:
        body: Data sheet.
        joints: Mechanical joints in the order of every vector here.
        parameters: Properties that the data sheet does not give.
        position: Request and motor angle of all joints at the start, rad.
        step: Physics step, s.
    """

    def __init__(
        self, body: Body, joints: Sequence[str], parameters: ServoParameters, position: Array, step: float
    ) -> None:
        fraction = np.array([0.5 if name.endswith("HipYawPitch") else 1.0 for name in joints])
        self.stall = np.array([joint_stall_torque(body, name) for name in joints]) * fraction
        """Maximum torque at each joint, N m."""
        self.no_load_speed = np.array([joint_no_load_speed(body, name) for name in joints])
        """Speed without load, rad/s."""
        self.heat = MotorHeat(
            parameters.heating, np.array([joint_nominal_torque(body, name) for name in joints]) * fraction
        )
        self._room = parameters.heating.room
        self._slots = np.array([INDEX_WITH_MIRROR[name] for name in joints])
        self._limits = RequestLimits(body, joints)
        self._step = step
        self._back_emf = self.stall / self.no_load_speed
        self.drives = Drives(parameters.motor_time_constant * self._back_emf)
        """For the engine, which runs them."""
        # One motor drives both hips: its whole current flows for the two halves of its torque.
        self._ampere = self.no_load_speed / (parameters.supply_voltage * fraction)
        self._voltage = parameters.supply_voltage
        self._queue: deque[tuple[int, Array, Array]] = deque()
        self.delay_steps = round(parameters.delay / step)
        """Physics steps from `latch` to the motor boards."""
        self._clock = 0
        self._set_constants(parameters)
        self.backlash[:] = [parameters.backlash.of(name) for name in joints]
        self.strength[:] = 1.0
        self._samples = 0
        self.restart(position)

    @property
    def motor_angle(self) -> Array:
        """Angle of each motor behind its gear, rad: the joint angle follows it with backlash and twist."""
        return self._of_all("motor_angle")

    @property
    def stiffness(self) -> Array:
        """Stiffness in force: the request's, lowered by the heat protection."""
        return self._of_all("stiffness")

    @property
    def backlash(self) -> Array:
        """Width of each dead zone, rad; may be written to (a fault)."""
        return self._of_all("backlash")

    @property
    def strength(self) -> Array:
        """Fraction of its torque that each motor has; may be written to (a fault)."""
        return self._of_all("strength")

    def _of_all(self, field: str) -> Array:
        values: Array = self.drives.records[field]
        return values

    def _set_constants(self, parameters: ServoParameters) -> None:
        drives = self.drives.records
        drives["stall_torque"], drives["no_load_speed"] = self.stall, self.no_load_speed
        drives["gain"] = gain = 1.0 / parameters.full_voltage_error
        # one step more, because the loop takes the motor's angle of the last step
        drives["lead"] = (parameters.lead + self._step) * gain
        drives["droop"] = self._step / self._back_emf
        # implicit Euler for both lines: tau = ((1 + r) x - r x_before) * spring, x before the motor gives way
        drives["memory"] = memory = parameters.gear_relaxation / self._step
        drives["spring"] = 1.0 / (parameters.gear_compliance + (1.0 + memory) * drives["droop"])
        drives["friction"], drives["load_friction"] = parameters.dry_friction, parameters.load_friction
        drives["brush_stiffness"] = stiffness = parameters.dry_friction / BRUSH_REACH
        # half critical for the rotor
        drives["brush_damping"] = np.sqrt(stiffness * self.drives.rotor_inertia)
        drives["no_load_stride"] = self.no_load_speed * self._step
        drives["brake"], drives["compliance"] = parameters.brake, parameters.gear_compliance

    def latch(self, position: Sequence[float], stiffness: Sequence[float], elapsed: int = 0) -> None:
        """Take over a request at the start of a cycle; of two at one instant the later one counts.

        Args:
            position: 25 angles in frame order, rad; clipped to the joints' ranges.
            stiffness: 25 values in frame order; clipped to at most 1.
            elapsed: Steps of the cycle that have run already, at most `delay_steps`.
        """
        request = self._limits.clip(np.array(position).take(self._slots))
        wanted = np.minimum(np.array(stiffness).take(self._slots), 1.0)
        due = self._clock - elapsed + self.delay_steps
        if self._queue and self._queue[-1][0] == due:
            self._queue.pop()
        self._queue.append((due, request, wanted))

    def restart(self, position: Array) -> None:
        """As `start`, with motors at the temperature of the room and no memory of earlier torques."""
        drives = self.drives.records
        drives["brush"] = position
        for field in ("squares", "work", "mean_square", "power"):
            drives[field] = 0.0
        self.heat.temperature[:] = self._room
        self.start(position)

    def start(self, position: Array) -> None:
        """Hold these angles (rad) from now on with full stiffness, at rest; waiting commands are dropped."""
        self._queue.clear()
        drives = self.drives.records
        drives["request"] = drives["motor_angle"] = position
        drives["twist"] = 0.0
        drives["wanted"] = 1.0
        self.apply_power()

    def apply_power(self) -> None:
        """Put stiffness, heat protection, `strength` and `backlash` in force, after one is set."""
        set_power(self.drives.records, self.heat.temperature, self.heat.levels)

    def advance(self, steps: int) -> None:
        """Let the clock run, and the drives take over the request that is due; to be called before they run.

        Args:
            steps: Physics steps until the next call, at most a cycle.
        """
        self.drives.change = -1
        if self._queue and self._queue[0][0] < self._clock + steps:
            records = self.drives.records
            due, records["next_request"], records["next_wanted"] = self._queue.popleft()
            self.drives.change = max(due - self._clock, 0)
        self._clock += steps
        self._samples += steps

    def end_cycle(self) -> None:
        """Take stock of the torques since the last call: currents and heat."""
        end_cycle(self.drives.records, max(self._samples, 1))
        if self.heat.active:
            self.heat.update(self._of_all("mean_square"), self._samples * self._step)
            self.apply_power()
        self._samples = 0

    def current(self) -> Array:
        """Effective motor currents of the last cycle, A: torque over torque constant, at the motor shaft."""
        return np.sqrt(self._of_all("mean_square")) * self._ampere

    @property
    def stall_current(self) -> Array:
        """Stall current of each motor, A."""
        return np.asarray(self.stall * self._ampere, dtype=np.float64)

    def drawn(self) -> float:
        """Current that all motors drew from the battery in the last cycle, A."""
        return float(self._of_all("power").sum()) / self._voltage
