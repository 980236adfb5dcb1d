"""Summary of a run, gathered frame by frame: the same in process and over the link."""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import msgspec

from bridge.body.fall import has_fallen
from bridge.histogram import Percentiles
from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame, WalkTelemetry
from bridge.planar import Pose2D
from bridge.recording.canonical import FrameHash
from bridge.recording.observer import Observer
from bridge.rotations import tilt
from bridge.rotations import yaw as yaw_of
from bridge.types import Vec3
from nao_hil.runs.walk_figures import FallWatch, HeadingMotion, StepCounter

CORNER_PERIOD: Final = 0.5
"""Robot time from one corner of the path to the next, s: two steps of `omni`."""


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """Result of one run, over all resets of its world; the JSON of `nao-hil up`.

    Without telemetry of the controller, the ground truth takes the place of the walker's report: a walk
    is from the first foot that leaves the ground to the last that lands.
    """

    fell: bool
    """The robot fell at least once, by the ground truth."""
    falls: int
    """Number of falls; a fall counts again after being upright. Beginning on the ground is no fall, nor are
    contacts while getting up."""
    stands: bool
    """On its feet at the end, by the ground truth."""
    recoveries: int
    """Number of times that it got up from lying by itself, by the walker's telemetry."""
    steps: int
    """Steps completed in all walks, by the walker's telemetry."""
    distance: float
    """Straight line of the torso over ground from the first frame to the last, or to the fall, m; summed over
    resets."""
    way: float = 0.0
    """Length of the torso's path over ground, m: a corner each half second, so its sway does not count."""
    speed: float
    """Way over the time from the first phase of each walk to its end, m/s."""
    velocity: Vec3 = (0.0, 0.0, 0.0)
    """Mean of the torso's in its own heading, forward and to the left, m/s, and turn, rad/s, from 2 s after the
    walk began until it closes its feet, or falls; of the last walk, zeros if it is shorter."""
    displacement: Vec3 = (0.0, 0.0, 0.0)
    """From the torso's pose as the first walk began to its last, or to the fall, in the heading of the first:
    forward and to the left, m, and turn, rad, in which full turns count; since the last reset. Without a walk
    from its first pose."""
    heading_change: float = 0.0
    """Turn of the torso from the first frame to the last, or to the fall, rad; a full turn counts."""
    torso_max: float
    """Largest angle between the torso's z axis and the vertical, rad; of a lying robot, too."""
    real_time_factor: float
    """Robot time over wall-clock time."""
    cycles: int
    cycles_missed: int
    """Cycles without an answer of the controller in time."""
    frames_sha256: str
    """Over all sensor and actuator frames in order, wall-clock fields left out."""
    seed: int
    engine: str
    """Name of the physics engine."""
    resets: int = 0
    """Number of resets of the world."""
    failure: str = ""
    """Why the last walk ended before its order was carried out, by the walker's telemetry; empty: it was."""
    inference: Percentiles | None = None
    """Wall time of the calls of a learned gait's network, s; None: the gait has none."""


MISSED_SHARE: Final = 0.02
"""Share of the cycles; a run in real time that misses more has another robot's figures."""


def starved(cycles: int, missed: int, skipped: int) -> str:
    """One sentence on a run in real time that could not keep its cycle; empty when it could.

    Args:
        cycles: run.
        missed: of these, without an answer in time.
        skipped: left out, because the robot's own process was late.
    """
    share = (missed + skipped) / max(cycles + skipped, 1)
    if share <= MISSED_SHARE:
        return ""
    late = "answers or the robot itself were late in" if skipped else "answers were late in"
    return (
        f"The run did not keep real time: {late} {share:.0%} of the cycles, so its figures are not those of an "
        "undisturbed robot; end other work here, or take --mode lockstep (`nao-hil doctor` says what the "
        "machine can do)."
    )


class _Sums(NamedTuple):
    """Sums over all resets."""

    time: float = 0.0
    distance: float = 0.0
    way: float = 0.0
    walked: float = 0.0
    steps: int = 0
    cycles: int = 0
    missed: int = 0


class RunStatistics(Observer):
    """Observes a run and sums it up.

    Args:
        seed: of the run, repeated in the summary.
        engine: of the run, likewise.
    """

    def __init__(self, seed: int, engine: str) -> None:
        self._seed, self._engine = seed, engine
        self._resets = self._falls = self._recoveries = 0
        self._failure = ""
        self._watch = FallWatch()
        self._was_lying = False
        """The robot lay and has not got up."""
        self._tilt = 0.0
        self._before = _Sums()
        self._torso_max = 0.0
        self._hash = FrameHash()
        self._has_telemetry = False
        """The controller publishes telemetry."""
        self._last_frame: SensorFrame | None = None
        self._begin()

    def _begin(self) -> None:
        self._watch.restart()
        self._first: TruthFrame | None = None
        self._last: TruthFrame | None = None
        self._way_begin: TruthFrame | None = None
        """Frame at the first walk's beginning: before it, the torso moves over the feet."""
        self._way_end: TruthFrame | None = None
        """The last frame, or that of the fall: sliding after it is no walk."""
        self._turned_before = 0.0
        """Turn of the torso before the first walk, rad: meaningless while lying."""
        self._way = 0.0
        """Length up to the last corner of the path, m."""
        self._corner: TruthFrame | None = None
        self._fell = False
        self._steps_before = self._step = 0
        self._walked = 0.0
        self._walk: tuple[float, float] | None = None
        self._motion = HeadingMotion()
        self._step_counter = StepCounter()

    def take(self, message: Any) -> None:
        """Take in the next message of a run, whatever its kind."""
        if isinstance(message, SensorFrame):
            self._frame(message)
        elif isinstance(message, TruthFrame):
            self._truth(message)
        elif isinstance(message, ActuatorFrame):
            self.command(message)
        else:
            self.message(message)

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """Take in one boundary of the DCM cycle."""
        self._frame(frame)
        self._truth(truth)

    def _frame(self, frame: SensorFrame) -> None:
        if self._last_frame is not None and frame.seq < self._last_frame.seq:
            self._resets += 1
            self._before = self._sums()
            self._begin()
        self._hash.add(frame)
        self._last_frame = frame

    def _truth(self, truth: TruthFrame) -> None:
        self._first = self._first or truth
        falls = self._watch.update(down=truth.fell)
        self._falls += falls
        self._last = truth
        if not self._fell:
            self._way_end = truth
            self._motion.add(truth)
            self._corner = self._corner or truth
            if truth.time >= self._corner.time + CORNER_PERIOD:
                self._way += _between(self._corner, truth)
                self._corner = truth
        self._fell = self._fell or falls
        if not self._has_telemetry:
            self._count_steps(truth)
        self._tilt = float(tilt(truth.torso_orientation))
        self._torso_max = max(self._torso_max, self._tilt)

    def _count_steps(self, truth: TruthFrame) -> None:
        """Update a walk without telemetry by the ground truth."""
        event = self._step_counter.update(truth)
        if event == "lifted":
            self._walk = truth.time, truth.time
            self._motion.begin(truth.time)
        elif event == "step" and self._walk is not None:
            self._step += 1
            self._walk = (self._walk[0], truth.time)
            self._motion.mark()
        elif event == "over" and self._walk is not None:
            self._walked += self._walk[1] - self._walk[0]
            self._walk = None
            self._motion.end()

    def _sums(self) -> _Sums:
        """Sums so far, over all resets."""
        first, last, end, frame = self._first, self._last, self._way_end, self._last_frame
        before = self._before
        if frame is None:
            return before
        sums = before._replace(
            walked=before.walked + self._walked + (self._walk[1] - self._walk[0] if self._walk else 0.0),
            steps=before.steps + self._steps_before + self._step,
            cycles=before.cycles + frame.seq,
            missed=before.missed + frame.missed,
        )
        if first is None or last is None or end is None:
            return sums
        return sums._replace(
            time=before.time + last.time - first.time,
            distance=before.distance + _between(first, end),
            way=before.way + self._way + (_between(self._corner, end) if self._corner else 0.0),
        )

    def _displacement(self) -> Vec3:
        first = self._way_begin or self._first
        if first is None or self._way_end is None:
            return 0.0, 0.0, 0.0
        x, y, _ = first.torso_position
        begin = Pose2D(x, y, float(yaw_of(first.torso_orientation)))
        moved = begin.local(*self._way_end.torso_position[:2])
        return *moved, self._motion.turned - self._turned_before

    def command(self, frame: ActuatorFrame) -> None:
        """Update by the actuator frame in force."""
        self._hash.add(frame)

    def is_current(self, message: WalkTelemetry) -> bool:
        """Whether telemetry is not from before the robot's restart."""
        return self._last_frame is not None and message.seq <= self._last_frame.seq

    def telemetry(self, message: WalkTelemetry) -> None:
        """Update by the walker's telemetry."""
        if not self.is_current(message):
            return
        self._has_telemetry = True
        gets_up = self._watch.state == "motion" and message.state not in ("motion", "fallen", "rest")
        self._recoveries += gets_up and self._was_lying
        lies = message.state in ("fallen", "motion") and has_fallen(self._tilt)
        self._was_lying = lies or (self._was_lying and not gets_up)
        self._watch.telemetry(message)
        self._failure = message.failure
        if message.step < self._step:  # another walk
            self._steps_before += self._step
        self._step = message.step
        assert self._last_frame is not None
        now = self._last_frame.time
        if message.state in ("walk", "stopping"):
            if self._way_begin is None:
                self._way_begin, self._turned_before = self._last, self._motion.turned
            if self._walk is None:
                self._motion.begin(now)
            if message.state == "stopping":
                self._motion.end()
            self._walk = (self._walk[0] if self._walk else now, now)
        elif self._walk is not None:
            self._walked += self._walk[1] - self._walk[0]
            self._walk = None

    def notice(self, message: Notice) -> None:
        """Update by a notice of the robot: whether its guard sits it down."""
        self._watch.notice(message)

    def summary(self, wall_seconds: float) -> Summary:
        """The summary so far; `wall_seconds` is the wall-clock length of the run."""
        sums = self._sums()
        return Summary(
            fell=self._falls > 0,
            falls=self._falls,
            stands=self._last is not None and not self._last.fell,
            recoveries=self._recoveries,
            steps=sums.steps,
            distance=sums.distance,
            way=sums.way,
            speed=sums.way / sums.walked if sums.walked > 0.0 else 0.0,
            velocity=self._motion.velocity,
            displacement=self._displacement(),
            heading_change=self._motion.turned,
            torso_max=self._torso_max,
            real_time_factor=sums.time / wall_seconds if wall_seconds > 0.0 else 0.0,
            cycles=sums.cycles,
            cycles_missed=sums.missed,
            frames_sha256=self._hash.hexdigest(),
            seed=self._seed,
            engine=self._engine,
            resets=self._resets,
            failure=self._failure,
        )


def _between(a: TruthFrame, b: TruthFrame) -> float:
    """Between two places of the torso over ground, m."""
    return math.dist(a.torso_position[:2], b.torso_position[:2])
