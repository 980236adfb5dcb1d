"""Time of the search for x_sd and x_ed: the whole grid at once, against one pose after another."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from bridge.body import load_body
from nao_hil.design.huang.cycle import Cycle
from nao_hil.design.huang.search import along
from walker.gaits import gait_parameters
from walker.gaits.huang import HuangParameters
from walker.gaits.huang.hip import Choice
from walker.gaits.pose import ARMS

GRID = 100
POINTS = 8
"""Points of the grid that are evaluated pose by pose; the time of all of them is extrapolated."""
CHOICE = Choice(0.0186, 0.0169, 0.0194, 0.0410)


def measure() -> dict[str, Any]:
    """One cycle at 10 ms, all bodies, on one core.

    Returns:
        Times of the whole grid at once and, extrapolated, of each point by itself, s; both also as processor
        time; and how far the margins of the points differ, m.
    """
    p = gait_parameters("huang")
    assert isinstance(p, HuangParameters)
    cycle = Cycle(p, load_body("nao-v3"), ARMS)
    along(cycle, CHOICE, 4)  # imports and caches
    began, worked = time.perf_counter(), time.process_time()
    _, surface = along(cycle, CHOICE, GRID)
    at_once, at_once_cpu = time.perf_counter() - began, time.process_time() - worked
    rng = np.random.default_rng(0)
    apart = []
    began, worked = time.perf_counter(), time.process_time()
    for i, j in rng.integers(0, GRID, (POINTS, 2)):
        choice = CHOICE._replace(x_sd=float(surface.first[i]), x_ed=float(surface.second[j]))
        apart.append(abs(cycle.margin(choice) - surface.margin[i, j]))
    ratio = GRID**2 / POINTS
    return {
        "grid": f"{GRID} x {GRID}",
        "moments": len(cycle.times),
        "at_once": at_once,
        "at_once_processor": at_once_cpu,
        "point_by_point": ratio * (time.perf_counter() - began),
        "point_by_point_processor": ratio * (time.process_time() - worked),
        "margins_differ_by": float(max(apart)),
    }
