"""The tasks: the bare servos, following a velocity, getting up."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.joints import INDEX, N_JOINTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import standing_height
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame, TruthFrame
from bridge.rotations import planar_point, yaw
from bridge.types import Array, Vec3
from nao_hil.envs.task import Judgement, Task

LEGS: Final = tuple(i for name, i in INDEX.items() if name[1:].startswith(("Hip", "Knee", "Ankle")))
"""Slots of the leg joints in the frame."""
POSTURE: Final = np.array(POSTURES["StandInit"])
"""25 angles in frame order, rad."""
REACH: Final = 0.6
"""Angle of an action of 1 from the posture, rad."""
FASTEST: Final = np.array([0.25, 0.1, 0.5])
"""Largest commanded velocities: forward, to the left (m/s), turn (rad/s)."""
AVERAGED: Final = 0.5
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
        ConfigurationError: a velocity beyond `FASTEST`.
    """

    def __init__(self, body: Body, velocity: Vec3 | None = None) -> None:
        super().__init__(body)
        if velocity is not None and not _possible(velocity):
            raise ConfigurationError(
                f"velocity is {velocity!r}; three numbers are expected, at most {tuple(FASTEST.tolist())}."
            )
        self._velocity = velocity
        self.action_space = Box(-1.0, 1.0, (len(LEGS),), np.float32)
        self.wanted: Array = np.zeros(3)
        """Forward and to the left, m/s, and turn, rad/s."""
        self._mean: Array = np.zeros(3)

    def _observation_space(self) -> Box:
        low, high = np.append(self._low, -FASTEST), np.append(self._high, FASTEST)
        return Box(low.astype(np.float32), high.astype(np.float32))

    def begin(self, random: np.random.Generator) -> None:
        """Draw the command, each number evenly within its range, unless it is given."""
        self.wanted = random.uniform(-FASTEST, FASTEST) if self._velocity is None else np.array(self._velocity)
        self._mean = np.zeros(3)

    def command(self, action: Array) -> tuple[Array, Array]:
        """See `Task`."""
        angles = POSTURE.copy()
        angles[list(LEGS)] += REACH * np.clip(action, -1.0, 1.0)
        return angles, np.ones(N_JOINTS)

    def observe(self, frame: SensorFrame) -> NDArray[np.float32]:
        """Measurements, and the command."""
        return np.append(super().observe(frame), self.wanted.astype(np.float32))

    def judge(self, frame: SensorFrame, truth: TruthFrame) -> Judgement:
        """See the class."""
        heading = float(yaw(truth.torso_orientation))
        x, y, _ = truth.torso_velocity
        moving = np.array([*planar_point((0.0, 0.0, -heading), (x, y)), truth.torso_angular_velocity[2]])
        self._mean += (moving - self._mean) * self.body.cycle / AVERAGED
        error = (self._mean - self.wanted) / FASTEST
        return Judgement(0.0 if truth.fell else math.exp(-float(error @ error)), truth.fell)


def _possible(velocity: Any) -> bool:
    """Whether these are three numbers within `FASTEST`."""
    try:
        numbers = np.asarray(velocity, dtype=np.float64)
    except (TypeError, ValueError):
        return False
    return numbers.shape == FASTEST.shape and bool(np.all(np.abs(numbers) <= FASTEST))


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
