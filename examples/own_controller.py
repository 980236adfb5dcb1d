"""A controller of your own: the robot bends its knees and straightens them again.

nao-hil emulate                      # in one terminal
python examples/own_controller.py    # in another
"""

import sys

import numpy as np

import nao_hil

PERIOD = 4.0  # s
DEPTH = 0.4  # rad of the knees
BEND = np.zeros(len(nao_hil.JOINTS))  # per rad of the knees; together these keep torso and soles level
for side in "LR":
    for joint, ratio in {"HipPitch": -0.5, "KneePitch": 1.0, "AnklePitch": -0.5}.items():
        BEND[nao_hil.JOINTS.index(side + joint)] = ratio


def main(*endpoint: str) -> None:
    """Squat once, and say how deep the knees went."""
    knee = nao_hil.JOINTS.index("LKneePitch")
    with nao_hil.connect(*endpoint, name="squatter", timeout=60.0) as robot:  # waits for it
        first = frame = robot.frame
        stand = np.array(robot.first_target)  # not the measured angles, which sag
        knees = []
        while (time := frame.time - first.time) < PERIOD:
            bend = 0.5 * DEPTH * (1.0 - np.cos(2.0 * np.pi * time / PERIOD))
            frame = robot.step(stand + bend * BEND)
            knees.append(frame.position[knee])
        print(f"{robot.info.body}: the knees went {max(knees) - knees[0]:.3f} rad down in {len(knees)} cycles")


if __name__ == "__main__":
    main(*sys.argv[1:])
