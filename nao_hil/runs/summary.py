"""What a run comes to: gathered frame by frame, the same in process and over the link."""

from __future__ import annotations

import math

import msgspec

from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame, WalkTelemetry
from bridge.recording.canonical import FrameHash
from bridge.rotations import tilt


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """Result of one run; the JSON of `nao-hil up`."""

    fell: bool
    """The ground truth says that the robot fell."""
    steps: int
    """Steps completed in all walks, by the walker's word."""
    distance: float
    """Way of the torso over ground from the first frame to the last, or to the fall, m."""
    speed: float
    """Distance over the time from the first phase of each walk to its end, m/s."""
    torso_max: float
    """Largest angle between the torso's z axis and the vertical from the first phase of the walk on, rad."""
    real_time_factor: float
    """Robot time over wall-clock time."""
    cycles: int
    cycles_missed: int
    """Cycles in which the controller did not answer in time."""
    frames_sha256: str
    """Over all sensor and actuator frames in order, wall-clock fields left out."""
    seed: int
    resets: int = 0
    """How often the world was reset; all but the real-time factor is of what came after the last time."""


class RunStatistics:
    """Observes a run and sums it up. When the robot begins anew, so does the sum.

    Args:
        seed: of the run, repeated in the summary.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._resets = 0
        self._time_before = 0.0
        self._last_frame: SensorFrame | None = None
        self._begin()

    def _begin(self) -> None:
        self._hash = FrameHash()
        self._first: TruthFrame | None = None
        self._last: TruthFrame | None = None
        self._way_end: TruthFrame | None = None
        """The last, or where it fell: what it slides after that is no walk."""
        self._fell = False
        self._torso_max = 0.0
        self._steps_before = self._step = 0
        self._walked = 0.0
        self._walk: tuple[float, float] | None = None
        self._has_walked = False

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """Take in one boundary of the DCM cycle."""
        if self._last_frame is not None and frame.seq < self._last_frame.seq:
            self._resets += 1
            self._time_before += self._time
            self._begin()
        self._hash.add(frame)
        self._first = self._first or truth
        self._last, self._last_frame = truth, frame
        if not self._fell:
            self._way_end = truth
        self._fell = self._fell or truth.fell
        if self._has_walked:
            self._torso_max = max(self._torso_max, float(tilt(truth.torso_orientation)))

    @property
    def _time(self) -> float:
        """Robot time since it began, s."""
        return self._last.time - self._first.time if self._first and self._last else 0.0

    def command(self, frame: ActuatorFrame) -> None:
        """Take in the actuator frame that was put in force."""
        self._hash.add(frame)

    def telemetry(self, message: WalkTelemetry) -> None:
        """Take in what the walker says of its walk."""
        if self._last_frame is None or message.seq > self._last_frame.seq:
            return  # said of the robot before it began anew
        if message.step < self._step:  # another walk
            self._steps_before += self._step
        self._step = message.step
        now = self._last_frame.time
        if message.state in ("walk", "stopping"):
            self._has_walked = True
            self._walk = (self._walk[0] if self._walk else now, now)
        elif self._walk is not None:
            self._walked += self._walk[1] - self._walk[0]
            self._walk = None

    def notice(self, message: Notice) -> None:
        """What happens in the world is not counted; what comes of it is."""

    def summary(self, wall_seconds: float) -> Summary:
        """The summary so far; `wall_seconds` is the wall-clock length of the run."""
        first, last, end = self._first, self._last, self._way_end
        distance = math.dist(first.torso_position[:2], end.torso_position[:2]) if first and end else 0.0
        walked = self._walked + (self._walk[1] - self._walk[0] if self._walk else 0.0)
        return Summary(
            fell=self._fell,
            steps=self._steps_before + self._step,
            distance=distance,
            speed=distance / walked if walked > 0.0 else 0.0,
            torso_max=self._torso_max,
            real_time_factor=(self._time_before + self._time) / wall_seconds if wall_seconds > 0.0 else 0.0,
            cycles=last.seq if last else 0,
            cycles_missed=self._last_frame.missed if self._last_frame else 0,
            frames_sha256=self._hash.hexdigest(),
            seed=self._seed,
            resets=self._resets,
        )
