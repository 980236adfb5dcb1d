"""Whether the machine could hold a robot's cycle while a real-time test ran; nothing of the project is judged.

A bare loop of the robot's period and priority runs beside the test, and the engine alone is stepped after it.
Neither runs the project's servos, sensors, link or walker: what these need too much of fails the test.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from typing import Final

import numpy as np

LATE: Final = 0.005
"""s, half of a cycle: a robot that begins its work so late misses the cycle."""
LATE_RATIO: Final = 0.01
"""Of the bare loop's deadlines in any `STRETCH`, may be late."""
STRETCH: Final = 1000
"""Deadlines, ten seconds: a stall of a second or two fails a test that goes on for minutes."""
ENGINE_SHARE: Final = 0.0025
"""s, a quarter of a cycle: for the engine alone; the rest is for both processes and the link."""

ENGINE_ALONE: Final = """
import time
from bridge.body import load_body
from emulator.robot import EmulatedRobot
from tests.engines import bare_step
with EmulatedRobot(load_body("nao-v6"), seed=0) as robot:
    for _ in range(100):
        begin = time.process_time()
        for _ in range(10):
            bare_step(robot.engine)
        print(time.process_time() - begin)
"""


def engine_cycles() -> list[float]:
    """CPU time that the bare engine needs for a cycle's ten steps, s, 100 times, in a process of its own."""
    run = subprocess.run([sys.executable, "-c", ENGINE_ALONE], capture_output=True, text=True, check=True)
    return [float(line) for line in run.stdout.split()]


def complaint(lateness: Sequence[float], cycles: Sequence[float]) -> str:
    """What the machine lacked; empty: a robot's cycle could be held.

    Args:
        lateness: of the bare loop's deadlines beside the test, s.
        cycles: of the bare engine, s.
    """
    over = np.array(lateness if len(lateness) else [0.0]) > LATE  # none: the test ended at once
    stretch = min(STRETCH, len(over))
    late = float(np.convolve(over, np.ones(stretch), mode="valid").max()) / stretch
    work = float(np.median(cycles))
    if late > LATE_RATIO:
        return f"a bare loop beside it began {100 * late:.1f} % of its cycles over {1e3 * LATE:g} ms late"
    if work > ENGINE_SHARE:
        return f"the engine alone needs {1e3 * work:.1f} ms of each cycle"
    return ""
