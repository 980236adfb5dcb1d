"""The emulated robot in process: commands in, sensor frames out, one DCM cycle at a time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.datasheet import Body, joint_tree
from bridge.dcm import Dcm
from bridge.errors import ConfigurationError
from bridge.joints import INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.messages import (
    ActuatorFrame,
    Notice,
    Quaternion,
    SensorFrame,
    TruthFrame,
    require_finite,
)
from emulator.engine import bullet, connect, disconnect
from emulator.faults import Faults
from emulator.hands import Hands
from emulator.mechanics import Mechanics
from emulator.model import build_model
from emulator.scenarios import FLAT, Scenario
from emulator.sensors.suite import Sensors
from emulator.servo import Servo
from emulator.start import place, start_posture
from emulator.stops import Stops
from emulator.truth import truth_frame
from emulator.wear import WearProfile
from emulator.world import WorldParameters
from emulator.world.stage import Stage
from emulator.world.timeline import build_world, timeline

DEFAULT_WORLD: Final = WorldParameters()
IDEAL: Final = WearProfile(name="ideal")


class EmulatedRobot:
    """A robot that is not there.

    It starts in its posture with full stiffness and holds it until a command comes.

    Args:
        body: Data sheet.
        seed: Of the one random generator that everything random here draws from.
        posture: Start posture by name, or 25 angles in frame order, rad; None: the scenario's.
        world: Physics settings.
        scenario: Ground, and what happens when.
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
        posture: str | Sequence[float] | None = None,
        world: WorldParameters = DEFAULT_WORLD,
        scenario: Scenario = FLAT,
        wear: WearProfile = IDEAL,
        settle: float = 0.5,
        orientation: Quaternion | None = None,
        lift: float = 0.0,
        held: bool = False,
    ) -> None:
        self.body = body
        self._seed = seed
        self.posture = start_posture(scenario.start.posture if posture is None else posture)
        """Where it starts, and stands up to: 25 angles in frame order, rad."""
        self._scenario = scenario
        self._world_parameters, self._wear = world, wear
        self._settle = round(settle / body.cycle)
        self._orientation, self._lift, self._held = orientation, lift, held
        self._steps = round(body.cycle / world.step)
        if self._steps < 1 or abs(self._steps * world.step - body.cycle) > 1e-9:
            raise ConfigurationError(
                f"A physics step of {world.step:g} s does not divide the {body.cycle:g} s cycle of {body.name}."
            )
        self._client = connect()
        self._build()

    def _build(self) -> None:
        """Everything that a reset makes anew."""
        self.random = np.random.default_rng(self._seed)
        """Source of all that is random in this robot; the ideal sensors and servos draw nothing from it."""
        # children draw from streams of their own: a scenario does not change the noise of the sensors
        terrain, chance = self.random.spawn(2)
        self.world = build_world(self._client, self._world_parameters, self._scenario, terrain)
        joints = tuple(joint_tree(self.body))
        self._slots = [INDEX_WITH_MIRROR[name] for name in joints]
        request = np.array(self.posture)[self._slots]
        servo = Servo(self.body, joints, self._wear.servo, request, self._world_parameters.step)
        model = build_model(
            self._client, self.body, rotor_inertia=servo.rotor_inertia.tolist(), fixed=self._held
        )
        start = self._scenario.start
        at = (start.x, start.y, math.radians(start.yaw))
        place(model, self.body, self.posture, self._orientation, self._lift, self.world, at)
        stops = Stops(self.body, joints, servo.rotor_inertia, self._world_parameters.step)
        self.mechanics = Mechanics(model, servo, self._steps, stops)
        self._hands = Hands(self.body, self.posture)
        self.dcm = Dcm(self.body, self.posture)
        """Timed commands and aliases; actuator frames go through it too."""
        present = set(self._slots) | self._hands.slots
        self.absent = tuple(name for i, name in enumerate(JOINTS) if i not in present)
        """Joints of the frame that this body does not have."""
        self._torso = self.mechanics.torso()
        self.sensors = Sensors(
            self.body,
            self._wear.sensors,
            self.random,
            model,
            self._world_parameters.gravity,
            self._torso,
            charger=self._scenario.charger,
        )
        """Everything that measures; `sensors.touch` presses buttons."""
        self._currents = self._by_slot(servo.current())
        for _ in range(self._settle):
            self._run_cycle()
        self._contacts = self.mechanics.contacts(self.world)
        self._start_height = self.world.clearance(self._torso.position)
        self._seq = 0
        self._notices: list[Notice] = []
        self.stage = Stage(self.world, self.mechanics, self.body, timeline(self._scenario), self._say)
        """Carries out what happens in the world."""
        self.faults = Faults(
            self.mechanics, self.sensors.inertial.rezero, self._scenario.faults, chance, self._say
        )
        """What goes wrong."""
        self._command = -1
        self._missed = 0
        self.frame = self._sample()
        """The present boundary's sensor frame."""

    def _run_cycle(self, before_step: Callable[[], None] | None = None) -> None:
        self.mechanics.run_cycle(before_step)
        self._hands.run_cycle(self.body.cycle)
        self._torso = self.mechanics.torso()
        self._currents = self._by_slot(self.mechanics.servo.current())
        self.sensors.update(self._torso, self.mechanics.servo.drawn())

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
        while self.run_stalled():
            pass
        command = self.faults.carry(command)
        if command is not None:
            self.dcm.put_frame(command.position, command.stiffness)
            self._command = command.reply_to
        if expected and (command is None or command.reply_to < self.frame.seq):
            self._missed += 1
        targets = self.dcm.run_cycle()
        if targets is not None:
            self.mechanics.servo.latch(targets.position, targets.stiffness)
            self._hands.latch(targets.position, targets.stiffness)
        self._world_cycle()
        self.frame = self._sample()
        return self.frame

    def run_stalled(self) -> bool:
        """Run one cycle if the DCM stands still (a fault): no commands, no frame; False if it does not.

        `advance` does so by itself; who keeps to a wall clock calls this once per cycle before it.
        """
        self.faults.begin_cycle(self.time)
        if not self.faults.stalled:
            return False
        self.dcm.skip_cycle()
        self._world_cycle()
        return True

    def _world_cycle(self) -> None:
        self._run_cycle(self.stage.begin_cycle(self.time))
        self._contacts = self.mechanics.contacts(self.world)
        self._seq += 1

    @property
    def seq(self) -> int:
        """Number of the present boundary."""
        return self._seq

    @property
    def time(self) -> float:
        """Robot time at the present boundary, s."""
        return self._seq * self.body.cycle

    def _say(self, code: str, text: str) -> None:
        self._notices.append(Notice(seq=self._seq, level="info", code=code, text=text))

    def take_notices(self) -> list[Notice]:
        """What has been said about world and faults since the last call."""
        notices, self._notices = self._notices, []
        return notices

    def _by_slot(self, values: NDArray[np.float64]) -> list[float]:
        """Values of the mechanical joints in frame order; the two hips share the left one's slot."""
        slots = [0.0] * N_JOINTS
        # backwards, so that the left hip, first in the model, has the last word
        for slot, value in zip(reversed(self._slots), reversed(values.tolist()), strict=True):
            slots[slot] = value
        return slots

    def _temperatures(self) -> tuple[float, ...]:
        """Of the motors in frame order, degrees Celsius; hands stay cool, absent joints read 0."""
        heat = self.mechanics.servo.heat
        temperature = self._by_slot(heat.temperature)
        for slot in self._hands.slots:
            temperature[slot] = self._wear.servo.heating.room
        return tuple(temperature)

    def _sample(self) -> SensorFrame:
        servo, sensors = self.mechanics.servo, self.sensors
        inertial = sensors.inertial.sample
        frame = SensorFrame(
            seq=self._seq,
            time=self._seq * self.body.cycle,
            position=self._hands.put(self._by_slot(sensors.encoders.read(self.mechanics.position))),
            stiffness=self._hands.put_stiffness(self._by_slot(servo.stiffness)),
            current=tuple(self._currents),
            temperature=self._temperatures(),
            fsr=sensors.forces(self._contacts),
            accelerometer=inertial.acceleration,
            gyroscope=inertial.rate,
            angle=inertial.angle,
            touch=sensors.touch.read(self._contacts.bumped),
            battery=sensors.battery.read(),
            sonar=sensors.sonars.read(),
            command=self._command,
            missed=self._missed,
        )
        return self.faults.spoil(frame)

    def truth(self) -> TruthFrame:
        """Ground truth at the present boundary."""
        height = self.world.clearance(self._torso.position) / self._start_height
        joints = self._hands.put(self._by_slot(self.mechanics.position))
        com = self.mechanics.com()
        return truth_frame(self._seq, self.time, self._torso, self._contacts, joints, com, height)

    def stand_up(self) -> None:
        """Put the robot where it lies back on its feet, held in its start posture with full stiffness."""
        position, turn = self._torso.position, self._torso.rotation
        heading = math.atan2(turn[3], turn[0])
        x, y, _ = self.world.to_floor(position)[0]
        model = self.mechanics.model
        place(model, self.body, self.posture, self._orientation, self._lift, self.world, (x, y, heading))
        self.mechanics.take_pose()
        self.dcm.put_frame(self.posture, (1.0,) * N_JOINTS)
        self._torso = self.mechanics.torso()
        self.sensors.inertial.start(self._torso)

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
