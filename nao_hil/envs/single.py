"""A task for one robot, as a gymnasium environment."""

from __future__ import annotations

from typing import Any, ClassVar

import gymnasium
import numpy as np
from numpy.typing import NDArray

from nao_hil.envs.tasks import Task, make_task
from nao_hil.robot import Robot

Observation = NDArray[np.float32]


class RobotEnv(gymnasium.Env[Observation, Observation]):
    """One cycle of the robot per step.

    Args:
        task: Of the robot.
        robot: Name of a body (`nao-hil robots`), or path of a data sheet.
        wear: State of drives and sensors: `ideal`, `nominal`, `worn`, `ensemble:K`, or path of a profile.
        scenario: World: a name (`nao-hil scenarios`), or path of a scenario.
        engine: Physics, `pybullet` or `mujoco`; `auto`: PyBullet where it is installed, else MuJoCo.
        render_mode: None or `rgb_array`.
        of_task: Arguments of the task alone.

    Raises:
        ConfigurationError: an argument that the task does not have, or a wrong one.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array"], "render_fps": 50}

    def __init__(
        self,
        task: type[Task],
        robot: str = "nao-v6",
        wear: str = "nominal",
        scenario: str = "flat",
        engine: str = "auto",
        render_mode: str | None = None,
        **of_task: Any,
    ) -> None:
        self.task = make_task(task, robot, of_task)
        self.observation_space, self.action_space = self.task.observation_space, self.task.action_space
        self.render_mode = render_mode
        self._options: dict[str, Any] = {"body": robot, "wear": wear, "scenario": scenario, "engine": engine}
        self._robot: Robot | None = None
        self._steps = 0

    @property
    def robot(self) -> Robot:
        """The robot; there from the first `reset` on."""
        if self._robot is None:
            raise gymnasium.error.ResetNeeded("There is no robot yet; call reset() first.")
        return self._robot

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode with a new robot, whose seed is drawn from the environment's generator."""
        super().reset(seed=seed)
        own = robot_seed(self.np_random)
        if self._robot is None:
            self._robot = Robot(seed=own, start=self.task.START, **self._options)
        else:
            self._robot.reset(own)
        self.task.begin(self.np_random)
        self._steps = 0
        return self.task.observe(self.robot.frame), self.task.info(self.robot.truth)

    def step(self, action: Observation) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Run one cycle."""
        frame = self.robot.step(*self.task.command(self.task.checked(action)))
        truth = self.robot.truth
        reward, terminated = self.task.judge(frame, truth)
        self._steps += 1
        truncated = self._steps >= self.task.steps
        return self.task.observe(frame), reward, terminated, truncated, self.task.info(truth)

    def render(self) -> NDArray[np.uint8] | None:
        """A picture in the mode `rgb_array`, (240, 320, 3)."""
        return self.robot.picture() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Free the physics engine."""
        if self._robot is not None:
            self._robot.close()
            self._robot = None


def robot_seed(random: np.random.Generator) -> int:
    """Seed of an episode's robot."""
    return int(random.integers(2**31))
