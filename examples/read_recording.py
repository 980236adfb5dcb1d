"""Read a recording: the largest tilt of the torso in each phase of the walk, and the load on the left foot.

nao-hil up --steps 6 --mode lockstep --out walk
python examples/read_recording.py walk/frames.mcap
"""

import sys

import numpy as np

import nao_hil


def main(file: str) -> None:
    """Sensor frames by the phase of the walk in which they were measured."""
    recording = nao_hil.load(file)
    print(f"{recording.config['robot']}, gait {recording.config.get('gait', 'not known')}")
    sensors, telemetry = recording["sensors"], recording["walk/telemetry"]
    _, frames, words = np.intersect1d(sensors["seq"], telemetry["seq"], return_indices=True)
    phases = telemetry["phase"][words]
    tilt = np.degrees(np.abs(sensors["angle"][frames]).max(axis=1))
    load = sensors["fsr"][frames, :4].sum(axis=1)
    for phase in dict.fromkeys(phases):
        now = phases == phase
        print(f"{phase:5}  torso {tilt[now].max():4.1f} deg  left foot {load[now].mean():4.1f} N")


if __name__ == "__main__":
    main(sys.argv[1])
