"""The emulated robot in process: commands in, sensor frames out, one DCM cycle at a time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from bridge.body import Body, joint_tree
from bridge.body.joints import INDEX_WITH_MIRROR, N_JOINTS
from bridge.body.quantities import standing_height
from bridge.dcm import Dcm
from bridge.errors import ConfigurationError
from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame
from bridge.messages.codec import require_finite
from bridge.types import Closing, Quaternion
from emulator.engine.catalogue import AUTO, open_engine
from emulator.engine.settings import SETTINGS, PhysicsSettings
from emulator.faults import Faults
from emulator.sampling import FrameSampler, Hands, truth_frame, upright
from emulator.scenarios import FLAT, Scenario
from emulator.sensors.suite import Sensors
from emulator.servo.servo import Servo
from emulator.start import StartPose, build_world, place, place_lying, start_pose, start_posture, timeline
from emulator.wear import WearProfile
from emulator.world.events import EventExecutor

IDEAL: Final = WearProfile(name="ideal")


class EmulatedRobot(Closing):
    """A NAO in a physics engine, behind its emulated DCM.

    It starts in its posture with full stiffness and holds it until the first command.

    Args:
        body: Data sheet.
        seed: Of the one random generator that everything random here draws from.
        posture: Start posture by name, or 25 angles in frame order, rad; None: the scenario's.
        settings: Of the physics.
        engine: Name of the physics engine; `auto`: PyBullet where it is installed, else MuJoCo.
        scenario: Ground, and the events.
        wear: State of the drives and sensors.
        settle: Time in which the robot may settle into its posture before `seq` 0, s.
        orientation: Of the torso at the start; None: soles level.
        lift: Height of the soles over the floor at the start, m.
        held: The torso is nailed to the world (test benches).
        start: Pose to begin in, a name of `emulator.scenarios.START_NAMES`; None: the scenario's.

    Raises:
        ConfigurationError: unknown posture, a cycle that is no whole number of physics steps, no such engine,
            or a box of the scenario inside the robot.
    """

    def __init__(
        self,
        body: Body,
        *,
        seed: int,
        posture: str | Sequence[float] | None = None,
        settings: PhysicsSettings = SETTINGS,
        engine: str = AUTO,
        scenario: Scenario = FLAT,
        wear: WearProfile = IDEAL,
        settle: float = 0.5,
        orientation: Quaternion | None = None,
        lift: float = 0.0,
        held: bool = False,
        start: str | None = None,
    ) -> None:
        self._start = start_pose(scenario.start.pose if start is None else start)
        self.body = body
        self._seed = seed
        self.posture = start_posture(scenario.start.posture if posture is None else posture)
        """Posture at the start and after `stand_up`: 25 angles in frame order, rad."""
        self._scenario = scenario
        self._wear = wear
        self._settle = round(settle / body.cycle)
        self._orientation, self._lift, self._held = orientation, lift, held
        self._steps = settings.steps(body)
        self._settings, self._engine = settings, engine
        self._build()

    def _build(self) -> None:
        """State that a reset replaces."""
        body, wear = self.body, self._wear
        self.engine = engine = open_engine(self._engine, self._settings)
        """The physics; a new one after a reset."""
        self.random = np.random.default_rng(self._seed)
        """Source of all that is random in this robot; the ideal sensors and servos draw nothing from it."""
        # children draw from streams of their own: a scenario does not change the noise of the sensors
        terrain, chance = self.random.spawn(2)
        self.world = build_world(engine, self._scenario, terrain)
        joints = tuple(joint_tree(body))
        request = np.array([self.posture[INDEX_WITH_MIRROR[name]] for name in joints])
        self.servo = Servo(body, joints, wear.servo, request, engine.settings.step)
        """The drives of all joints."""
        self.multibody = engine.add_robot(body, self.servo.drives, held=self._held)
        """The robot in the physics."""
        start = self._scenario.start
        at = (start.x, start.y, math.radians(start.yaw))
        if self._start is None:
            self._place(at)
        else:
            place_lying(self.world, self.multibody, self._start, at)
        self._require_room()
        self._torso = self.multibody.state()
        placed_upright = upright(self._torso)
        self._hands = Hands(body, self.posture)
        self.dcm = Dcm(body, self.posture)
        """Timed commands and aliases; actuator frames pass through it too."""
        charger = self._scenario.charger
        self.sensors = Sensors(body, wear.sensors, self.random, engine, self.multibody, charger=charger)
        """All sensors; `sensors.touch` presses buttons."""
        self._sampler = FrameSampler(joints, self.servo, self.sensors, self._hands, wear.servo.heating.room)
        self.absent = self._sampler.absent
        """Joints of the frame that this body does not have."""
        self._let_settle()
        self.fell_over = placed_upright and not upright(self._torso)
        """Whether it was placed upright and fell before its first cycle."""
        self._seq = 0
        self._notices: list[Notice] = []
        self.world_events = EventExecutor(self.world, self.multibody, timeline(self._scenario), self._notify)
        """Carries out the events in the world."""
        rezero, planned = self.sensors.inertial.rezero, self._scenario.faults
        self.faults = Faults(self.multibody, self.servo, rezero, planned, chance, self._notify)
        """Faults in force and planned."""
        self._command = -1
        self._missed = 0
        self._ahead = False
        """The physics of the present cycle has run already."""
        self.frame = self._sample()
        """The present boundary's sensor frame."""

    def _place(self, at: tuple[float, float, float]) -> None:
        """Put the robot into its start posture at x, y (m) and yaw (rad) of the floor."""
        place(self.world, self.multibody, self.posture, self._orientation, self._lift, at)

    def _require_room(self) -> None:
        """Raises ConfigurationError where a box overlaps the robot."""
        for name in self.world.boxes:
            if self.world.in_robot(name):
                raise ConfigurationError(
                    f"Box `{name}` of the scenario stands inside {self.body.name} at its start; give the box "
                    "or the start another place."
                )

    def _let_settle(self) -> None:
        """Run until the robot has settled into its start pose; one that does not stand upright is limp then."""
        pose = self._start
        if pose is not None:
            self._release(pose)
        for _ in range(self._settle if pose is None else round(pose.settle / self.body.cycle)):
            self._step_physics(None)
            self._measure()

    def _release(self, pose: StartPose) -> None:
        """Hold a pose with the stiffness in which it rests."""
        stiffness = (pose.rest,) * N_JOINTS
        self.servo.start(self.multibody.position)
        self.servo.latch(pose.angles, stiffness)
        self.dcm.put_frame(pose.angles, stiffness)

    def _step_physics(self, before_step: Callable[[], None] | None) -> None:
        """Drives and physics over one cycle; the world may act before every physics step."""
        self.servo.advance(self._steps)
        self.engine.run(self._steps, before_step)

    def _measure(self) -> None:
        """Update drives and sensors by the cycle that ends now."""
        self.servo.end_cycle()
        self._torso = self.multibody.state()
        self.sensors.update(self._torso, self.servo.drawn())

    def advance(self, command: ActuatorFrame | None, *, expected: bool = False) -> SensorFrame:
        """Latch the command, run one cycle, sample.

        Args:
            command: The newest command, or None: the last one stays in force.
            expected: A controller serves this cycle; without an answer to its frame it counts as missed.

        Returns:
            The frame of the new boundary.

        Raises:
            FrameError: a position or stiffness that is not a finite number.
        """
        self.begin_cycle(command, expected=expected)
        self.run_physics()
        return self.end_cycle()

    def begin_cycle(self, command: ActuatorFrame | None, *, expected: bool = False) -> None:
        """The first part of `advance`: latch the command."""
        if command is not None:
            require_finite("position", command.position)
            require_finite("stiffness", command.stiffness)
        while self.run_stalled():
            pass
        command = self.faults.apply_command_faults(command)
        if command is not None:
            self.dcm.put_frame(command.position, command.stiffness)
            self._command = command.reply_to
        if expected and (command is None or command.reply_to < self.frame.seq):
            self._missed += 1
        targets = self.dcm.run_cycle()
        if targets is not None:
            elapsed = self._steps if self._ahead else 0
            self.servo.latch(targets.position, targets.stiffness, elapsed)
            self._hands.latch(targets.position, targets.stiffness)

    def run_physics(self) -> None:
        """The second part of `advance`: several robots may run theirs in threads at the same time."""
        if not self._ahead:
            self._step_physics(self.world_events.begin_cycle(self.time))

    def end_cycle(self) -> SensorFrame:
        """The last part of `advance`: measure, and return the frame of the new boundary."""
        if not self._ahead:
            self._measure()
        self._next_cycle()
        self.frame = self._sample()
        return self.frame

    def run_ahead(self) -> None:
        """Run the physics of the cycle that begins now, before its command is there.

        Only if the drives delay requests by a cycle or more, so that its command cannot act within it;
        otherwise nothing happens. The frames are the same as without.
        """
        if self._ahead or self.servo.delay_steps < self._steps:
            return
        self.faults.begin_cycle(self.time)
        if not self.faults.stalled:
            self.run_physics()
            self._measure()
            self._ahead = True

    def run_stalled(self) -> bool:
        """Run one cycle if the DCM has stopped (a fault): no commands, no frame; False if it has not.

        `advance` does so by itself; who keeps to a wall clock calls this once per cycle before it.
        """
        if self._ahead:
            return False
        self.faults.begin_cycle(self.time)
        if not self.faults.stalled:
            return False
        self.dcm.skip_cycle()
        self.run_physics()
        self._measure()
        self._next_cycle()
        return True

    def _next_cycle(self) -> None:
        """Run to the next boundary."""
        self._hands.run_cycle(self.body.cycle)
        self._ahead = False
        self._seq += 1

    @property
    def seq(self) -> int:
        """Number of the present boundary."""
        return self._seq

    @property
    def time(self) -> float:
        """Robot time at the present boundary, s."""
        return self._seq * self.body.cycle

    @property
    def tilt(self) -> float:
        """Angle of the torso's z axis to the vertical, rad."""
        return math.acos(max(-1.0, min(1.0, self._torso.rotation[8])))

    def _notify(self, code: str, text: str) -> None:
        self._notices.append(Notice(seq=self._seq, level="info", code=code, text=text))

    def take_notices(self) -> list[Notice]:
        """Sentences about world and faults since the last call."""
        notices, self._notices = self._notices, []
        return notices

    def _sample(self) -> SensorFrame:
        frame = self._sampler.sample(
            self.multibody.position,
            self.multibody.contacts,
            seq=self._seq,
            time=self.time,
            command=self._command,
            missed=self._missed,
        )
        return self.faults.corrupt_frame(frame)

    def truth(self) -> TruthFrame:
        """Ground truth at the present boundary."""
        height = self.world.clearance(self._torso.position) / standing_height(self.body)
        joints, com = self._sampler.angles(self.multibody.position), self.multibody.com()
        contacts = self.multibody.contacts
        return truth_frame(self._seq, self.time, self._torso, contacts, joints, com, height, self.dcm.leds)

    def stand_up(self) -> tuple[str, ...]:
        """Put a lying robot on its feet where it is, held in its start posture with full stiffness.

        Returns:
            Names of the movable boxes in its place; they are removed.
        """
        x, y, _ = self.world.to_floor(self._torso.position)
        self._place((x, y, self._torso.heading))
        self.servo.start(self.multibody.position)
        self.dcm.put_frame(self.posture, (1.0,) * N_JOINTS)
        self._torso = self.multibody.state()
        self.sensors.inertial.start(self._torso)
        return self.world.clear_robot()

    def lay_down(self, pose: str | StartPose) -> tuple[str, ...]:
        """Put the robot where it is into a start pose, limp; it settles from now on.

        Args:
            pose: A name of `emulator.scenarios.START_NAMES`, or a pose.

        Returns:
            As `stand_up`.

        Raises:
            ConfigurationError: no such pose.
        """
        found = start_pose(pose) if isinstance(pose, str) else pose
        if found is None:
            return self.stand_up()
        x, y, _ = self.world.to_floor(self._torso.position)
        place_lying(self.world, self.multibody, found, (x, y, self._torso.heading))
        self._release(found)
        self._torso = self.multibody.state()
        self.sensors.inertial.start(self._torso)
        return self.world.clear_robot()

    def reset(self) -> None:
        """Restart: same posture, same seed, `seq` 0."""
        self.engine.close()
        self._build()

    def close(self) -> None:
        """Free the physics engine; may be called twice."""
        self.engine.close()
