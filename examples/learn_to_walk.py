"""Learn to walk forward: eight numbers of a marching pattern, found by an evolution strategy in ten minutes.

python examples/learn_to_walk.py [--minutes 10] [--robots 12] [--seconds 6] [--seed 0] [--out learnt]
python examples/walk_learnt.py learnt/pattern.txt    # then walks a robot on the link
"""

import argparse
import time
from pathlib import Path

import gymnasium
import numpy as np
from walk_learnt import leg_angles

import nao_hil.envs  # noqa: F401 (registers the environments)
from nao_hil.envs.tasks import ACTION_RANGE

NAMES = ("frequency", "lift", "sway", "sway_phase", "stride", "lean", "roll_gain", "pitch_gain")
START = np.array([1.7, 0.2, 0.08, 0.4, 0.02, 0.0, 0.0, 0.0])
WIDTH = np.array([0.2, 0.04, 0.03, 0.3, 0.05, 0.03, 0.03, 0.03])
"""Standard deviations of the first generation."""


def actions(theta: np.ndarray, observation: np.ndarray, when: float) -> np.ndarray:
    """Leg angles over `ACTION_RANGE`, (N, 11); theta (N, 8), observation (N, n), when in s."""
    return leg_angles(theta, observation[:, 61:64], when, min(when, 1.0)) / ACTION_RANGE


def scores(env: gymnasium.vector.VectorEnv, theta: np.ndarray, seed: int, seconds: float) -> np.ndarray:
    """Distance forward less the drift to the side of one episode each, m; a fall ends it and costs 0.3 m."""
    observation, info = env.reset(seed=[seed] * len(theta))
    place, going, when = info["torso_position"].copy(), np.ones(len(theta), bool), 0.0
    start = place.copy()
    while when < seconds and going.any():
        observation, _, terminated, _, info = env.step(actions(theta, observation, when))
        place[going] = info["torso_position"][going]
        going &= ~terminated
        when = float(info["time"].max())
    way = place - start
    return way[:, 0] - np.abs(way[:, 1]) - 0.3 * ~going


def main() -> None:
    """Train, and show the curve."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--robots", type=int, default=12)
    parser.add_argument("--seconds", type=float, default=6.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("learnt"))
    options = parser.parse_args()
    random, n = np.random.default_rng(options.seed), options.robots
    env = gymnasium.make_vec(
        "NaoHil-Velocity-v0", n, vectorization_mode="vector_entry_point", velocity=(0.2, 0.0, 0.0)
    )
    mean, width, curve = START.copy(), WIDTH.copy(), []
    began = time.monotonic()
    while not curve or time.monotonic() - began < 60.0 * options.minutes:
        theta = mean + width * random.standard_normal((n, len(mean)))
        theta[0] = mean
        found = scores(env, theta, int(random.integers(2**31)), options.seconds)
        best = theta[np.argsort(found)[::-1][: max(2, n // 4)]]
        mean, width = best.mean(axis=0), 0.7 * width + 0.3 * np.maximum(best.std(axis=0), 0.1 * WIDTH)
        curve.append((found[0], found.mean(), found.max()))
        print(f"generation {len(curve)}: mean pattern {found[0]:.3f} m, best {found.max():.3f} m", flush=True)
    for name, number in zip(NAMES, mean, strict=True):
        print(f"  {name} {number:.4f}")
    options.out.mkdir(exist_ok=True)
    np.savetxt(options.out / "pattern.txt", mean, header=" ".join(NAMES))
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.plot(np.array(curve), label=("mean pattern", "mean of all", "best"))
    pyplot.xlabel("generation")
    pyplot.ylabel(f"distance in {options.seconds:g} s, less drift and falls, m")
    pyplot.legend()
    pyplot.savefig(options.out / "curve.png")
    env.close()


if __name__ == "__main__":
    main()
