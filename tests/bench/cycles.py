"""In-process emulator cycles per second on each engine, against the engine's own steps.

Cycles take turns with as many of the engine's own steps of the same standing robot, nothing applied and nothing
read: the floor. The times of a cycle's parts are measured one by one, so that a profiler's
own cost per call does not count against the parts with many small calls.
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
from emulator.wear import WEAR, load_wear
from tests.engines import bare_step


def bare_cycle(robot: EmulatedRobot) -> None:
    """The engine's own time steps of one cycle, nothing applied and nothing read.

    Args:
        robot: one whose engine is stepped; the robot itself does not notice.
    """
    engine = robot.engine
    for _ in range(round(robot.body.cycle / engine.settings.step)):
        bare_step(engine)


BODY: Final = "nao-v6"


def measure() -> dict[str, Any]:
    """`measure_one` of the V6 for each engine and wear, and `where_the_time_goes` in the nominal one."""
    results: dict[str, Any] = {}
    for engine in ENGINES:
        if find_spec(engine) is not None:
            results[engine] = {wear: measure_one(engine, wear) for wear in WEAR}
            results[engine]["fractions of a nominal cycle"] = where_the_time_goes(engine)
    return results


def where_the_time_goes(engine: str) -> dict[str, float]:
    """Fractions of a cycle's time, a nominal robot standing; `rest` is commands, heat and hands."""
    body = load_body(BODY)
    with EmulatedRobot(body, seed=0, wear=load_wear("nominal", body), engine=engine) as robot:
        watches = {
            "steps with drives, stops and contacts": _Watch(robot.engine, "run"),
            "sensors": _Watch(robot.sensors, "update"),
            "frame": _Watch(robot, "_sample"),
        }
        try:
            for watch in watches.values():
                watch.spent = 0.0
            began = time.perf_counter()
            for _ in range(500):
                robot.advance(None)
            whole = time.perf_counter() - began
        finally:
            for watch in watches.values():
                watch.remove()
    fractions = {name: watch.spent / whole for name, watch in watches.items()}
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


def measure_one(engine: str, wear: str) -> dict[str, Any]:
    """Time cycles, the robot standing, in turn with the engine's own steps.

    Returns:
        Medians over the cycles: cycles per second, the ratio of the engine's own steps to the whole cycle, the
        real-time factor, and that of the engine's own steps alone.
    """
    body = load_body(BODY)
    full, bare = [], []
    with EmulatedRobot(body, seed=0, wear=load_wear(wear, body), engine=engine) as robot:
        for _ in range(1000):
            began = time.perf_counter()
            robot.advance(None)
            between = time.perf_counter()
            bare_cycle(robot)
            full.append(between - began)
            bare.append(time.perf_counter() - between)
    cycle = statistics.median(full)
    return {
        "body": BODY,
        "cycles_per_second": 1.0 / cycle,
        "ratio": statistics.median(b / f for b, f in zip(bare, full, strict=True)),
        "real_time_factor": body.cycle / cycle,
        "bare_real_time_factor": body.cycle / statistics.median(bare),
    }
