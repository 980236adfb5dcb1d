"""How often does it fall? The same walk with many seeds, in this process; also in a world of your own.

python examples/batch.py [SEEDS] [SCENARIO.toml]
"""

import math
import sys

import nao_hil


def main(seeds: int, scenario: str) -> None:
    """Ten seconds of the dynamic gait, without and with torso control."""
    for torso in ("none", "robust"):
        walks = [
            nao_hil.walk("dynamic", seed=seed, scenario=scenario, duration=10.0, torso=torso, engine="mujoco")
            for seed in range(seeds)
        ]
        stand = sum(not walk.fell for walk in walks)
        worst = max(math.degrees(walk.torso_max) for walk in walks)
        print(f"torso control {torso}: {stand} of {seeds} stand, torso within {worst:.1f} deg")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 4, sys.argv[2] if len(sys.argv) > 2 else "flat")
