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
from bridge.errors import ConfigurationError, FrameError
from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame
from bridge.messages.codec import require_finite
from bridge.messages.game import GameReport, RobotGame
from bridge.types import Closing, Quaternion, Vec3
from emulator.engine.catalogue import AUTO
from emulator.engine.settings import SETTINGS, PhysicsSettings
from emulator.engine.values import NO_CONTACTS
from emulator.faults import Faults
from emulator.game import game_lights
from emulator.sampling import FrameSampler, Hands, truth_frame, upright
from emulator.scenarios import FLAT, Scenario
from emulator.sensors.suite import Sensors
from emulator.servo.servo import Servo
from emulator.start import (
    StartPose,
    build_world,
    place,
    place_lying,
    require_robots,
    start_pose,
    start_posture,
    timeline,
)
from emulator.wear import WearProfile
from emulator.world.events import EventExecutor
from emulator.world.world import World

IDEAL: Final = WearProfile(name="ideal")


class EmulatedRobot(Closing):
    """A NAO in a physics engine, behind its emulated DCM.

    It starts in its posture with full stiffness and holds it until the first command. Alone it has a world of
    its own, which `advance` runs; one of several is run by their world.

    Args:
        body: Data sheet.
        seed: Of the one random generator that everything random here draws from.
        posture: Start posture by name, or 25 angles in frame order, rad; None: the scenario's.
        settings: Of the physics.
        engine: Name of the physics engine; `auto`: PyBullet where it is installed, else MuJoCo.
        scenario: Ground, start, and the events.
        wear: State of the drives and sensors.
        settle: Time in which the robot may settle into its posture before `seq` 0, s.
        orientation: Of the torso at the start; None: soles level.
        lift: Height of the soles over the floor at the start, m.
        held: The torso is nailed to the world (test benches).
        start: Pose to begin in, a name of `emulator.scenarios.START_NAMES`; None: the scenario's.
        name: Of the robot in its world.
        at: Place of the torso on the floor at the start, x and y in m, and its heading, rad; None: the
            scenario's.
        player: Number of its team, and its own there, in the league's games; None: it plays in none.
        world: Of several robots, in place of `settings`, `engine` and the scenario's ground; who makes it
            calls its `start`.

    Raises:
        ConfigurationError: unknown posture, a cycle that is no whole number of physics steps or not the
            world's, no such engine, or a box of the scenario or another robot inside the robot.
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
        name: str = "nao",
        at: Vec3 | None = None,
        player: tuple[int, int] | None = None,
        world: World | None = None,
    ) -> None:
        self.name, self.body, self.player = name, body, player
        self._start = start_pose(scenario.start.pose if start is None else start)
        self._seed = seed
        self.posture = start_posture(scenario.start.posture if posture is None else posture)
        """Posture at the start and after `stand_up`: 25 angles in frame order, rad."""
        self._scenario = scenario
        self._wear = wear
        self.settle = round((settle if self._start is None else self._start.settle) / body.cycle)
        """Cycles in which it settles into its start pose."""
        self._orientation, self._lift, self._held = orientation, lift, held
        place = scenario.start
        self._at = (place.x, place.y, math.radians(place.yaw)) if at is None else at
        self._alone = world is None
        self._build(build_world(engine, settings, scenario, seed) if world is None else world)
        if self._alone:
            self.world.start()

    def _build(self, world: World) -> None:
        """State that a reset replaces."""
        body = self.body
        self.world, self.engine = world, world.engine
        self._steps = self.engine.settings.steps(body)
        world.add(self)
        joints = tuple(joint_tree(body))
        self._request = np.array([self.posture[INDEX_WITH_MIRROR[name]] for name in joints])
        self.servo = Servo(body, joints, self._wear.servo, self._request, self.engine.settings.step)
        """The drives of all joints."""
        self.multibody = self.engine.add_robot(body, self.servo.drives, held=self._held)
        """The robot in the physics."""
        self._place_at_start()
        world.require_room(self)
        self._placed_upright = upright(self.multibody.state())
        self._settling = True
        team, number = self.player or (0, 0)
        self.game = RobotGame(team=team, player=number)
        """The league's game by its last report."""
        self._equip()

    def _place_at_start(self) -> None:
        if self._start is None:
            self._place(self._at)
        else:
            place_lying(self.world, self.multibody, self._start, self._at)

    def _equip(self) -> None:
        """Give a robot that has been placed at its start a DCM and sensors in their first state."""
        body, wear = self.body, self._wear
        self.random = np.random.default_rng(self._seed)
        """Source of all that is random in this robot; the ideal sensors and servos draw nothing from it."""
        # children draw from streams of their own: a scenario does not change the noise of the sensors
        _, self._chance = self.random.spawn(2)
        self._torso = self.multibody.state()
        self._hands = Hands(body, self.posture)
        self.dcm = Dcm(body, self.posture)
        """Timed commands and aliases; actuator frames pass through it too."""
        charger = self._scenario.charger
        self.sensors = Sensors(body, wear.sensors, self.random, self.engine, self.multibody, charger=charger)
        """All sensors; `sensors.touch` presses buttons."""
        self._sampler = FrameSampler(
            self.multibody.joints, self.servo, self.sensors, self._hands, wear.servo.heating.room
        )
        self.absent = self._sampler.absent
        """Joints of the frame that this body does not have."""
        if self._start is not None:
            self._release(self._start)

    def begin_run(self) -> None:
        """See `Inhabitant`."""
        self._settling = False
        self.fell_over = self._placed_upright and not upright(self._torso)
        """Whether it was placed upright and fell before its first cycle."""
        self._seq = self._earlier = 0
        self._notices: list[Notice] = []
        names = [robot.name for robot in self.world.robots]
        require_robots(self._scenario, names)
        mine = (self.name, "") if names[0] == self.name else (self.name,)
        faults = [fault for fault in self._scenario.faults if fault.robot in mine]
        events = timeline(self._scenario, mine)
        self.world_events = EventExecutor(self.world, self.multibody, events, self._notify)
        """Carries out the events in the world."""
        self.faults = Faults(
            self.multibody,
            self.servo,
            lambda: self.sensors.inertial.rezero(),
            faults,
            self._chance,
            self._notify,
        )
        """Faults in force and planned."""
        self._command = -1
        self._missed = 0
        self.frame = self._sample()
        """The present boundary's sensor frame."""

    def _place(self, at: tuple[float, float, float]) -> None:
        """Put the robot into its start posture at x, y (m) and yaw (rad) of the floor."""
        place(self.world, self.multibody, self.posture, self._orientation, self._lift, at)

    def _release(self, pose: StartPose) -> None:
        """Hold a pose with the stiffness in which it rests."""
        stiffness = (pose.rest,) * N_JOINTS
        self.servo.start(self.multibody.position)
        self.servo.latch(pose.angles, stiffness)
        self.dcm.put_frame(pose.angles, stiffness)

    def begin_physics(self) -> Callable[[], None] | None:
        """See `Inhabitant`."""
        self.servo.advance(self._steps)
        return None if self._settling else self.world_events.begin_cycle(self.world_time)

    def measure(self) -> None:
        """Update drives and sensors by the cycle that ends now."""
        self.servo.end_cycle()
        self._torso = self.multibody.state()
        self.sensors.update(self._torso, self.servo.drawn())

    def advance(self, command: ActuatorFrame | None, *, expected: bool = False) -> SensorFrame:
        """Run one cycle of a robot that is alone: latch the command, run the physics, sample.

        Args:
            command: The newest command, or None: the last one stays in force.
            expected: A controller serves this cycle; without an answer to its frame it counts as missed.

        Returns:
            The frame of the new boundary.

        Raises:
            FrameError: a position or stiffness that is not a finite number.
        """
        self.skip_stalled()
        self.begin_cycle(command, expected=expected)
        self.world.end_cycle()
        return self.frame

    def begin_cycle(self, command: ActuatorFrame | None, *, expected: bool = False) -> None:
        """The first part of a cycle: latch the command, which a DCM that has stopped (a fault) ignores."""
        if command is not None:
            require_finite("position", command.position)
            require_finite("stiffness", command.stiffness)
        if self.stalls():
            self.dcm.skip_cycle()
            return
        command = self.faults.apply_command_faults(command)
        if command is not None:
            self.dcm.put_frame(command.position, command.stiffness)
            self._command = command.reply_to
        if expected and (command is None or command.reply_to < self.frame.seq):
            self._missed += 1
        targets = self.dcm.run_cycle()
        if targets is not None:
            elapsed = self._steps if self.world.ahead else 0
            self.servo.latch(targets.position, targets.stiffness, elapsed)
            self._hands.latch(targets.position, targets.stiffness)

    def run_physics(self) -> None:
        """The second part of a robot's cycle that is alone: several may run theirs in threads together."""
        self.world.run_physics()

    def end_cycle(self) -> SensorFrame:
        """The last part of a cycle: measure, and return the newest frame; a stalled DCM gives no new one."""
        if not self.world.ahead:
            self.measure()
        self._hands.run_cycle(self.body.cycle)
        self._seq += 1
        if not self.faults.stalled:
            self.frame = self._sample()
        return self.frame

    def runs_ahead(self) -> bool:
        """See `Inhabitant`."""
        return self.servo.delay_steps >= self._steps and not self.stalls()

    def stalls(self) -> bool:
        """Whether the DCM stands still in the cycle that begins now (a fault): no commands, no frame."""
        if not self.world.ahead:
            self.faults.begin_cycle(self.world_time)
        return self.faults.stalled

    def skip_stalled(self) -> None:
        """Run a robot that is alone until its DCM runs."""
        while self.stalls():
            self.begin_cycle(None)
            self.world.end_cycle()

    @property
    def seq(self) -> int:
        """Number of the present boundary."""
        return self._seq

    @property
    def time(self) -> float:
        """Robot time at the present boundary, s."""
        return self._seq * self.body.cycle

    @property
    def world_time(self) -> float:
        """Time since the world began, s, which events and faults follow; it goes on over a `restart`."""
        return (self._earlier + self._seq) * self.body.cycle

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
        contacts, objects = self.multibody.contacts, self.world.object_states(recorded=True)
        leds, game = self.dcm.leds, self.game
        return truth_frame(
            self._seq, self.time, self._torso, contacts, joints, com, height, leds, objects, game
        )

    def report_game(self, report: GameReport) -> None:
        """See `Inhabitant`."""
        game = report.for_player(*self.player) if self.player is not None else None
        if game is None:  # of other teams
            return
        before, self.game = self.game, game
        self.dcm.light_unused(game_lights(game))
        if game.penalty != before.penalty:
            seconds = f", {game.penalty_seconds} s" if game.penalty_seconds else ""
            self._notify("game", f"The robot's penalty is `{game.penalty}`{seconds}.")
        if (game.state, game.set_play, game.score) != (before.state, before.set_play, before.score):
            set_play = "" if game.set_play == "none" else f", {game.set_play}"
            self._notify("game", f"The game: {game.state}{set_play}, {game.score[0]} : {game.score[1]}.")

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
        return self.world.clear_robots()

    def lay_down(self, pose: str | StartPose) -> tuple[str, ...]:
        """Put the robot where it is into a start pose, limp; it settles from now on.

        Args:
            pose: A name of `emulator.scenarios.START_NAMES`, or a pose.

        Returns:
            As `stand_up`.

        Raises:
            ConfigurationError: no such pose.
        """
        start = start_pose(pose) if isinstance(pose, str) else pose
        if start is None:
            return self.stand_up()
        x, y, _ = self.world.to_floor(self._torso.position)
        place_lying(self.world, self.multibody, start, (x, y, self._torso.heading))
        self._release(start)
        self._torso = self.multibody.state()
        self.sensors.inertial.start(self._torso)
        return self.world.clear_robots()

    def restart(self) -> tuple[str, ...]:
        """Restart this robot alone, between two cycles: same place and pose, same seed, `seq` 0, no faults.

        The world and the other robots go on. Events and faults of the scenario that are still to come, come at
        their time of the world. The robot settles into its pose with its first cycles.

        Returns:
            As `stand_up`.

        Raises:
            FrameError: something fixed or another robot is in its place; its joints stop then.
        """
        body, joints = self.multibody.state(), self.multibody.position.copy()
        self._place_at_start()
        try:
            self.world.require_room(self, movable=False)
        except ConfigurationError as error:
            speeds = body.velocity, body.angular_velocity  # a hook (`hang`) is not put back
            self.multibody.place(body.pose, *speeds, joints=joints.tolist())
            raise FrameError(str(error)) from None
        removed = self.world.clear_robots()
        self.multibody.contacts = NO_CONTACTS
        self.faults.restart()
        self.servo.restart(self._request)
        self._equip()
        self._earlier += self._seq
        self._seq, self._missed, self._command = 0, 0, -1
        self.frame = self._sample()
        return removed

    def reset(self) -> None:
        """Restart its world with all robots in it: same postures, same seeds, `seq` 0."""
        robots = [robot for robot in self.world.robots if isinstance(robot, EmulatedRobot)]
        rebuilt(self.world, robots).start()

    def close(self) -> None:
        """Free the physics engine of a robot that is alone; may be called twice."""
        if self._alone:
            self.engine.close()


def rebuilt(world: World, robots: Sequence[EmulatedRobot]) -> World:
    """The world as it was at its beginning, before its start, in place of this one.

    Args:
        world: Of a scenario; it is closed.
        robots: Of it, that are put into the new one.
    """
    assert world.again is not None
    world.engine.close()
    new = world.again()
    new.referee = world.referee
    for robot in robots:
        robot._build(new)
    return new
