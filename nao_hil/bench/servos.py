"""Steps per second of the environment `NaoHil-Servos-v0`, beside the bare engine's, in one run.

A step of the environment is a cycle of the DCM: the drives of all joints and the physics in steps of 1 ms,
contacts on both feet, all sensors with their noise, the ground truth, the observation and the reward. The floor
is as many of the engine's own steps of the same robot, nothing applied and nothing read; they take turns.
"""

from __future__ import annotations

import statistics
import time
from importlib.util import find_spec
from typing import Any

import numpy as np

from bridge.body import load_body
from bridge.body.joints import N_JOINTS
from bridge.errors import ConfigurationError
from emulator.engine.catalogue import ENGINES
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear


def measure(steps: int = 400, body: str = "nao-v6") -> dict[str, Any]:
    """Nominal robots that stand, on each engine that is installed.

    Returns:
        By engine, medians per second of the processor: steps of the environment, and floors, each as many of
        the engine's own steps as a cycle has; and the ratio of the two.

    Raises:
        ConfigurationError: gymnasium is not installed.
    """
    if find_spec("gymnasium") is None:
        raise ConfigurationError("The environments need gymnasium; install nao-hil[envs].")
    return {engine: _measure(engine, steps, body) for engine in ENGINES if find_spec(engine) is not None}


def _measure(engine: str, steps: int, body: str) -> dict[str, float]:
    from nao_hil.envs.single import RobotEnv
    from nao_hil.envs.tasks import POSTURE, ServosTask

    env = RobotEnv(ServosTask, robot=body, engine=engine)
    env.reset(seed=0)
    middle, high = env.task.angles(np.zeros(N_JOINTS)), env.task.angles(np.ones(N_JOINTS))
    stand = np.append((POSTURE - middle) / (high - middle), np.ones(N_JOINTS)).astype(np.float32)
    spent: list[float] = []
    floor: list[float] = []
    with EmulatedRobot(load_body(body), seed=0, wear=load_wear("nominal"), engine=engine) as bare:
        number = round(bare.body.cycle / bare.engine.settings.step)
        for _ in range(steps):
            began = time.process_time()
            env.step(stand)
            spent.append(time.process_time() - began)
            bare.advance(None)  # its drives hold it; not timed
            began = time.process_time()
            for _ in range(number):
                bare.engine.bare_step()
            floor.append(time.process_time() - began)
    env.close()
    step, least = statistics.median(spent), statistics.median(floor)
    return {"steps_per_second": 1.0 / step, "floor_per_second": 1.0 / least, "over_floor": least / step}
