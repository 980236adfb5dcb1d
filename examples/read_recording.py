"""Read a recording: the largest tilt of the torso in each phase of the walk, and the load on the feet.

nao-hil up --steps 6 --mode lockstep --out walk
python examples/read_recording.py walk/frames.mcap
"""

import math
import sys
from collections import defaultdict

from bridge.messages import SensorFrame, WalkTelemetry
from bridge.playback import read_recording, recorded_config


def main(file: str) -> None:
    """One pass over the messages, in the order in which they were recorded."""
    config = recorded_config(file)
    print(f"{config['robot']}, gait {config.get('gait', 'not known')}")
    tilt: dict[str, float] = defaultdict(float)
    load: dict[str, list[float]] = defaultdict(list)
    phase = "-"
    for _topic, _time, message in read_recording(file):
        if isinstance(message, WalkTelemetry):
            phase = message.phase
        elif isinstance(message, SensorFrame):
            tilt[phase] = max(tilt[phase], *map(abs, message.angle))
            load[phase].append(sum(message.fsr[:4]))
    for phase, angle in tilt.items():
        mean = sum(load[phase]) / len(load[phase])
        print(f"{phase:5}  torso {math.degrees(angle):4.1f} deg  left foot {mean:4.1f} N")


if __name__ == "__main__":
    main(sys.argv[1])
