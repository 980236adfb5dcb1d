"""The tasks: the bare servos, following a velocity, getting up."""

from __future__ import annotations

import inspect
import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar, Final, NamedTuple

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from bridge.body import Body, load_body
from bridge.body.joints import JOINTS, LEGS, N_JOINTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import standing_height
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame, TruthFrame
from bridge.planar import Pose2D
from bridge.rotations import yaw
from bridge.types import Array, Vec3
from nao_hil.arguments import require_names

_TRUTH: Final = (
    "time",
    "torso_position",
    "torso_orientation",
    "torso_velocity",
    "torso_angular_velocity",
    "joints",
    "com",
)
"""Fields of the ground truth that `info` has as arrays."""


class Judgement(NamedTuple):
    """Reward and end of one step."""

    reward: float
    terminated: bool


class Task(ABC):
    """One episode of one robot.

    Args:
        body: Data sheet of the robot.
    """

    MEASURED: ClassVar[tuple[str, ...]] = (
        "position",
        "current",
        "fsr",
        "accelerometer",
        "gyroscope",
        "angle",
    )
    """Fields of the sensor frame that make the observation, in this order."""
    START: ClassVar[str | None] = None
    """Pose in which the robot begins; None: it stands."""
    SECONDS: ClassVar[float] = 20.0
    """An episode is truncated after so many."""
    action_space: Box

    def __init__(self, body: Body) -> None:
        self.body = body
        self._low, self._high = measured_bounds(body, self.MEASURED)
        self.observation_space = self._observation_space()
        self._limits = np.array([_range(body, name) for name in JOINTS])

    def _observation_space(self) -> Box:
        return Box(self._low.astype(np.float32), self._high.astype(np.float32))

    @property
    def steps(self) -> int:
        """Length of an episode."""
        return round(self.SECONDS / self.body.cycle)

    @abstractmethod
    def begin(self, random: np.random.Generator) -> None:
        """A new episode; draws the random quantities of the task."""

    @abstractmethod
    def command(self, action: Array) -> tuple[Array, Array]:
        """Angles (25,), rad, and stiffnesses (25,) of an action."""

    @abstractmethod
    def judge(self, frame: SensorFrame, truth: TruthFrame) -> Judgement:
        """Reward of the cycle that ended here, and whether the episode does."""

    def checked(self, action: Any, robots: int | None = None) -> Array:
        """An action as an array of the action space's shape.

        Args:
            action: Of one robot, or of several, one row for each.
            robots: How many; None: one, and no rows.

        Raises:
            ConfigurationError: no numbers, or another shape.
        """
        shape = self.action_space.shape if robots is None else (robots, *self.action_space.shape)
        try:
            array = np.asarray(action, dtype=np.float64)
        except (TypeError, ValueError):
            raise ConfigurationError(f"The action is no array of numbers; {shape} would be right.") from None
        if array.shape != shape:
            raise ConfigurationError(f"The action has the shape {array.shape}; {shape} would be right.")
        return array

    def observe(self, frame: SensorFrame) -> NDArray[np.float32]:
        """Measurements of the robot, within the sensors' ranges."""
        values = np.concatenate([getattr(frame, name) for name in self.MEASURED])
        observation: NDArray[np.float32] = np.clip(values, self._low, self._high).astype(np.float32)
        return observation

    def info(self, truth: TruthFrame) -> dict[str, Any]:
        """Ground truth, which no controller of a real robot has."""
        return {name: np.array(getattr(truth, name)) for name in _TRUTH} | {"fell": truth.fell}

    def angles(self, action: Array) -> Array:
        """Angles (25,), rad, of 25 numbers: -1 and 1 are the ends of the joints' ranges."""
        low, high = self._limits.T
        return np.asarray(low + 0.5 * (np.clip(action, -1.0, 1.0) + 1.0) * (high - low))


def make_task(task: type[Task], robot: str, arguments: dict[str, Any]) -> Task:
    """The task for a robot.

    Raises:
        ConfigurationError: an argument that the task does not have, or a wrong one.
    """
    require_names(robot=robot)
    known = list(inspect.signature(task).parameters)[1:]
    for name in arguments:
        if name not in known:
            what = f"it has {', '.join(known)}" if known else "it has none of its own"
            raise ConfigurationError(f"{task.__name__} has no argument `{name}`; {what}.")
    return task(load_body(robot), **arguments)


def _range(body: Body, joint: str) -> tuple[float, float]:
    """Range of a joint of the frame, rad; of a hand, and of a joint that the body does not have, 0 to 1."""
    sheet = body.joints.get(joint)
    return (0.0, 1.0) if sheet is None else (sheet.lower, sheet.upper)


def measured_bounds(body: Body, fields: tuple[str, ...]) -> tuple[Array, Array]:
    """Ranges of measurements, one number for each value of the fields, in the frame's units."""
    unit, full = body.inertial_unit, np.ones
    bounds = {
        "position": (-np.pi * full(N_JOINTS), np.pi * full(N_JOINTS)),
        "stiffness": (-full(N_JOINTS), full(N_JOINTS)),
        "current": (0.0 * full(N_JOINTS), 10.0 * full(N_JOINTS)),
        "temperature": (0.0 * full(N_JOINTS), 120.0 * full(N_JOINTS)),
        "fsr": (0.0 * full(8), 2.0 * body.fsr.range * full(8)),
        "accelerometer": (-2.0 * unit.accelerometer_range * full(3), 2.0 * unit.accelerometer_range * full(3)),
        "gyroscope": (-unit.gyroscope_range * full(3), unit.gyroscope_range * full(3)),
        "angle": (-np.pi * full(2), np.pi * full(2)),
        "touch": (0.0 * full(14), full(14)),
        "sonar": (0.0 * full(2), 10.0 * full(2)),
    }
    low, high = zip(*(bounds[name] for name in fields), strict=True)
    return np.concatenate(low), np.concatenate(high)


POSTURE: Final = np.array(POSTURES["StandInit"])
"""25 angles in frame order, rad."""
ACTION_RANGE: Final = 0.6
"""Angle of an action of 1 from the posture, rad."""
MAX_VELOCITY: Final = np.array([0.25, 0.1, 0.5])
"""Largest commanded velocities: forward, to the left (m/s), turn (rad/s)."""
AVERAGING_TIME: Final = 0.5
"""Time constant of the mean velocity that is rewarded, s: a walking torso sways."""


class ServosTask(Task):
    """Angles and stiffnesses of all joints, and all that the robot measures; the reward is for standing.

    Action: 25 angles, -1 and 1 the ends of the joints' ranges, then 25 stiffnesses, 0 to 1 (below 0: off).
    """

    MEASURED: ClassVar[tuple[str, ...]] = (*Task.MEASURED, "stiffness", "temperature", "touch", "sonar")

    def __init__(self, body: Body) -> None:
        super().__init__(body)
        self.action_space = Box(-1.0, 1.0, (2 * N_JOINTS,), np.float32)

    def begin(self, random: np.random.Generator) -> None:
        """Nothing is random."""

    def command(self, action: Array) -> tuple[Array, Array]:
        """See `Task`."""
        return self.angles(action[:N_JOINTS]), np.clip(action[N_JOINTS:], -1.0, 1.0)

    def judge(self, frame: SensorFrame, truth: TruthFrame) -> Judgement:
        """1 for each step without a fall, which ends the episode."""
        return Judgement(0.0 if truth.fell else 1.0, truth.fell)


class VelocityTask(Task):
    """Follow a velocity command, which is the last three numbers of the observation.

    Action: angles of the leg joints from the posture StandInit, 1 for 0.6 rad, in the frame's order. The reward
    is 1 for a torso that moves exactly so, in its heading, on the average of half a second, and falls off with
    the error; a fall ends the episode.

    Args:
        body: Data sheet of the robot.
        velocity: The command: forward and to the left, m/s, and turn, rad/s; None: another one in each episode.

    Raises:
        ConfigurationError: a velocity beyond `MAX_VELOCITY`.
    """

    def __init__(self, body: Body, velocity: Vec3 | None = None) -> None:
        super().__init__(body)
        if velocity is not None and not _possible(velocity):
            raise ConfigurationError(
                f"velocity is {velocity!r}; three numbers are expected, at most {tuple(MAX_VELOCITY.tolist())}."
            )
        self._velocity = velocity
        self.action_space = Box(-1.0, 1.0, (len(LEGS),), np.float32)
        self.wanted: Array = np.zeros(3)
        """Forward and to the left, m/s, and turn, rad/s."""
        self._mean: Array = np.zeros(3)

    def _observation_space(self) -> Box:
        low, high = np.append(self._low, -MAX_VELOCITY), np.append(self._high, MAX_VELOCITY)
        return Box(low.astype(np.float32), high.astype(np.float32))

    def begin(self, random: np.random.Generator) -> None:
        """Draw the command, each number evenly within its range, unless it is given."""
        self.wanted = (
            random.uniform(-MAX_VELOCITY, MAX_VELOCITY) if self._velocity is None else np.array(self._velocity)
        )
        self._mean = np.zeros(3)

    def command(self, action: Array) -> tuple[Array, Array]:
        """See `Task`."""
        angles = POSTURE.copy()
        angles[list(LEGS)] += ACTION_RANGE * np.clip(action, -1.0, 1.0)
        return angles, np.ones(N_JOINTS)

    def observe(self, frame: SensorFrame) -> NDArray[np.float32]:
        """Measurements, and the command."""
        return np.append(super().observe(frame), self.wanted.astype(np.float32))

    def judge(self, frame: SensorFrame, truth: TruthFrame) -> Judgement:
        """See the class."""
        heading = float(yaw(truth.torso_orientation))
        x, y, _ = truth.torso_velocity
        moving = np.array([*Pose2D(yaw=heading).local(x, y), truth.torso_angular_velocity[2]])
        self._mean += (moving - self._mean) * self.body.cycle / AVERAGING_TIME
        error = (self._mean - self.wanted) / MAX_VELOCITY
        return Judgement(0.0 if truth.fell else math.exp(-float(error @ error)), truth.fell)


def _possible(velocity: Any) -> bool:
    """Whether these are three numbers within `MAX_VELOCITY`."""
    try:
        numbers = np.asarray(velocity, dtype=np.float64)
    except (TypeError, ValueError):
        return False
    return numbers.shape == MAX_VELOCITY.shape and bool(np.all(np.abs(numbers) <= MAX_VELOCITY))


class GetUpTask(Task):
    """Get up from the back.

    Action: 25 angles, -1 and 1 the ends of the joints' ranges; full stiffness. The reward is the height of the
    torso over that with straight legs, times the cosine of its lean; half a second upright ends the episode.
    """

    START: ClassVar[str | None] = "lie-back"
    SECONDS: ClassVar[float] = 15.0

    def __init__(self, body: Body) -> None:
        super().__init__(body)
        self.action_space = Box(-1.0, 1.0, (N_JOINTS,), np.float32)
        self._upright = 0

    def begin(self, random: np.random.Generator) -> None:
        """Nothing is random."""
        self._upright = 0

    def command(self, action: Array) -> tuple[Array, Array]:
        """See `Task`."""
        return self.angles(action), np.ones(N_JOINTS)

    def judge(self, frame: SensorFrame, truth: TruthFrame) -> Judgement:
        """See the class."""
        x, y, _, _ = truth.torso_orientation
        cosine = 1.0 - 2.0 * (x * x + y * y)
        height = truth.torso_position[2] / standing_height(self.body)
        self._upright = 0 if truth.fell else self._upright + 1
        return Judgement(height * max(cosine, 0.0), self._upright * self.body.cycle >= 0.5)
