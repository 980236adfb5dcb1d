"""Imitates `omni` on a body: the network drives, and the targets are the angles of `omni` in the same cycle.

Dataset aggregation (Ross, Gordon and Bagnell 2011): in the first walks `omni` drives, in later ones the network
fitted so far, so that the data hold the states into which the network's own errors lead.

python -m tests.imitation.omni [--robot nao-v3] [--minutes 3] [--seed 0] [--out DIR]
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import tomli_w

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS, LEGS
from bridge.config import from_dict
from bridge.guard import Guard
from bridge.histogram import DurationHistogram
from bridge.messages.world import Push
from bridge.types import Array, Vec3
from emulator.queries import carry_out
from emulator.robot import EmulatedRobot
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig
from tests.imitation.layers import Layer, fit, onnx_file, outputs_of, random_layers
from walker.controller import Controller, WalkOrder
from walker.gaits import gait_parameters
from walker.gaits.catalogue import walkable_gait
from walker.gaits.learned.gait import LearnedGait
from walker.gaits.learned.parameters import LearnedParameters
from walker.parameters import controller_parameters
from walker.states.upright import Walking

LEG_NAMES: Final = tuple(JOINTS[slot] for slot in LEGS)
HIDDEN: Final = (96, 96)
DRIVEN: Final = 6
"""Walks in which `omni` drives."""
SECONDS: Final = 12.0
"""Of a walk."""
EACH_ROUND: Final = 6
"""Walks between two fits, in which the network drives."""
PUSH: Final = 0.8
"""Largest push in any level direction, N s, of a network that never falls; less by the share of its falls."""
PUSH_PERIOD: Final = 2.0
"""s"""
ROBOTS: Final = (("nominal", "mujoco"), ("worn", "mujoco"), ("nominal", "mujoco"), ("nominal", "pybullet"))
"""Wear and engine of the walks, in turn."""
RANGES: Final[dict[str, tuple[float, float]]] = {
    "forward": (-0.06, 0.16),
    "left": (-0.06, 0.06),
    "turn": (-0.4, 0.4),
}
"""m/s, m/s, rad/s"""
_OFF: Final = ("step_hold", "heading_hold", "velocity_hold")
"""Mechanisms of `omni` that remember more than the network is shown."""


def sheet(default_pose: dict[str, float], step: float, start: float, scale: list[float]) -> dict[str, Any]:
    """The sheet of the policy.

    Args:
        default_pose: Angles, rad: the stand of `omni`.
        step: Duration of a step of `omni`, s.
        start: From rest to its first step, s.
        scale: Of the outputs, rad.
    """
    period = 2.0 * step
    return {
        "model": "imitation.onnx",
        "title": "Imitates the gait omni; tests/imitation/omni.py",
        "cycle": 0.01,
        "command": {"default": [0.08, 0.0, 0.0], **{k: list(v) for k, v in RANGES.items()}}
        | {"acceleration": [0.2, 0.3, 2.0]},
        "phase": {"period": period, "start": round(-start / period % 1.0, 6), "ramp": start}
        | {"standing": "zero", "stop_time": 1.0},
        "default_pose": default_pose,
        "observation": [
            {"term": "gait_phase_sin"},
            {"term": "gait_phase_cos"},
            {"term": "velocity_command", "scale": [10.0, 10.0, 2.0]},
            {"term": "projected_gravity", "scale": [10.0, 10.0, 1.0], "offset": [0.0, 0.0, 1.0]},
            {"term": "base_angular_velocity"},
            {"term": "joint_position", "scale": 5.0},
            {"term": "foot_force", "scale": 0.04},
        ],
        "action": [{"joints": list(LEG_NAMES), "scale": scale}],
    }


@dataclass
class _Recorder:
    """In place of the network: calls one, and keeps the observations."""

    act: Callable[[Array], Array]
    seen: list[Array] = field(default_factory=list)
    times: DurationHistogram = field(default_factory=DurationHistogram)

    def __call__(self, observation: Array) -> Array:
        self.seen.append(observation)
        return self.act(observation)


class _Gait(LearnedGait):
    """A learned gait whose network is a function."""

    def __init__(self, parameters: LearnedParameters, body: Any, recorder: _Recorder) -> None:
        self._recorder = recorder
        super().__init__(parameters, body, "onnx:imitation")

    def load(self) -> Any:
        """See `LearnedGait.load`."""
        return self._recorder


class Episode(NamedTuple):
    """Data of one walk."""

    observations: Array
    targets: Array
    """Outputs that give the angles of `omni`."""
    seconds: float
    """That it walked."""
    fell: bool


def episode(
    config: RunConfig,
    parameters: LearnedParameters,
    network: Sequence[Layer] | None,
    random: np.random.Generator,
    push: float,
) -> Episode:
    """One walk with both controllers.

    Args:
        config: Robot, wear, engine and seed are read.
        parameters: The sheet.
        network: It drives; None: `omni` does.
        random: Draws command and pushes.
        push: Largest push, N s.
    """
    body = load_body(config.robot)
    velocity = _velocity(random)
    off = {"switches": dict.fromkeys(_OFF, False)}
    expert = Controller(
        body,
        walkable_gait("omni", gait_parameters("omni").with_velocity(velocity), body),
        WalkOrder(duration=SECONDS),
        body.cycle,
        controller_parameters("omni", off),
    )
    recorder = _Recorder(lambda x: outputs_of(network, x[None])[-1][0] if network else np.zeros(len(LEGS)))
    learner = Controller(
        body,
        _Gait(parameters.with_velocity(velocity), body, recorder),
        WalkOrder(duration=SECONDS),
        body.cycle,
        controller_parameters("onnx:stand"),
    )
    slots, scale = list(LEGS), np.array(parameters.action[0].scale)
    targets: list[Array] = []
    guard, pushed, walked = Guard(body), PUSH_PERIOD, 0.0
    with build_robot(config) as robot:
        while not expert.done and not robot.truth().fell:
            frame = robot.frame
            asked, answered = expert.tick(frame), learner.tick(frame)
            new = len(recorder.seen) > len(targets)
            if new:
                targets.append((np.array(asked.position)[slots] - np.array(parameters.pose)[slots]) / scale)
            walking = isinstance(learner._state, Walking)
            command = answered if network is not None and walking else asked
            robot.advance(guard.cycle(frame, guard.check(command, frame.seq)))
            walked += body.cycle * walking
            if walked > pushed:
                pushed += PUSH_PERIOD
                _push(robot, random.uniform(0.0, push), random.uniform(-math.pi, math.pi))
            if network is not None and expert.state == "fallen":
                break
        fell = robot.truth().fell or expert.state == "fallen"
    return Episode(np.array(recorder.seen[: len(targets)]), np.array(targets), walked, fell)


def _velocity(random: np.random.Generator) -> Vec3:
    x, y, turn = (random.uniform(*limits) for limits in RANGES.values())
    one = random.integers(4)  # every other walk goes straight ahead
    return (x, 0.0, 0.0) if one < 2 else (0.5 * x, 0.0, turn) if one == 2 else (0.5 * x, y, 0.0)


def _push(robot: EmulatedRobot, size: float, way: float) -> None:
    impulse = (size * math.cos(way), size * math.sin(way), 0.0)
    carry_out(robot, Push(target="Torso", impulse=impulse, duration=0.05))


def train(robot: str, minutes: float, seed: int = 0) -> Iterator[tuple[dict[str, Any], list[Layer]]]:
    """Sheet and network of each round, the last fitted for longer; prints a line of each.

    Args:
        robot: Body.
        minutes: Processor time.
        seed: First seed of the robots; and of all that is drawn.
    """
    began, random = time.process_time(), np.random.default_rng(seed)
    body, omni = load_body(robot), gait_parameters("omni")
    gait = walkable_gait("omni", omni, body)
    stand = Controller(body, gait, None, body.cycle).walk.goal
    pose: dict[str, float] = {name: round(stand[INDEX[name]], 5) for name in JOINTS if name in body.joints}
    table = sheet(pose, omni.T, omni.T_start, [0.2] * len(LEGS))  # type: ignore[attr-defined]
    # `omni` steps on for a while after the order; the network learns that with the clock running
    phase = table["phase"] | {"standing": "runs", "stop_time": 2.0 * omni.T}  # type: ignore[attr-defined]
    parameters = from_dict(table | {"phase": phase}, "imitation", LearnedParameters)
    layers = random_layers((parameters.inputs, *HIDDEN, len(LEGS)), random)
    observations, targets = [], []
    network: list[Layer] | None = None
    walks, push = 0, PUSH
    while time.process_time() - began < 60.0 * minutes:
        rounds = DRIVEN if network is None else EACH_ROUND
        episodes = []
        for _ in range(rounds):
            wear, engine = ROBOTS[walks % len(ROBOTS)]
            config = RunConfig(robot=robot, wear=wear, engine=engine, seed=seed + walks)  # type: ignore[arg-type]
            episodes.append(episode(config, parameters, network, random, push))
            walks += 1
        observations += [each.observations for each in episodes]
        targets += [each.targets for each in episodes]
        x, y = np.concatenate(observations), np.concatenate(targets)
        epochs = 30 if network is None else 8
        layers, error = fit(layers, x, y, random, epochs=epochs)
        network = layers
        walked, fell = sum(each.seconds for each in episodes), sum(each.fell for each in episodes)
        push = PUSH * (1.0 - fell / rounds)
        print(
            f"{time.process_time() - began:.0f} s: {walks} walks, {len(x)} rows; the last {rounds} walked "
            f"{walked:.0f} s, {fell} fell; error {0.2 * error:.4f} rad",
            flush=True,
        )
        yield table, layers
    yield table, fit(layers, x, y, random, epochs=30)[0]


def main() -> None:
    """Train, and write sheet and network."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="nao-v3")
    parser.add_argument("--minutes", type=float, default=3.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("imitation"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for table, layers in train(options.robot, options.minutes, options.seed):
        (options.out / "imitation.onnx").write_bytes(onnx_file(layers))
        (options.out / "imitation.toml").write_text(tomli_w.dumps(table), encoding="utf-8")


if __name__ == "__main__":
    main()
