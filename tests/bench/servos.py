"""Steps per second of the environment `NaoHil-Servos-v0`, against the bare engine's and Upkie's, in one run.

A step of the environment is a cycle of the DCM, 10 ms: the drives of all joints and the physics in steps of
1 ms, contacts on both feet, all sensors with their noise, the ground truth, the observation and the reward. The
floor is as many of the engine's own steps of the same robot, nothing applied and nothing read.

Upkie's servo environment on PyBullet, where it is installed, steps 10 ms too: ten steps of 1 ms of six joints,
two of them wheels on a plane, each with a torque from gains and friction for every joint, and at the end exact
readings of joints, base, inertial unit and odometry. They all take turns.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from contextlib import ExitStack
from importlib.util import find_spec
from typing import Any, Final, TypeAlias

import numpy as np

from bridge.body import load_body
from bridge.body.joints import N_JOINTS
from bridge.errors import ConfigurationError
from emulator.engine.catalogue import ENGINES
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from tests.bench.cycles import bare_cycle

_Turn: TypeAlias = tuple[str, Callable[[], float]]
"""Name, and a function that steps once and returns the processor time, s."""
_FLOOR: Final = "floor, "


def measure(steps: int = 400, body: str = "nao-v6") -> dict[str, Any]:
    """Nominal robots at a stand, on each engine that is installed, and an Upkie that balances.

    Returns:
        By engine, medians per second of the processor: steps of the environment, and floors, each as many of
        the engine's own steps as a cycle has; and the ratio of the two. By `upkie` its steps, where installed.

    Raises:
        ConfigurationError: gymnasium is not installed.
    """
    if find_spec("gymnasium") is None:
        raise ConfigurationError("The environments need gymnasium; install nao-hil[envs].")
    spent: dict[str, list[float]] = {}
    engines = [engine for engine in ENGINES if find_spec(engine) is not None]
    with ExitStack() as stack:
        turns = [_upkie(stack)] if find_spec("upkie") is not None and "pybullet" in engines else []
        turns += [
            turn for engine in engines for turn in (_ours(stack, engine, body), _floor(stack, engine, body))
        ]
        for _ in range(steps):
            for name, step in turns:
                spent.setdefault(name, []).append(step())
    rates = {name: 1.0 / statistics.median(times) for name, times in spent.items()}
    found = {
        engine: {
            "steps_per_second": rates[engine],
            "floor_per_second": rates[_FLOOR + engine],
            "over_floor": rates[engine] / rates[_FLOOR + engine],
        }
        for engine in engines
    }
    return found | ({"upkie": {"steps_per_second": rates["upkie"]}} if "upkie" in rates else {})


def _timed(step: Callable[[], object]) -> float:
    """Time of the processor, s."""
    began = time.process_time()
    step()
    return time.process_time() - began


def _ours(stack: ExitStack, engine: str, body: str) -> _Turn:
    from nao_hil.envs.single import RobotEnv
    from nao_hil.envs.tasks import POSTURE, ServosTask

    env = RobotEnv(ServosTask, robot=body, engine=engine)
    stack.callback(env.close)
    env.reset(seed=0)
    middle, high = env.task.angles(np.zeros(N_JOINTS)), env.task.angles(np.ones(N_JOINTS))
    stand = np.append((POSTURE - middle) / (high - middle), np.ones(N_JOINTS)).astype(np.float32)
    return engine, lambda: _timed(lambda: env.step(stand))


def _floor(stack: ExitStack, engine: str, body: str) -> _Turn:
    bare = stack.enter_context(EmulatedRobot(load_body(body), seed=0, wear=load_wear("nominal"), engine=engine))

    def turn() -> float:
        """Its drives hold it, which is not timed."""
        bare.advance(None)
        return _timed(lambda: bare_cycle(bare))

    return _FLOOR + engine, turn


def _upkie(stack: ExitStack) -> _Turn:
    """Made before other PyBullet robots: it talks to the first client."""
    from upkie.envs.entry_points import make_upkie_pybullet_servos

    env = make_upkie_pybullet_servos(gui=False, frequency=100.0, regulate_frequency=False)
    stack.callback(env.close)
    _, info = env.reset(seed=0)
    seen = [info["spine_observation"]]

    def turn() -> float:
        """Its wheels keep it upright, whose feedback is not timed."""
        base, way = seen[0]["base_orientation"], seen[0]["wheel_odometry"]
        speed = 10.0 * base["pitch"] + base["angular_velocity"][1] + way["position"] + 0.1 * way["velocity"]
        action = env.get_neutral_action()
        for name, command in action.items():
            wheel = {"left_wheel": 1.0, "right_wheel": -1.0}.get(name)
            target = (
                {"position": 0.0} if wheel is None else {"velocity": wheel * speed / env.model.wheel_radius}
            )
            action[name] = command | target
        began = time.process_time()
        seen[0] = env.step(action)[4]["spine_observation"]
        return time.process_time() - began

    return "upkie", turn
