"""All sensors of a robot together: from its true state to the sensor part of a frame."""

from __future__ import annotations

import numpy as np

from bridge.body import Body
from emulator.engine.base import Engine
from emulator.engine.values import GroundContacts, TorsoState
from emulator.sensors.battery import Battery
from emulator.sensors.encoders import Encoders
from emulator.sensors.fsr import FootForceSensors
from emulator.sensors.fsr_cells import ForceCells
from emulator.sensors.imu import InertialSensors
from emulator.sensors.parameters import SensorParameters
from emulator.sensors.sonar import Sonars
from emulator.sensors.touch import Touch


class Sensors:
    """Everything that measures.

    Every sensor, and in it every effect, has a generator of its own: switching one effect on changes no other.

    Args:
        body: Data sheet.
        parameters: Imperfections.
        random: The robot's generator; only children of it are drawn from.
        engine: With the robot, taken to have been at rest as it is now.
        charger: The robot is on its charger's cable.
    """

    def __init__(
        self,
        body: Body,
        parameters: SensorParameters,
        random: np.random.Generator,
        engine: Engine,
        *,
        charger: bool,
    ) -> None:
        encoders, cells, inertial, sonars = random.spawn(4)
        self.encoders = Encoders(body.encoder_steps, len(engine.robot.joints), parameters.encoders, encoders)
        self._left, self._right = FootForceSensors(body.fsr.L), FootForceSensors(body.fsr.R)
        self.cells = ForceCells(body.fsr.range, body.cycle, parameters.fsr, cells)
        gravity, torso = engine.settings.gravity, engine.robot.torso()
        self.inertial = InertialSensors(body.inertial_unit, parameters, inertial, gravity, body.cycle, torso)
        self.touch = Touch()
        self.battery = Battery(parameters.battery, body.battery_energy, body.cycle, charger=charger)
        self.sonars = Sonars(engine, parameters.sonar, body.cycle, sonars)

    def update(self, torso: TorsoState, drawn: float) -> None:
        """The end of a cycle, for all that has a memory.

        Args:
            torso: Its true state now.
            drawn: From the battery by all motors, A.
        """
        self.inertial.update(torso)
        self.sonars.update(torso)
        self.battery.update(drawn)

    def forces(self, contacts: GroundContacts) -> tuple[float, ...]:
        """Readings of the eight force cells, left foot first, N; once per cycle."""
        left, right = contacts.feet["L"], contacts.feet["R"]
        on_left = self._left.distribute(left.normal_force, left.cop)
        on_right = self._right.distribute(right.normal_force, right.cop)
        return self.cells.read(np.array((*on_left, *on_right)))
