"""What a run comes to: gathered frame by frame, the same in process and over the link."""

from __future__ import annotations

import math

import msgspec

from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame, WalkTelemetry
from bridge.recording import FrameHash


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """Result of one run; the JSON of `nao-hil up`."""

    fell: bool
    """The ground truth says that the robot fell."""
    steps: int
    """Steps completed, by the walker's word."""
    distance: float
    """Way of the torso over ground from the first frame to the last, m."""
    speed: float
    """Distance over the time from the first phase of the walk to its end, m/s."""
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


class RunStatistics:
    """Observes a run and sums it up.

    Args:
        seed: of the run, repeated in the summary.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._hash = FrameHash()
        self._first: TruthFrame | None = None
        self._last: TruthFrame | None = None
        self._last_frame: SensorFrame | None = None
        self._fell = False
        self._torso_max = 0.0
        self._steps = 0
        self._walk_began: float | None = None
        self._walk_ended: float | None = None

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """Take in one boundary of the DCM cycle."""
        self._hash.sensor(frame)
        self._first = self._first or truth
        self._last, self._last_frame = truth, frame
        self._fell = self._fell or truth.fell
        if self._walk_began is not None:
            self._torso_max = max(self._torso_max, tilt(truth))

    def command(self, frame: ActuatorFrame) -> None:
        """Take in the actuator frame that was put in force."""
        self._hash.actuator(frame)

    def telemetry(self, message: WalkTelemetry) -> None:
        """Take in what the walker says of its walk."""
        self._steps = max(self._steps, message.step)
        if message.state in ("walk", "stopping") and self._last_frame is not None:
            if self._walk_began is None:
                self._walk_began = self._last_frame.time
            self._walk_ended = self._last_frame.time

    def notice(self, message: Notice) -> None:
        """What happens in the world is not counted; what comes of it is."""

    def summary(self, wall_seconds: float) -> Summary:
        """The summary so far; `wall_seconds` is the wall-clock length of the run."""
        first, last = self._first, self._last
        distance = time = 0.0
        if first is not None and last is not None:
            distance = math.dist(first.torso_position[:2], last.torso_position[:2])
            time = last.time - first.time
        walked = 0.0
        if self._walk_began is not None and self._walk_ended is not None:
            walked = self._walk_ended - self._walk_began
        return Summary(
            fell=self._fell,
            steps=self._steps,
            distance=distance,
            speed=distance / walked if walked > 0.0 else 0.0,
            torso_max=self._torso_max,
            real_time_factor=time / wall_seconds if wall_seconds > 0.0 else 0.0,
            cycles=last.seq if last else 0,
            cycles_missed=self._last_frame.missed if self._last_frame else 0,
            frames_sha256=self._hash.hexdigest(),
            seed=self._seed,
        )


def tilt(truth: TruthFrame) -> float:
    """Angle between the torso's z axis and the vertical, rad, 0..pi."""
    x, y, _, _ = truth.torso_orientation
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))
