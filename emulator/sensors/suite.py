"""All sensors of a robot together; battery, encoders, bumpers and touch areas."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np

from bridge.body import Body
from bridge.errors import ConfigurationError
from bridge.types import Array, Side, Vec2, Vec3
from emulator.compiled import compiled
from emulator.engine.base import Engine, Multibody
from emulator.engine.values import BodyState, FootLoad, GroundContacts
from emulator.sensors.fsr import FootForceSensors, ForceCells
from emulator.sensors.imu import InertialSensors
from emulator.sensors.parameters import BatteryParameters, EncoderParameters, NormalRows, SensorParameters
from emulator.sensors.sonar import Sonars

DISCHARGING: Final = 0x0028
"""Status word without a charger: it discharges (0x20), its discharge transistor is on (0x08)."""
CHARGING: Final = 0x8088
"""Status word on the charger: it is supplied (0x8000) and charged (0x80). The bits are as a ROS driver names
them, and agree with a captured packet of a robot on its charger, 0x80d8."""
FULL: Final = 0x0040
"""Bit of a full battery."""
FULL_FROM: Final = 0.985
"""Charge from which that bit is set (assumed; the captured packet has it at 0.99)."""
SECONDS_PER_HOUR: Final = 3600.0
TOUCH: Final = (
    "chest",
    "head_front",
    "head_middle",
    "head_rear",
    "left_bumper_left",
    "left_bumper_right",
    "left_hand_back",
    "left_hand_left",
    "left_hand_right",
    "right_bumper_left",
    "right_bumper_right",
    "right_hand_back",
    "right_hand_left",
    "right_hand_right",
)
"""In the order of `SensorFrame.touch`."""
BUMPERS: Final[dict[Side, dict[str, Vec2]]] = {
    "L": {"left": (0.0876, 0.019), "right": (0.0876, -0.014)},
    "R": {"left": (0.0876, 0.014), "right": (0.0876, -0.019)},
}
"""Places of the switches, AnkleRoll frame, x and y, m (vendor's hardware pages and URDFs)."""
REACH: Final = 0.035
"""Distance at which a push on the rim presses a bumper, m (assumed: the two shells cover the toes)."""


class Battery:
    """Runs down with the current that the computers and motors draw, unless the robot is on its charger.

    A gauge only: an empty battery does not switch the robot off.

    Args:
        parameters: Its numbers.
        energy: Of a full one as good as new, W h.
        cycle: Time between two updates, s.
        charger: The charger supplies the current; the charge stays.
    """

    def __init__(
        self, parameters: BatteryParameters, energy: float, cycle: float, *, charger: bool = False
    ) -> None:
        p = parameters
        holds = p.capacity * energy * SECONDS_PER_HOUR
        self._per_ampere = cycle * p.voltage / holds if holds > 0.0 and not charger else 0.0
        self._state = CHARGING if charger else DISCHARGING
        self._idle, self._heating, self._room = p.idle_current, p.heating, p.room
        self._gain = min(1.0, cycle / p.heating_time)
        self.charge = p.charge
        """0..1; may be set from outside."""
        self.temperature = p.room
        """Degrees Celsius; may be set from outside."""
        self._current = 0.0

    def update(self, motors: float) -> None:
        """One cycle.

        Args:
            motors: Current of all motors, A.
        """
        current = self._idle + motors
        self._current = -current
        self.charge = max(0.0, self.charge - current * self._per_ampere)
        target = self._room + self._heating * current * current
        self.temperature += self._gain * (target - self.temperature)

    def read(self) -> tuple[float, float, float, float]:
        """Charge 0..1, current A (negative: flows out), status, temperature in degrees Celsius."""
        return self.charge, self._current, self._status(), self.temperature

    def _status(self) -> float:
        """The status word as robots send it: a signed 16 bit integer in a float."""
        word = self._state | (FULL if self.charge >= FULL_FROM else 0)
        return float(word - 0x10000 if word & 0x8000 else word)


class Encoders:
    """Readings of the encoders of all joints.

    Captured V6 packets are on a grid of 2 pi / 4096 that is off whole counts by the same amount on every joint,
    with a sign that is the joint's own: the grid is shifted, the reading stays true to half a step.

    Args:
        steps: Counts per turn (data sheet).
        count: Number of joints.
        parameters: Imperfections.
        random: A generator of their own.
    """

    def __init__(
        self, steps: int, count: int, parameters: EncoderParameters, random: np.random.Generator
    ) -> None:
        constants, noise = random.spawn(2)
        self._step = 2.0 * math.pi / steps if parameters.grid else 0.0
        self.shift: Array = np.where(constants.random(count) < 0.5, -1.0, 1.0) * parameters.residue
        """Place of each joint's grid, rad."""
        self.zero_error: Array = constants.standard_normal(count) * parameters.zero_error
        """Excess of each joint's reading, rad."""
        self._noise = parameters.noise
        self._rows = NormalRows(noise, count)

    def read(self, angles: Array) -> Array:
        """Measured angles of true ones, rad."""
        return _read(angles, self.zero_error, self._noise, self._rows.next(), self.shift, self._step)


@compiled
def _read(angles: Array, zero_error: Array, deviation: float, noise: Array, shift: Array, step: float) -> Array:
    read = np.empty_like(angles)
    for i in range(len(angles)):
        read[i] = angles[i] + zero_error[i] + noise[i] * deviation
        if step > 0.0:
            read[i] = np.rint((read[i] - shift[i]) / step) * step + shift[i]
    return read


class Touch:
    """State of all buttons."""

    def __init__(self) -> None:
        self._pressed = [0.0] * len(TOUCH)

    def press(self, name: str, value: float = 1.0) -> None:
        """Press a button until it is set to 0 again.

        Args:
            name: One of `TOUCH`.
            value: 1 pressed, 0 released.

        Raises:
            ConfigurationError: no such button, or another value.
        """
        if name not in TOUCH:
            raise ConfigurationError(f"No button `{name}`; known are {', '.join(TOUCH)}.")
        if value not in (0.0, 1.0):
            raise ConfigurationError(f"Button `{name}` set to {value}; 0 or 1 is expected.")
        self._pressed[TOUCH.index(name)] = float(value)

    def read(self, feet: Mapping[Side, FootLoad]) -> tuple[float, ...]:
        """All buttons, 0 or 1; the bumpers from the points at which something pushes on the rim of a foot."""
        pressed = self._pressed.copy()
        for side, load in feet.items():
            if load.rim:
                for name in _bumped(side, load.rim):
                    pressed[TOUCH.index(name)] = 1.0
        return tuple(pressed)


def _bumped(side: Side, rim: Iterable[Vec3]) -> set[str]:
    """Bumpers of a foot that something pushes at these points, AnkleRoll frame."""
    foot = "left" if side == "L" else "right"
    pressed = set()
    for point in rim:
        distance, bumper = min((math.dist(point[:2], place), name) for name, place in BUMPERS[side].items())
        if distance < REACH:
            pressed.add(f"{foot}_bumper_{bumper}")
    return pressed


class Sensors:
    """All sensors of a robot.

    Every sensor, and in it every effect, has a generator of its own: switching one effect on changes no other.

    Args:
        body: Data sheet.
        parameters: Imperfections.
        random: The robot's generator; only children of it are drawn from.
        engine: The world.
        robot: Taken to have been at rest as it is now.
        charger: The robot is on its charger's cable.
    """

    def __init__(
        self,
        body: Body,
        parameters: SensorParameters,
        random: np.random.Generator,
        engine: Engine,
        robot: Multibody,
        *,
        charger: bool,
    ) -> None:
        encoders, cells, inertial, sonars = random.spawn(4)
        self.encoders = Encoders(body.encoder_steps, len(robot.joints), parameters.encoders, encoders)
        self._left, self._right = FootForceSensors(body.fsr.L), FootForceSensors(body.fsr.R)
        self.cells = ForceCells(body.fsr.range, body.cycle, parameters.fsr, cells)
        gravity, torso = engine.settings.gravity, robot.state()
        self.inertial = InertialSensors(body.inertial_unit, parameters, inertial, gravity, body.cycle, torso)
        self.touch = Touch()
        self.battery = Battery(parameters.battery, body.battery_energy, body.cycle, charger=charger)
        self.sonars = Sonars(engine, robot, parameters.sonar, body.cycle, sonars)

    def update(self, torso: BodyState, drawn: float) -> None:
        """The end of a cycle, for all that has a memory.

        Args:
            torso: Its true state now.
            drawn: From the battery by all motors, A.
        """
        self.inertial.update(torso)
        self.sonars.update(torso)
        self.battery.update(drawn)

    def read(self, contacts: GroundContacts) -> dict[str, Any]:
        """Field of the sensor frame -> reading, of all sensors but the joints'; once per cycle.

        Args:
            contacts: Of the cycle that ends here.
        """
        inertial = self.inertial.sample
        return {
            "fsr": self._forces(contacts),
            "accelerometer": inertial.acceleration,
            "gyroscope": inertial.rate,
            "angle": inertial.angle,
            "touch": self.touch.read(contacts.feet),
            "battery": self.battery.read(),
            "sonar": self.sonars.read(),
        }

    def _forces(self, contacts: GroundContacts) -> tuple[float, ...]:
        """Readings of the eight force cells, left foot first, N."""
        left, right = contacts.feet["L"], contacts.feet["R"]
        on_left = self._left.distribute(left.normal_force, left.cop)
        on_right = self._right.distribute(right.normal_force, right.cop)
        return self.cells.read(np.array((*on_left, *on_right)))
