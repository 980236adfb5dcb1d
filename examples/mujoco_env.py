"""The exported robot as a training environment that needs MuJoCo and NumPy alone, with delay, play and noise.

nao-hil export folder --robot nao-v6 --out nao_v6
python examples/mujoco_env.py nao_v6/scene.xml [--seconds 2] [--delay S] [--no-play] [--noise 1.0] [--seed 0]
"""

import argparse
from pathlib import Path

import mujoco
import numpy as np

CYCLE = 0.02
"""s of one action; a sheet of the policy has the same `cycle` (docs/learned-gaits.md)."""
SCALE = 0.3  # rad from the key frame `stand` of an action of 1
SPREAD = {"gravity": 0.01, "gyroscope": 0.02, "joints": 0.002}  # deviations of a noise of 1: -, rad/s, rad


class NaoEnv:
    """Follow a velocity.

    The observation is, in a sheet's terms: projected_gravity, base_angular_velocity, velocity_command,
    joint_position, previous_action.

    Args:
        scene: `scene.xml` of the exported folder.
        delay: Of the drives, s; None: the model's.
        play: The gears have the model's backlash.
        noise: Factor on `SPREAD`.
        seed: Of the noise and of the commands.
    """

    def __init__(
        self, scene: Path, delay: float | None = None, play: bool = True, noise: float = 1.0, seed: int = 0
    ) -> None:
        spec, self.noise, self.random = mujoco.MjSpec.from_file(str(scene)), noise, np.random.default_rng(seed)
        if not play:
            for joint in spec.joints:
                if joint.name.endswith(" gear"):
                    joint.range = (-5e-7, 5e-7)
        if delay is not None:
            for actuator in spec.actuators:
                actuator.nsample = max(round(delay / spec.option.timestep), 1)
                actuator.delay = actuator.nsample * spec.option.timestep
        self.model = spec.compile()
        self.data, self.key = mujoco.MjData(self.model), self.model.key("stand")
        names = [self.model.actuator(i).name for i in range(self.model.nu)]
        self.legs = [i for i, name in enumerate(names) if name[1:].startswith(("Hip", "Knee", "Ankle"))]
        self.joints = [names[i] for i in self.legs]  # that an action turns, in its order
        self.steps = round(CYCLE / self.model.opt.timestep)

    def reset(self) -> np.ndarray:
        """Begin an episode with another command; the observation."""
        mujoco.mj_resetDataKeyframe(self.model, self.data, self.key.id)
        for i, (samples, _) in enumerate(self.model.actuator_history):  # the delays begin with the stand
            if samples:
                past = np.full((samples, 1), self.data.ctrl[i])
                mujoco.mj_initCtrlHistory(self.model, self.data, i, None, past)
        mujoco.mj_forward(self.model, self.data)
        self.command = self.random.uniform([-0.1, -0.05, -0.3], [0.2, 0.05, 0.3])
        self.action = np.zeros(len(self.legs))
        return self._observe()

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool]:
        """One cycle: observation, reward (1 at the commanded velocity), and whether it fell."""
        self.action = np.clip(action, -1.0, 1.0)
        self.data.ctrl[self.legs] = self.key.ctrl[self.legs] + SCALE * self.action
        mujoco.mj_step(self.model, self.data, self.steps)
        torso = self.data.body("Torso")
        moving = (torso.xmat.reshape(3, 3).T @ self.data.qvel[:3])[:2]
        error = (np.append(moving, self.data.qvel[5]) - self.command) / (0.2, 0.1, 0.5)
        return self._observe(), float(np.exp(-error @ error)), bool(torso.xmat[8] < 0.7)

    def _observe(self) -> np.ndarray:
        def noisy(values: np.ndarray, kind: str) -> np.ndarray:
            return values + self.random.normal(0.0, self.noise * SPREAD[kind], len(values))

        gravity = -self.data.body("Torso").xmat.reshape(3, 3)[2]
        joints = np.array([self.data.sensor(name).data[0] for name in self.joints]) - self.key.ctrl[self.legs]
        rates = noisy(self.data.sensor("gyroscope").data, "gyroscope")
        parts = noisy(gravity, "gravity"), rates, self.command, noisy(joints, "joints"), self.action
        return np.concatenate(parts)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    for name, kind, default in (("seconds", float, 2.0), ("delay", float, None), ("noise", float, 1.0)):
        parser.add_argument(f"--{name}", type=kind, default=default)
    parser.add_argument("--play", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--seed", type=int, default=0)
    options = vars(parser.parse_args())
    seconds = options.pop("seconds")
    env = NaoEnv(**options)
    observation, total, fell = env.reset(), 0.0, False
    while env.data.time < seconds and not fell:
        observation, reward, fell = env.step(np.zeros(len(env.joints)))  # a policy belongs here
        total += reward
    print(f"{len(observation)} numbers seen, {len(env.joints)} joints; {total:.2f} reward, fell: {fell}")
