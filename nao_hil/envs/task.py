"""A task: from an action to a command, from measurements to an observation, the reward."""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from typing import Any, ClassVar, Final, NamedTuple

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from bridge.body import Body, load_body
from bridge.body.joints import JOINTS, N_JOINTS
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame, TruthFrame
from bridge.types import Array

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
    """Of one step."""

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
    known = list(inspect.signature(task).parameters)[1:]
    for name in arguments:
        if name not in known:
            what = f"it has {', '.join(known)}" if known else "it has none of its own"
            raise ConfigurationError(f"{task.__name__} has no argument `{name}`; {what}.")
    return task(load_body(robot), **arguments)


def _range(body: Body, joint: str) -> tuple[float, float]:
    """Of a joint of the frame, rad; of a hand, and of a joint that the body does not have, 0 to 1."""
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
