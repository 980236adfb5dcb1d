"""A task for many robots that are stepped together, as a gymnasium vector environment."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame
from bridge.types import Array
from nao_hil.batch import Batch
from nao_hil.envs.single import robot_seed
from nao_hil.envs.tasks import Task, make_task

Observation = NDArray[np.float32]


class RobotVectorEnv(VectorEnv[Observation, Observation, Array]):
    """`RobotEnv` of N robots; with equal seeds the numbers are those of N single environments, bit for bit.

    A robot whose episode has ended restarts in the next step, which ignores its action.

    Args:
        num_envs: N.
        task: Of each robot.
        robot: Name of a body (`nao-hil robots`), or path of a data sheet.
        wear: State of drives and sensors: one for all, or a sequence of N.
        scenario: World: one for all, or a sequence of N.
        engine: `mujoco`, or `pybullet`, whose robots are stepped one after the other.
        threads: That share the robots; None: as many as cores.
        of_task: Arguments of the task alone. There is no `render_mode`: a picture is one robot's,
            `batch.robots[i].picture()`.
        autoreset_mode: NEXT_STEP; other modes are refused.

    Raises:
        ConfigurationError: no robot, an argument that the task does not have, or a wrong one.
    """

    metadata: ClassVar[dict[str, Any]] = {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int,
        task: type[Task],
        robot: str = "nao-v6",
        wear: str | list[str] = "nominal",
        scenario: str | list[str] = "flat",
        engine: str = "mujoco",
        threads: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        **of_task: Any,
    ) -> None:
        if autoreset_mode not in (AutoresetMode.NEXT_STEP, AutoresetMode.NEXT_STEP.value):
            raise ConfigurationError(
                f"autoreset_mode is {autoreset_mode}; these environments have {AutoresetMode.NEXT_STEP}, in "
                "which the step after an episode's end begins the next episode."
            )
        if num_envs < 1:
            raise ConfigurationError(f"num_envs is {num_envs}; a number from 1 on is expected.")
        self.num_envs = num_envs
        self.tasks = [make_task(task, robot, of_task) for _ in range(num_envs)]
        self.single_observation_space = self.tasks[0].observation_space
        self.single_action_space = self.tasks[0].action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._options: dict[str, Any] = {"body": robot, "wear": wear, "scenario": scenario, "engine": engine}
        self._options |= {"threads": threads, "start": task.START}
        self._batch: Batch | None = None
        self._random: list[np.random.Generator] = []
        self._steps = np.zeros(num_envs, dtype=np.int64)
        self._ended = np.zeros(num_envs, dtype=np.bool_)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin all episodes.

        Args:
            seed: The first environment's; the others have the next numbers. Or one for each.
            options: Not used.
        """
        n = self.num_envs
        seeds = [None if seed is None else seed + i for i in range(n)] if not isinstance(seed, list) else seed
        if seed is not None or not self._random:
            self._random = [seeding.np_random(one)[0] for one in seeds]
        own = [robot_seed(random) for random in self._random]
        if self._batch is None:
            self._batch = Batch(own, **self._options)
        else:
            self._batch.reset(own)
        self._steps[:], self._ended[:] = 0, False
        for i in range(n):
            self.tasks[i].begin(self._random[i])
        return self._observe()

    @property
    def batch(self) -> Batch:
        """The robots; there from the first `reset` on."""
        if self._batch is None:
            raise RuntimeError("There are no robots yet; call reset() first.")
        return self._batch

    def _observe(self) -> tuple[Observation, dict[str, Any]]:
        infos: dict[str, Any] = {}
        rows = []
        for i, (task, robot) in enumerate(zip(self.tasks, self.batch.robots, strict=True)):
            rows.append(task.observe(robot.frame))
            infos = self._add_info(infos, task.info(robot.truth), i)
        return np.stack(rows), infos

    def step(
        self, actions: Observation
    ) -> tuple[Observation, Array, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Run one cycle of all robots; those whose episode has ended restart."""
        n, batch = self.num_envs, self.batch
        wide = self.tasks[0].checked(actions, n)
        commands = [task.command(row) for task, row in zip(self.tasks, wide, strict=True)]
        ended = np.flatnonzero(self._ended).tolist()
        going = np.flatnonzero(~self._ended).tolist()
        for i in ended:
            batch.reset([robot_seed(self._random[i])], which=[i])
            self.tasks[i].begin(self._random[i])
        angles, stiffnesses = (np.array(part) for part in zip(*commands, strict=True))
        batch.step(angles, stiffnesses, which=going)
        rewards, terminated, truncated = np.zeros(n), np.zeros(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
        for i in going:
            frame: SensorFrame = batch.robots[i].frame
            rewards[i], terminated[i] = self.tasks[i].judge(frame, batch.robots[i].truth)
        self._steps[:] = np.where(self._ended, 0, self._steps + 1)
        truncated[:] = self._steps >= self.tasks[0].steps
        self._ended[:] = terminated | truncated
        observations, infos = self._observe()
        return observations, rewards, terminated, truncated, infos

    def close_extras(self, **options: Any) -> None:
        """Free the physics engines."""
        if self._batch is not None:
            self._batch.close()
            self._batch = None
