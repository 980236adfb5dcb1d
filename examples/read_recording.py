"""Read a recording: the largest tilt of the torso in each phase of the walk, and the load on the left foot.

nao-hil up --steps 6 --mode lockstep --out walk
python examples/read_recording.py walk/frames.mcap
"""

import sys

import numpy as np

import nao_hil


def main(file: str) -> None:
    """Sensor frames by the phase of the walk in which they were measured."""
    run = nao_hil.load(file)
    print(f"{run.config['robot']}, gait {run.config.get('gait', 'not known')}")
    walk = run["walk/telemetry"]
    sensors = run["sensors"].where(run["sensors"]["seq"] >= walk["seq"][0])
    phases = walk["phase"][walk.last("seq", sensors["seq"])]
    tilt = np.degrees(np.abs(sensors["angle"]).max(axis=1))
    load = sensors["fsr"][:, :4].sum(axis=1)
    for phase in dict.fromkeys(phases):
        now = phases == phase
        print(f"{phase:5}  torso {tilt[now].max():4.1f} deg  left foot {load[now].mean():4.1f} N")


if __name__ == "__main__":
    main(sys.argv[1])
