"""The emulated robot in this process: how far does the left knee lag behind a step of its request?

python examples/robot.py [BODY]
"""

import sys

import numpy as np

import nao_hil


def main(body: str) -> None:
    """One step of the knee on an ideal, a nominal and a worn robot."""
    knee = nao_hil.JOINTS.index("LKneePitch")
    for wear in ("ideal", "nominal", "worn"):
        with nao_hil.Robot(body, seed=1, wear=wear) as robot:
            wanted = np.array(robot.frame.position)
            wanted[knee] += 0.1
            angles = [robot.step(wanted, stiffness=0.8).position[knee] for _ in range(50)]
        early = 1000 * robot.cycle * next((i for i, a in enumerate(angles) if a > wanted[knee] - 0.05), 50)
        rest = wanted[knee] - angles[-1]
        print(f"{robot.body}, {wear}: half of it after {early:.0f} ms, {rest:+.4f} rad off")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "nao-v3")
