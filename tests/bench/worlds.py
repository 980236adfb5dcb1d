"""Cost of a world by its number of robots, against the engine's own steps of the same world, in one run.

Nominal V6 stand on a grid and do not touch each other. Cycles of the world, with servos, soles and sensors,
take turns with as many of the engine's own steps: the floor. CPU time of the process counts.
"""

from __future__ import annotations

import statistics
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import numpy as np

from bridge.body import load_body
from emulator.engine.catalogue import ENGINES
from emulator.engine.settings import SETTINGS
from emulator.robot import EmulatedRobot
from emulator.scenarios import FLAT
from emulator.start import build_world
from tests.bench.cycles import bare_cycle

ROBOTS: Final = (1, 2, 4, 7, 10, 15, 20)
BODY: Final = "nao-v6"
SPACING: Final = 1.0
"""m between two robots."""
BLOCKS: Final = 120
"""Cycles that count."""
IMAGE: Final = Path(__file__).parents[2] / "docs/images/worlds-cost.png"


def measure() -> dict[str, Any]:
    """CPU time of a cycle by number of robots for each engine, and the line through it."""
    return {engine: measure_engine(engine) for engine in ENGINES if find_spec(engine) is not None}


def measure_engine(engine: str) -> dict[str, Any]:
    """Measure one engine.

    Returns:
        `robots`: by their number `cycle_ms` and `bare_ms`, medians of CPU time, and `ratio`, the median of the
        engine's own share; `line`: ms of the world and ms of each robot by least squares, and `r_squared`.
    """
    rows = {number: _measure(engine, number) for number in ROBOTS}
    numbers, times = np.array(ROBOTS, dtype=float), np.array([row["cycle_ms"] for row in rows.values()])
    slope, offset = np.polyfit(numbers, times, 1)
    left = times - (slope * numbers + offset)
    return {
        "robots": rows,
        "line": {
            "world_ms": float(offset),
            "robot_ms": float(slope),
            "r_squared": float(1.0 - left.var() / times.var()),
        },
    }


def _measure(engine: str, number: int) -> dict[str, float]:
    world = build_world(engine, SETTINGS, FLAT, 0)
    body = load_body(BODY)
    places = [(SPACING * (i % 5), SPACING * (i // 5), 0.0) for i in range(number)]
    robots = [
        EmulatedRobot(body, seed=i, settle=0.1, name=f"nao{i}", at=at, world=world)
        for i, at in enumerate(places)
    ]
    world.start()
    full, bare = [], []
    try:
        for _ in range(BLOCKS):
            began = time.process_time()
            world.advance({})
            between = time.process_time()
            bare_cycle(robots[0])
            full.append(between - began)
            bare.append(time.process_time() - between)
    finally:
        world.engine.close()
    return {
        "cycle_ms": 1e3 * statistics.median(full),
        "bare_ms": 1e3 * statistics.median(bare),
        "ratio": statistics.median(b / f for b, f in zip(bare, full, strict=True)),
    }


def draw(results: dict[str, Any]) -> None:
    """Draw the cost by number of robots to `IMAGE`.

    Args:
        results: Of `measure`.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    for axes, (engine, result) in zip(
        figure.subplots(1, len(results), squeeze=False)[0], results.items(), strict=True
    ):
        numbers, line = list(result["robots"]), result["line"]
        for key, label in (("cycle_ms", "whole cycle"), ("bare_ms", "engine's own steps")):
            axes.plot(numbers, [row[key] for row in result["robots"].values()], "o", label=label)
        axes.plot(numbers, [line["world_ms"] + line["robot_ms"] * n for n in numbers], lw=0.8, color="C0")
        axes.axhline(1e3 * load_body(BODY).cycle, ls="--", lw=0.8, color="0.5", label="real time")
        axes.set(title=engine, xlabel="robots", ylabel="CPU time of a cycle, ms", ylim=(0.0, None))
    axes.legend(fontsize="small")
    figure.savefig(IMAGE, dpi=130)


if __name__ == "__main__":
    draw(measure())
