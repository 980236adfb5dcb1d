"""In-process emulator cycles per second on each engine, and the part of the engine's own step in them.

And where the time of a cycle goes: each part's time is taken on its own, so that a profiler's own cost per call
does not count against the parts with many small calls.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, Final

from bridge.body import load_body
from emulator.engine.catalogue import ENGINES
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear

PROFILES: Final = ("ideal", "nominal", "worn")
_BLOCK = 50
"""Cycles per timed block."""


def measure() -> dict[str, Any]:
    """`measure_one` of the V6 for each engine and wear, and `where_the_time_goes` in the nominal one."""
    results: dict[str, Any] = {}
    for engine in ENGINES:
        if find_spec(engine) is not None:
            results[engine] = {wear: measure_one(engine, wear=wear) for wear in PROFILES}
            results[engine]["fractions of a nominal cycle"] = where_the_time_goes(engine)
    return results


def where_the_time_goes(
    engine: str, body_name: str = "nao-v6", wear: str = "nominal", cycles: int = 500
) -> dict[str, float]:
    """Fractions of a cycle's time, the robot standing; `rest` is commands, hands and loops."""
    with EmulatedRobot(load_body(body_name), seed=0, wear=load_wear(wear), engine=engine) as robot:
        watches = {
            "bare engine step": _Watch(robot.engine, "bare_step"),
            "whole engine step": _Watch(robot.engine, "step"),
            "drives": _Watch(robot.servo, "torque"),
            "sensors": _Watch(robot.sensors, "update"),
            "frame": _Watch(robot, "_sample"),
        }
        try:
            for watch in watches.values():
                watch.spent = 0.0
            began = time.perf_counter()
            for _ in range(cycles):
                robot.advance(None)
            whole = time.perf_counter() - began
        finally:
            for watch in watches.values():
                watch.remove()
    fractions = {name: watch.spent / whole for name, watch in watches.items()}
    stepping = fractions.pop("whole engine step")
    fractions["torques, stops, contacts, joints"] = stepping - fractions["bare engine step"]
    return fractions | {"rest": 1.0 - sum(fractions.values())}


class _Watch:
    """Adds up the time spent in one function of an object."""

    def __init__(self, owner: Any, name: str) -> None:
        self._owner, self._name, self._original = owner, name, getattr(owner, name)
        self.spent = 0.0
        """s"""
        setattr(owner, name, self._timed(self._original))

    def _timed(self, function: Callable[..., Any]) -> Callable[..., Any]:
        clock = time.perf_counter

        def timed(*args: Any, **options: Any) -> Any:
            began = clock()
            try:
                return function(*args, **options)
            finally:
                self.spent += clock() - began

        return timed

    def remove(self) -> None:
        """Put the function back."""
        setattr(self._owner, self._name, self._original)


def measure_one(
    engine: str, body_name: str = "nao-v6", wear: str = "ideal", blocks: int = 20
) -> dict[str, Any]:
    """Time blocks of cycles, the robot standing, and the engine's own step within the same cycles.

    Returns:
        Medians over the blocks: cycles per second, the ratio of the engine's step to the whole cycle, the
        real-time factor, and that of the engine's step alone.
    """
    body = load_body(body_name)
    full, bare = [], []
    with EmulatedRobot(body, seed=0, wear=load_wear(wear), engine=engine) as robot:
        watch = _Watch(robot.engine, "bare_step")
        for _ in range(blocks):
            watch.spent, began = 0.0, time.perf_counter()
            for _ in range(_BLOCK):
                robot.advance(None)
            full.append((time.perf_counter() - began) / _BLOCK)
            bare.append(watch.spent / _BLOCK)
        watch.remove()
    cycle = statistics.median(full)
    return {
        "body": body_name,
        "cycles_per_second": 1.0 / cycle,
        "ratio": statistics.median(b / f for b, f in zip(bare, full, strict=True)),
        "real_time_factor": body.cycle / cycle,
        "bare_real_time_factor": body.cycle / statistics.median(bare),
    }
