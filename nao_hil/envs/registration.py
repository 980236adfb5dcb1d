"""The environments by name."""

from __future__ import annotations

from typing import Final

from bridge.errors import ConfigurationError
from nao_hil.envs.task import Task
from nao_hil.envs.tasks import GetUpTask, ServosTask, VelocityTask

try:
    import gymnasium
except ModuleNotFoundError:
    raise ConfigurationError("The environments need gymnasium; install nao-hil[envs].") from None

TASKS: Final[dict[str, type[Task]]] = {
    "NaoHil-Servos-v0": ServosTask,
    "NaoHil-Velocity-v0": VelocityTask,
    "NaoHil-GetUp-v0": GetUpTask,
}
"""By the name that `gymnasium.make` takes."""


def register_all() -> None:
    """Make the names known to gymnasium."""
    for name, task in TASKS.items():
        gymnasium.register(
            id=name,
            entry_point="nao_hil.envs.single:RobotEnv",
            vector_entry_point="nao_hil.envs.vector:RobotVectorEnv",
            kwargs={"task": task},
        )
