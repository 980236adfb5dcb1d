"""The frames of a cycle boundary: all sensors in LoLA's order of joints, and the ground truth.

Hands have a motor of their own and no joint in the model. The fingers are part of the forearm's or wrist's
link; only their opening is followed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.fall import FALLEN_TILT
from bridge.body.joints import INDEX, INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.messages import Contact, SensorFrame, TruthFrame
from bridge.messages.game import NO_GAME, RobotGame
from bridge.messages.world_state import WorldObject
from bridge.types import Array, Vec3
from emulator.compiled import compiled
from emulator.engine.values import BodyState, FootLoad, GroundContacts
from emulator.sensors.suite import Sensors
from emulator.servo.servo import Servo

OPENING_TIME: Final = 0.5
"""From closed to open, s (assumed)."""
_SLOTS: Final = (INDEX["LHand"], INDEX["RHand"])


class Hands:
    """Both hands of a body; an H21 has none, and its slots read 0.

    Args:
        body: Data sheet.
        angles: Start posture in frame order.
    """

    def __init__(self, body: Body, angles: Sequence[float]) -> None:
        self.slots: frozenset[int] = frozenset(_SLOTS if body.model == "H25" else ())
        """Frame slots that are hands of this body."""
        self._opening = {slot: angles[slot] for slot in self.slots}
        self._request = dict(self._opening)
        self._stiffness = dict.fromkeys(self.slots, 1.0)

    def latch(self, position: Sequence[float], stiffness: Sequence[float]) -> None:
        """Take over a request.

        Args:
            position: 25 in frame order; those of the hands are openings, clipped to 0..1.
            stiffness: 25 in frame order; a hand whose stiffness is not above 0 stays where it is.
        """
        for slot in self.slots:
            self._request[slot] = min(1.0, max(0.0, position[slot]))
            self._stiffness[slot] = min(1.0, stiffness[slot])

    def run_cycle(self, dt: float) -> None:
        """Move for dt seconds at the motor's pace; without stiffness the gear holds the hand where it is."""
        reach = dt / OPENING_TIME
        for slot in self.slots:
            if self._stiffness[slot] > 0.0:
                way = self._request[slot] - self._opening[slot]
                self._opening[slot] += min(reach, max(-reach, way))

    def put(self, position: list[float]) -> tuple[float, ...]:
        """Positions in frame order with the openings in their slots."""
        return _put(position, self._opening)

    def put_stiffness(self, stiffness: list[float]) -> tuple[float, ...]:
        """Stiffnesses in frame order with those of the hands in their slots."""
        return _put(stiffness, self._stiffness)


def _put(values: list[float], hands: dict[int, float]) -> tuple[float, ...]:
    for slot, value in hands.items():
        values[slot] = value
    return tuple(values)


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
            **sensors.read(contacts),
            command=command,
            missed=missed,
        )


@compiled
def _by_slot(
    slots: Places, joints: Places, angle: Array, stiffness: Array, current: Array, temperature: Array
) -> Array:
    """Values of the mechanical joints, each (n,), in frame order, (4, 25), 0 for all others."""
    samples = np.zeros((4, N_JOINTS))
    for i in range(len(slots)):
        slot, joint = slots[i], joints[i]
        samples[0, slot], samples[1, slot] = angle[joint], stiffness[joint]
        samples[2, slot], samples[3, slot] = current[joint], temperature[joint]
    return samples


FALLEN_HEIGHT: Final = 0.5


def truth_frame(
    seq: int,
    time: float,
    torso: BodyState,
    contacts: GroundContacts,
    joints: tuple[float, ...],
    com: Vec3,
    height: float,
    leds: tuple[int, ...] = (),
    objects: tuple[WorldObject, ...] = (),
    game: RobotGame = NO_GAME,
) -> TruthFrame:
    """Ground truth of one boundary.

    Args:
        seq: Number of the boundary.
        time: Robot time, s.
        torso: Its true state.
        contacts: Ground reactions.
        joints: True angles in frame order, rad.
        com: Centre of mass, world frame, m.
        height: Of the torso over the floor, as a fraction of that with the legs straight.
        leds: Brightness of each LED, 0 to 255; empty: all are dark.
        objects: The movable ones of the world, and fixed ones that came after its start.
        game: The league's game.
    """
    return TruthFrame(
        seq=seq,
        time=time,
        torso_position=torso.position,
        torso_orientation=torso.orientation,
        torso_velocity=torso.velocity,
        torso_angular_velocity=torso.angular_velocity,
        joints=joints,
        com=com,
        zmp=contacts.zmp,
        left=_contact(contacts.feet["L"]),
        right=_contact(contacts.feet["R"]),
        fell=bool(contacts.touching) or not upright(torso) or height < FALLEN_HEIGHT,
        leds=leds,
        objects=objects,
        game=game,
    )


def upright(torso: BodyState) -> bool:
    """Whether the torso leans by less than the tilt of a fallen robot."""
    return bool(torso.rotation[8] >= math.cos(FALLEN_TILT))


def _contact(load: FootLoad) -> Contact:
    return Contact(force=load.force, cop=load.cop)
