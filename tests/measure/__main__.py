"""`python -m tests.measure NAME` measures the project itself; its options are those of `nao-hil experiment`."""

from __future__ import annotations

import sys

from nao_hil.cli.__main__ import main
from nao_hil.experiments.catalogue import EXPERIMENTS, Entry

MEASUREMENTS = {
    "network": Entry(
        "tests.measure.network.NETWORK",
        "walks in real time over delay, jitter and loss (root, Linux)",
        20,
        any_gait=True,
    ),
    "outages": Entry(
        "tests.measure.outages.OUTAGES", "walks with the link interrupted, or a process killed (root, Linux)", 1
    ),
    "soak": Entry("tests.measure.soak.SOAK", "a long walk: memory, files, punctuality, drift (Linux)", 1),
    "sensitivity": Entry(
        "tests.measure.sensitivity.SENSITIVITY", "which unknowns of the robot decide what: Morris, Sobol'", 10
    ),
    "servo-table": Entry(
        "tests.measure.servo_table.SERVO_TABLE", "speed, delay, backlash, torque and heat of every leg drive", 1
    ),
    "ensemble": Entry(
        "tests.measure.ensemble.ENSEMBLE",
        "robots that agree with the measurements of real ones: as many as seeds, drawn from the first",
        24,
    ),
    "stops": Entry("tests.measure.stops.STOPS", "walks that are told to stop at any moment", 20),
    "thesis-map": Entry(
        "tests.measure.thesis_map", "R1, R2 and R5 over what the thesis leaves open", 20, False
    ),
}

if __name__ == "__main__":
    EXPERIMENTS.update(MEASUREMENTS)
    sys.argv[1:1] = ["experiment"]
    main()
