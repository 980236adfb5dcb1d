"""Gymnasium environments of the emulated robot; importing this package registers them.

Observations are the measurements of the real robot. Ground truth is in `info`, and the rewards are made of it.
"""

from __future__ import annotations

from typing import Final

from bridge.errors import ConfigurationError
from nao_hil.envs.tasks import GetUpTask, ServosTask, Task, VelocityTask

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

for _name, _task in TASKS.items():
    gymnasium.register(
        id=_name,
        entry_point="nao_hil.envs.single:RobotEnv",
        vector_entry_point="nao_hil.envs.vector:RobotVectorEnv",
        kwargs={"task": _task},
    )
