"""From the robot's state at a cycle boundary to a sensor frame in LoLA's order of joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.messages import SensorFrame
from bridge.types import Array
from emulator.compiled import compiled
from emulator.engine.values import GroundContacts
from emulator.hands import Hands
from emulator.sensors.suite import Sensors
from emulator.servo.servo import Servo

Places = NDArray[np.int64]


class FrameSampler:
    """Reads all sensors of a robot once per cycle.

    Args:
        joints: Mechanical joints in the order of every vector of drives and engine.
        servo: The drives.
        sensors: Everything that measures.
        hands: The hands.
        room: Temperature of the hands' motors, which stay cool, degrees Celsius.
    """

    def __init__(
        self, joints: Sequence[str], servo: Servo, sensors: Sensors, hands: Hands, room: float
    ) -> None:
        # the two hips share a slot; the left one, first in the model, is read
        places = {INDEX_WITH_MIRROR[name]: i for i, name in reversed(list(enumerate(joints)))}
        self._slots, self._joints = np.array(list(places)), np.array(list(places.values()))
        self._servo, self._sensors, self._hands, self._room = servo, sensors, hands, room
        present = places.keys() | hands.slots
        self.absent = tuple(name for i, name in enumerate(JOINTS) if i not in present)
        """Joints of the frame that this body does not have."""

    def angles(self, position: Array) -> tuple[float, ...]:
        """Angles of the mechanical joints (n,), rad, and the hands' openings, in frame order."""
        slots = np.zeros(N_JOINTS)
        slots[self._slots] = position[self._joints]
        return self._hands.put(slots.tolist())

    def sample(
        self, position: Array, contacts: GroundContacts, *, seq: int, time: float, command: int, missed: int
    ) -> SensorFrame:
        """The frame of a boundary.

        Args:
            position: True angles of the mechanical joints, (n,), rad.
            contacts: Of the cycle that ends here.
            seq: Number of the boundary.
            time: Robot time, s.
            command: `reply_to` of the command in force.
            missed: Cycles without an answer so far.
        """
        sensors, servo = self._sensors, self._servo
        inertial = sensors.inertial.sample
        measured, stiffness, current, temperature = _by_slot(
            self._slots,
            self._joints,
            sensors.encoders.read(position),
            servo.stiffness,
            servo.current(),
            servo.heat.temperature,
        ).tolist()
        for slot in self._hands.slots:
            temperature[slot] = self._room
        return SensorFrame(
            seq=seq,
            time=time,
            position=self._hands.put(measured),
            stiffness=self._hands.put_stiffness(stiffness),
            current=tuple(current),
            temperature=tuple(temperature),
            fsr=sensors.forces(contacts),
            accelerometer=inertial.acceleration,
            gyroscope=inertial.rate,
            angle=inertial.angle,
            touch=sensors.touch.read(contacts.feet),
            battery=sensors.battery.read(),
            sonar=sensors.sonars.read(),
            command=command,
            missed=missed,
        )


@compiled
def _by_slot(
    slots: Places, joints: Places, angle: Array, stiffness: Array, current: Array, temperature: Array
) -> Array:
    """Values of the mechanical joints, each (n,), in frame order, (4, 25), 0 for all others."""
    found = np.zeros((4, N_JOINTS))
    for i in range(len(slots)):
        slot, joint = slots[i], joints[i]
        found[0, slot], found[1, slot] = angle[joint], stiffness[joint]
        found[2, slot], found[3, slot] = current[joint], temperature[joint]
    return found
