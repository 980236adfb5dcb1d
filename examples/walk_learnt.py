"""Walk a pattern that learn_to_walk.py has found, on any robot on the link, for ten seconds.

nao-hil emulate --robot nao-v6                         # in one terminal
python examples/walk_learnt.py learnt/pattern.txt      # in another
"""

import argparse
import math
from pathlib import Path

import numpy as np

import nao_hil
from bridge.body.postures import POSTURES

LEGS = [slot for slot, name in enumerate(nao_hil.JOINTS) if name[1:].startswith(("Hip", "Knee", "Ankle"))]
POSTURE = np.array(POSTURES["StandInit"])


def leg_angles(theta: np.ndarray, gyroscope: np.ndarray, when: float, size: float) -> np.ndarray:
    """Angles of the leg joints from the posture, (N, 11), rad.

    Args:
        theta: Patterns, (N, 8).
        gyroscope: Measured rates, (N, 3), rad/s.
        when: Time since the beginning, s.
        size: Of the motion, 0 to 1: it begins and ends gently.
    """
    frequency, lift, sway, sway_phase, stride, lean, roll_gain, pitch_gain = theta.T
    phase = 2.0 * np.pi * frequency * when
    roll, tilt = size * sway * np.sin(phase + sway_phase), pitch_gain * gyroscope[:, 1]
    legs = {}
    for side, sign in (("L", 1.0), ("R", -1.0)):
        up = size * lift * np.maximum(0.0, sign * np.sin(phase))
        swing = -size * stride * sign * np.cos(phase)
        legs |= {f"{side}HipRoll": roll, f"{side}AnkleRoll": roll_gain * gyroscope[:, 0] - roll}
        legs |= {f"{side}HipPitch": -up - swing - lean, f"{side}KneePitch": 2.0 * up}
        legs |= {f"{side}AnklePitch": swing - up + tilt}
    return np.stack([legs.get(nao_hil.JOINTS[slot], 0.0 * phase) for slot in LEGS], axis=1)


def main() -> None:
    """Walk, then stand; say how far the torso tilted and how many cycles were missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pattern", type=Path, help="eight numbers, as learn_to_walk.py writes them")
    parser.add_argument("endpoint", nargs="*", help="of the robot; default: this machine")
    parser.add_argument("--seconds", type=float, default=10.0)
    options = parser.parse_args()
    theta = np.loadtxt(options.pattern)[None]
    with nao_hil.connect(*options.endpoint[:1], name="learnt", timeout=60.0) as robot:
        first = frame = robot.frame
        tilt, cycles = 0.0, 0
        while (when := frame.time - first.time) < options.seconds:
            size = min(when, 1.0, options.seconds - when)
            angles = POSTURE.copy()
            angles[LEGS] += leg_angles(theta, np.array([frame.gyroscope]), when, size)[0]
            frame = robot.step(angles)
            tilt, cycles = max(tilt, *map(abs, frame.angle)), cycles + 1
        print(f"{cycles} answers in {frame.seq - first.seq} cycles, {frame.missed - first.missed} missed")
        print(f"tilt at most {math.degrees(tilt):.3f} deg")


if __name__ == "__main__":
    main()
