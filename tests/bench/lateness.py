"""Lateness of the robot's real-time cycle, against a bare 10 ms loop under the same priority."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from bridge.errors import LinkError
from nao_hil.runs.bare_loop import BareLoop
from nao_hil.runs.supervisor import Child, free_endpoint


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
    with BareLoop() as loop:
        time.sleep(seconds)
    late = loop.lateness
    return {"p50": np.percentile(late, 50), "p99": np.percentile(late, 99), "max": late.max()}


def _worst(rounds: list[dict[str, float]]) -> dict[str, float]:
    return {name: float(max(r[name] for r in rounds)) for name in ("p50", "p99", "max")}
