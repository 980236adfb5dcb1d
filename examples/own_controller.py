"""A controller of your own: the robot bends its knees and straightens them again.

nao-hil emulate                      # in one terminal
python examples/own_controller.py    # in another
"""

import math
import sys

from bridge.joints import INDEX, N_JOINTS
from bridge.link import DEFAULT_ENDPOINT, ControllerLink
from bridge.messages import ActuatorFrame

PERIOD = 4.0  # s
DEPTH = 0.4  # rad of the knees
SHARES = {"HipPitch": -0.5, "KneePitch": 1.0, "AnklePitch": -0.5}  # together they keep torso and soles level


def squat(start: tuple[float, ...], time: float) -> tuple[float, ...]:
    """Joint angles some seconds after the beginning, rad."""
    bend = 0.5 * DEPTH * (1.0 - math.cos(2.0 * math.pi * time / PERIOD))
    angles = list(start)
    for side in "LR":
        for joint, share in SHARES.items():
            angles[INDEX[side + joint]] += share * bend
    return tuple(angles)


def main(endpoint: str) -> None:
    """Squat once, and say how deep the knees went."""
    knee, first = INDEX["LKneePitch"], None
    with ControllerLink(connect=endpoint, name="squatter") as link:
        info = link.wait_robot()
        link.acquire()  # one controller at a time
        receive = link.next if info.mode == "lockstep" else link.latest
        knees, time = [], 0.0
        while time < PERIOD:
            frame = receive(1.0)  # None: nothing came within a second
            if frame is None:
                continue
            first = first or frame
            time = frame.time - first.time
            knees.append(frame.position[knee])
            angles = squat(first.position, time)
            link.send(ActuatorFrame(reply_to=frame.seq, position=angles, stiffness=(1.0,) * N_JOINTS))
        link.release()
    print(f"{info.body}: the knees went {max(knees) - knees[0]:.3f} rad down in {len(knees)} cycles")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else DEFAULT_ENDPOINT)
