"""The emulated robot in process: commands in, sensor frames out, one DCM cycle at a time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import TracebackType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.datasheet import Body, joint_tree
from bridge.errors import ConfigurationError
from bridge.joints import INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.messages import (
    ActuatorFrame,
    Contact,
    Quaternion,
    SensorFrame,
    TruthFrame,
    require_finite,
)
from emulator.contacts import FootLoad
from emulator.dcm import Dcm
from emulator.engine import bullet, connect, disconnect
from emulator.hands import Hands
from emulator.mechanics import Mechanics
from emulator.model import build_model
from emulator.sensors.encoders import Encoders
from emulator.sensors.fsr import FootForceSensors
from emulator.sensors.imu import InertialSensors
from emulator.servo import Servo
from emulator.start import place, start_posture
from emulator.wear import WearProfile
from emulator.world import WorldParameters, build_world

ROOM_TEMPERATURE: Final = 25.0
"""Reported for every motor and the battery: heating is not simulated yet, degrees Celsius."""
SONAR_RANGE: Final = 2.55
"""Reported by both sonars: nothing stands in the world yet, m."""
DEFAULT_WORLD: Final = WorldParameters()
IDEAL: Final = WearProfile(name="ideal")
FALLEN_TILT: Final = math.cos(math.radians(45.0))


class EmulatedRobot:
    """A robot that is not there.

    It starts in its posture with full stiffness and holds it until a command comes.

    Args:
        body: Data sheet.
        seed: Of the one random generator that everything random here draws from.
        posture: Start posture by name, or 25 angles in frame order, rad.
        world: Physics settings.
        wear: State of the drives and sensors.
        settle: Time in which the robot may settle into its posture before `seq` 0, s.
        orientation: Of the torso at the start; None: soles level.
        lift: Height of the soles over the floor at the start, m.
        held: The torso is nailed to the world (test benches).

    Raises:
        ConfigurationError: unknown posture, or a cycle that is no whole number of physics steps.
    """

    def __init__(
        self,
        body: Body,
        *,
        seed: int,
        posture: str | Sequence[float] = "StandInit",
        world: WorldParameters = DEFAULT_WORLD,
        wear: WearProfile = IDEAL,
        settle: float = 0.5,
        orientation: Quaternion | None = None,
        lift: float = 0.0,
        held: bool = False,
    ) -> None:
        self.body = body
        self._seed = seed
        self._start = start_posture(posture)
        self._world_parameters, self._wear = world, wear
        self._settle = round(settle / body.cycle)
        self._orientation, self._lift, self._held = orientation, lift, held
        self._steps = round(body.cycle / world.step)
        if self._steps < 1 or abs(self._steps * world.step - body.cycle) > 1e-9:
            raise ConfigurationError(
                f"A physics step of {world.step:g} s does not divide the {body.cycle:g} s cycle of {body.name}."
            )
        self._encoders = Encoders(body.encoder_steps)
        self._feet = {"L": FootForceSensors(body.fsr.L), "R": FootForceSensors(body.fsr.R)}
        self._client = connect()
        self._build()

    def _build(self) -> None:
        """Everything that a reset makes anew."""
        self.random = np.random.default_rng(self._seed)
        """Source of all that is random in this robot; the ideal sensors and servos draw nothing from it."""
        self.world = build_world(self._client, self._world_parameters)
        joints = tuple(joint_tree(self.body))
        self._slots = [INDEX_WITH_MIRROR[name] for name in joints]
        request = np.array(self._start)[self._slots]
        servo = Servo(self.body, joints, self._wear.servo, request, self._world_parameters.step)
        model = build_model(
            self._client, self.body, rotor_inertia=servo.rotor_inertia.tolist(), fixed=self._held
        )
        place(model, self.body, self._start, self._orientation, self._lift)
        self.mechanics = Mechanics(model, servo, self._steps)
        self._hands = Hands(self.body, self._start)
        self.dcm = Dcm(self.body, self._start)
        """Timed commands and aliases; actuator frames go through it too."""
        present = set(self._slots) | self._hands.slots
        self._temperature = tuple(ROOM_TEMPERATURE if i in present else 0.0 for i in range(N_JOINTS))
        self.absent = tuple(name for i, name in enumerate(JOINTS) if i not in present)
        """Joints of the frame that this body does not have."""
        self._torso = self.mechanics.torso()
        self._imu = InertialSensors(
            self.body.inertial_unit, self._world_parameters.gravity, self.body.cycle, self._torso
        )
        for _ in range(self._settle):
            self._run_cycle()
        self._contacts = self.mechanics.contacts()
        self._start_height = self._torso.position[2]
        self._seq = 0
        self._command = -1
        self._missed = 0
        self.frame = self._sample()
        """The present boundary's sensor frame."""

    def _run_cycle(self) -> None:
        self.mechanics.run_cycle()
        self._hands.run_cycle(self.body.cycle)
        self._torso = self.mechanics.torso()
        self._imu.update(self._torso)

    def advance(self, command: ActuatorFrame | None, *, expected: bool = False) -> SensorFrame:
        """Latch the command, run one cycle, sample.

        Args:
            command: The newest command, or None: the last one stays in force.
            expected: A controller was to serve this cycle; without an answer to its frame it counts as missed.

        Returns:
            The frame of the new boundary.

        Raises:
            FrameError: a position or stiffness that is not a finite number.
        """
        if command is not None:
            require_finite("position", command.position)
            require_finite("stiffness", command.stiffness)
            self.dcm.put_frame(command.position, command.stiffness)
            self._command = command.reply_to
        if expected and (command is None or command.reply_to < self._seq):
            self._missed += 1
        targets = self.dcm.run_cycle()
        if targets is not None:
            self.mechanics.servo.latch(targets.position, targets.stiffness)
            self._hands.latch(targets.position, targets.stiffness)
        self._run_cycle()
        self._contacts = self.mechanics.contacts()
        self._seq += 1
        self.frame = self._sample()
        return self.frame

    def _by_slot(self, values: NDArray[np.float64]) -> list[float]:
        """Values of the mechanical joints in frame order; the two hips share the left one's slot."""
        slots = [0.0] * N_JOINTS
        # backwards, so that the left hip, first in the model, has the last word
        for slot, value in zip(reversed(self._slots), reversed(values.tolist()), strict=True):
            slots[slot] = value
        return slots

    def _sample(self) -> SensorFrame:
        servo, inertial = self.mechanics.servo, self._imu.sample
        loads = self._contacts.feet
        return SensorFrame(
            seq=self._seq,
            time=self._seq * self.body.cycle,
            position=self._hands.put(self._by_slot(self._encoders.read(self.mechanics.position))),
            stiffness=self._hands.put_stiffness(self._by_slot(servo.stiffness)),
            current=tuple(self._by_slot(servo.current())),
            temperature=self._temperature,
            fsr=(
                *self._feet["L"].share(loads["L"].normal_force, loads["L"].cop),
                *self._feet["R"].share(loads["R"].normal_force, loads["R"].cop),
            ),
            accelerometer=inertial.acceleration,
            gyroscope=inertial.rate,
            angle=inertial.angle,
            touch=(0.0,) * 14,
            battery=(1.0, 0.0, 0.0, ROOM_TEMPERATURE),
            sonar=(SONAR_RANGE, SONAR_RANGE),
            command=self._command,
            missed=self._missed,
        )

    def truth(self) -> TruthFrame:
        """Ground truth at the present boundary."""
        torso, contacts = self._torso, self._contacts
        fell = (
            contacts.fallen or torso.rotation[8] < FALLEN_TILT or torso.position[2] < 0.5 * self._start_height
        )
        return TruthFrame(
            seq=self._seq,
            time=self._seq * self.body.cycle,
            torso_position=torso.position,
            torso_orientation=torso.orientation,
            torso_velocity=torso.velocity,
            torso_angular_velocity=torso.angular_velocity,
            joints=self._hands.put(self._by_slot(self.mechanics.position)),
            com=self.mechanics.com(),
            zmp=contacts.zmp,
            left=_contact(contacts.feet["L"]),
            right=_contact(contacts.feet["R"]),
            fell=fell,
        )

    def reset(self) -> None:
        """Begin anew: same posture, same seed, `seq` 0."""
        bullet.resetSimulation(physicsClientId=self._client)
        self._build()

    def close(self) -> None:
        """Free the physics client; may be called twice."""
        if self._client >= 0:
            disconnect(self._client)
            self._client = -1

    def __enter__(self) -> EmulatedRobot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _contact(load: FootLoad) -> Contact:
    return Contact(force=load.force, cop=load.cop)
