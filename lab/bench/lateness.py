"""Lateness of the robot's real-time cycle, beside a bare 10 ms loop under the same priority."""

from __future__ import annotations

import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from bridge.errors import LinkError
from bridge.realtime import ROBOT_PRIORITY, quiet_process
from emulator.timing import CycleTimer
from lab.supervisor import Child


def free_endpoint() -> str:
    """A loopback endpoint that nobody listens on now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def measure(seconds: float = 10.0, rounds: int = 2) -> dict[str, Any]:
    """A walking robot's process, then a bare loop's, in turn.

    Returns:
        For both: p50, p99 and max of the lateness, s, the worst of the rounds each.

    Raises:
        LinkError: one of the processes failed.
    """
    walking, bare = [], []
    for _ in range(rounds):
        walking.append(_walking(seconds))
        bare.append(_bare(seconds))
    return {"seconds": seconds, "rounds": rounds, "robot": _worst(walking), "bare_loop": _worst(bare)}


def _walking(seconds: float) -> dict[str, float]:
    endpoint = free_endpoint()
    with tempfile.TemporaryDirectory() as folder:
        robot = Child("robot", ["emulate", "--listen", endpoint, "--out", folder, "--json"], Path(folder))
        walker = Child("walker", ["walk", "--connect", endpoint, "--steps", "0"], Path(folder))
        time.sleep(seconds)
        walker.end(5.0)
        outcome = robot.end(5.0)
    if outcome.result is None:
        raise LinkError(f"the robot's process failed: {outcome.error}")
    lateness: dict[str, float] = outcome.result["timing"]["lateness"]
    return lateness


def _bare(seconds: float) -> dict[str, float]:
    command = [sys.executable, "-c", f"from lab.bench.lateness import bare_loop; bare_loop({seconds!r})"]
    root = Path(__file__).parents[2]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=root)
    p50, p99, largest = (float(word) for word in done.stdout.split())
    return {"p50": p50, "p99": p99, "max": largest}


def bare_loop(seconds: float) -> None:
    """Wait for 10 ms deadlines and do nothing else; prints p50, p99 and max of the lateness."""
    timer = CycleTimer(0.01)
    quiet_process(ROBOT_PRIORITY)
    for _ in range(round(seconds / 0.01)):
        timer.wait()
    lateness = timer.times.lateness
    print(lateness.p50, lateness.p99, lateness.max)


def _worst(rounds: list[dict[str, float]]) -> dict[str, float]:
    return {name: max(r[name] for r in rounds) for name in ("p50", "p99", "max")}
