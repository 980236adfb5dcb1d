"""One walk of a campaign: robot and controller in process, watched by the ground truth, ended by a fall."""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import dataclass
from typing import Final, Literal

import msgspec
import numpy as np

from bridge import rotations
from bridge.body import BODIES, Body, load_body
from bridge.errors import ConfigurationError
from bridge.guard import Guard
from bridge.messages import SensorFrame, TruthFrame, WalkTelemetry
from bridge.recording.observer import Observer
from bridge.types import Vec3
from emulator.engine.settings import SETTINGS
from emulator.robot import EmulatedRobot
from emulator.scenarios import Scenario
from emulator.start import build_world
from emulator.wear import WearProfile, load_wear
from emulator.world.events import WorldEvent
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig
from nao_hil.runs.events import StridePush, TorsoLoad, WalkEvents
from nao_hil.runs.in_process import run
from nao_hil.runs.neighbours import Neighbour, add_neighbours, walkers_of
from nao_hil.runs.run import Run, RunObserver, Table
from walker.controller import Controller

TIME_AFTER_FALL: Final = 0.3
"""s that a run continues after a fall, so that figures show it."""
MAX_START_TIME: Final = 30.0
"""s within which the walk must have begun."""

Ending = Literal["walked", "fell", "gave up"]
KEPT: Final = (
    "actuators.position",
    "sensors.fsr",
    *(f"world/truth.{name}" for name in ("torso_position", "torso_orientation", "joints", "com", "zmp")),
    *(f"walk/telemetry.{name}" for name in ("phase", "step", "place", "zmp", "com", "left", "right")),
    "walk/telemetry.torso_control",
)
"""Columns of a walk's track, beside the `time` of the walk."""


def track_of(run: Run, began: float) -> Table:
    """The walk of a run, one row per command; `KEPT`, as float32.

    Args:
        run: With ground truth and telemetry.
        began: Robot time at which the walk began, s.
    """
    found = run.aligned("actuators", KEPT)
    found = found.where(found["time"] >= began)
    columns = {"time": found["time"] - began} | {name: found[name] for name in KEPT}
    short = {
        name: values.astype(np.float32) if values.dtype == float else values for name, values in columns.items()
    }
    return Table(short, found.columns)


NO_TRACK: Final = track_of(Run(), 0.0)
"""Track of a walk that keeps none."""


class Walk(msgspec.Struct, frozen=True, kw_only=True):
    """A walk to carry out: a configuration with its seed, and a world."""

    name: str
    """For people: experiment, condition and seed."""
    config: RunConfig
    """`scenario`, `steps` and `duration` are not read: world and length are below."""
    duration: float
    """Time of the walk, s."""
    scenario: Scenario = Scenario()
    world_events: tuple[tuple[float, WorldEvent], ...] = ()
    """Events of the world by time of the walk, s; events of the scenario count from the first frame."""
    pushes: tuple[StridePush, ...] = ()
    velocities: tuple[tuple[float, Vec3], ...] = ()
    """New ones by time of the walk, s; m/s, m/s, rad/s. For gaits that change theirs in stride."""
    load: TorsoLoad | None = None
    neighbours: tuple[Neighbour, ...] = ()
    """Other robots in the world, whose falls do not count."""
    stand: bool = False
    """Stand in place of walking; the time of the walk is that of the stand."""
    keep_track: bool = True
    body: Body | None = None
    """In place of the configuration's body."""
    wear: WearProfile | None = None
    """Likewise."""

    def with_contents(self) -> Walk:
        """The same with the contents of the files that the configuration names: a worker may not have them.

        Raises:
            ConfigurationError: a file that cannot be read.
        """
        body = self.body or (None if self.config.robot in BODIES else load_body(self.config.robot))
        wear = self.wear
        if wear is None and self.config.wear.endswith(".toml"):
            wear = load_wear(self.config.wear, body or load_body(self.config.robot))
        return msgspec.structs.replace(self, body=body, wear=wear)


class WalkEnd(msgspec.Struct, frozen=True, kw_only=True):
    """The end of a walk."""

    ending: Ending
    """`gave up`: the walker ended the walk itself, by a fall that was none, or because a policy failed."""
    time: float
    """Time of the fall, or of the end, in the time of the walk, s."""
    roll: float
    """Torso roll and pitch at that moment, rad, positive to the right and nose down."""
    pitch: float
    steps: int
    distance: float
    """Way of the torso over ground from the walk's beginning, m."""
    tilt_max: float
    """Largest angle between the torso's z axis and the vertical before any fall, rad."""

    @property
    def survived(self) -> bool:
        """Walked to the end."""
        return self.ending == "walked"

    @property
    def speed(self) -> float:
        """Over ground, m/s."""
        return self.distance / self.time if self.time > 0.0 else 0.0


@dataclass(frozen=True)
class WalkOutcome:
    """Result of a walk."""

    walk: Walk
    end: WalkEnd
    track: Table
    """Cycle by cycle, the columns of `KEPT`; without rows where the walk keeps none."""

    @property
    def seed(self) -> int:
        """Seed of the run."""
        return self.walk.config.seed


def walk(task: Walk) -> WalkOutcome:
    """Walk it; the same task gives the same result wherever it runs.

    Raises:
        ConfigurationError: no such body or wear, parameters that cannot be walked, or a walk that ends before
            the first push of its world.
    """
    config = msgspec.structs.replace(task.config, scenario="flat", steps=0, duration=0.0)
    make = controller_maker(config, waits=task.stand)
    body = task.body or load_body(config.robot)
    loaded = task.load.on(body) if task.load else body
    world = build_world(config.engine, SETTINGS, task.scenario, config.seed)
    with closing(world.engine):
        robot = build_robot(config, task.scenario, loaded, task.wear, world=world)
        neighbours = add_neighbours(world, task.neighbours, config, task.scenario, body)
        world.start()
        controller = make(body, body.cycle)
        observer, kept = _WalkObserver(task, robot, controller), RunObserver(body)
        most = round((MAX_START_TIME + task.duration) / body.cycle)
        run(
            robot,
            Guard(body),
            controller,
            [observer, *([kept] if task.keep_track else [])],
            most,
            ended=observer.ended,
            neighbours=walkers_of(neighbours, task.neighbours),
        )
        last = robot.frame.time
    end = observer.end()
    pushed = min((push.time for push in task.scenario.pushes), default=-math.inf)
    if end.survived and last < pushed:
        raise ConfigurationError(
            f"the walk ended at {last:.1f} s of robot time, before the push at {pushed:g} s; walk longer than "
            f"{task.duration:g} s."
        )
    return WalkOutcome(task, end, track_of(kept.run, observer.began))


class _WalkObserver(Observer):
    """Observer that keeps the time of the walk, lets its events happen, and sees the fall."""

    def __init__(self, task: Walk, robot: EmulatedRobot, controller: Controller) -> None:
        self._task, self._controller = task, controller
        self._events = WalkEvents(task.world_events, task.pushes, task.velocities, robot.world_events)
        self._truth = robot.truth()
        self._start: tuple[float, float] | None = None
        self.began = math.inf
        """Robot time at which the walk began, s."""
        self._fallen: tuple[float, TruthFrame] | None = None
        self._state, self._steps, self._tilt = "", 0, 0.0

    @property
    def _time(self) -> float:
        """Time of the walk, s; negative before it."""
        return self._truth.time - self.began if math.isfinite(self.began) else -1.0

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """Check for the fall."""
        self._truth = truth
        if self._fallen is None:
            if truth.fell:
                self._fallen = max(self._time, 0.0), truth
            elif self._time >= 0.0:
                self._tilt = max(self._tilt, float(rotations.tilt(truth.torso_orientation)))
        if self._fallen is None:  # a robot that lies may be where a plate is to be laid
            self._events.happen(self._time, self._controller)

    def telemetry(self, message: WalkTelemetry) -> None:
        """Check for the beginning of the walk."""
        self._state = message.state
        if self._start is None and message.state == ("stand" if self._task.stand else "walk"):
            self.began = self._truth.time
            self._start = self._truth.torso_position[:2]
        if self._fallen is None:
            self._steps = message.step
        self._events.follow(message, self._time)

    def ended(self) -> bool:
        """Walked to the end, or fallen a little while ago."""
        if self._fallen is not None:
            return self._truth.time >= self._fallen[1].time + TIME_AFTER_FALL - 1e-9
        return self._time >= self._task.duration - 1e-9

    def end(self) -> WalkEnd:
        """The end of the walk."""
        time, truth = self._fallen or (max(self._time, 0.0), self._truth)
        ending: Ending = "fell" if self._fallen else "walked"
        if self._fallen is None and (time < self._task.duration - 1e-9 or self._controller.failure):
            ending = "gave up"
        return WalkEnd(
            ending=ending,
            time=time,
            roll=float(rotations.roll(truth.torso_orientation)),
            pitch=float(rotations.pitch(truth.torso_orientation)),
            steps=self._steps,
            distance=math.dist(self._start, truth.torso_position[:2]) if self._start else 0.0,
            tilt_max=self._tilt,
        )
