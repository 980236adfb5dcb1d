"""Memory of the processes of a walk, by the cycle: the slope shows a leak of kilobytes."""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nao_hil.runs.monitor import Monitor
from tests.loops import until
from tests.processes import memory

WARM, WINDOW, END = 1000, 250, 2750
"""Cycles: libraries are loaded by the first; the median of the windows leaves out a buffer that grows once."""
SLOPE = 500.0
"""bytes a cycle: 180 MB an hour; measured are 60 at most."""


def test_no_process_of_a_walk_grows_by_half_a_kilobyte_a_cycle(
    start: Callable[..., Any], endpoint: str, tmp_path: Path
) -> None:
    """Robot, walker and recorder in lockstep: as many cycles, however busy the machine is."""
    emulate = ["emulate", "--engine", "mujoco", "--mode", "lockstep", "--listen", endpoint]
    commands = {"robot": start(*emulate, "--out", str(tmp_path / "run"))}
    commands["recorder"] = start("record", "--connect", endpoint, "--out", str(tmp_path / "heard.mcap"))
    commands["walker"] = start("walk", "--connect", endpoint, "--steps", "0", "--velocity", "0.05", "0", "0.2")
    with Monitor("nao", endpoint) as monitor:

        def sizes_at(cycle: int) -> tuple[int, dict[str, int]]:
            until(
                lambda: monitor.connect() and monitor.sensors and monitor.sensors.seq >= cycle, f"cycle {cycle}"
            )
            assert monitor.sensors is not None
            return monitor.sensors.seq, {name: memory(one.process.pid) for name, one in commands.items()}

        looks = [sizes_at(cycle) for cycle in range(WARM, END + 1, WINDOW)]
    slopes = {
        name: statistics.median((b[name] - a[name]) / (m - n) for (n, a), (m, b) in itertools.pairwise(looks))
        for name in commands
    }
    assert max(slopes.values()) < SLOPE, slopes
