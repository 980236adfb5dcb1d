"""`python -m tests.measure NAME` measures the project itself; its options are those of `nao-hil experiment`."""

from __future__ import annotations

import sys

from nao_hil.cli.__main__ import main
from nao_hil.experiments.catalogue import EXPERIMENTS, Entry

MEASUREMENTS = {
    "network": Entry(
        "tests.measure.network", "walks in real time over delay, jitter and loss (root, Linux)", 20, False, True
    ),
    "outages": Entry(
        "tests.measure.outages", "walks with the link interrupted, or a process killed (root, Linux)", 1, False
    ),
    "soak": Entry("tests.measure.soak", "a long walk: memory, files, punctuality, drift (Linux)", 1, False),
    "sensitivity": Entry(
        "tests.measure.sensitivity", "which unknowns of the robot decide what: Morris, Sobol'", 10, False
    ),
    "thesis-map": Entry(
        "tests.measure.thesis_map", "R1, R2 and R5 over what the thesis leaves open", 20, False
    ),
}

if __name__ == "__main__":
    EXPERIMENTS.update(MEASUREMENTS)
    sys.argv[1:1] = ["experiment"]
    main()
