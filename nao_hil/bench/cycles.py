"""In-process emulator cycles per second, beside the engine's bare step of the same model in the same state.

And where the time of a cycle goes: each part's time is taken on its own, so that a profiler's own cost per call
does not count against the parts with many small calls.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any, Final

from bridge.body import load_body
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear

PROFILES: Final = ("ideal", "nominal", "worn")
_BLOCK = 50
"""Cycles per timed block; blocks of both kinds alternate, so that a drifting machine slows both."""


def measure() -> dict[str, Any]:
    """`measure_one` of the V3 for each wear profile, and `where_the_time_goes` in the nominal one."""
    results: dict[str, Any] = {wear: measure_one(wear=wear) for wear in PROFILES}
    return results | {"fractions of a nominal cycle": where_the_time_goes()}


def where_the_time_goes(
    body_name: str = "nao-v3", wear: str = "nominal", cycles: int = 500
) -> dict[str, float]:
    """Fractions of a cycle's time, the robot standing; `rest` is commands, hands and loops."""
    with EmulatedRobot(load_body(body_name), seed=0, wear=load_wear(wear)) as robot:
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


def measure_one(body_name: str = "nao-v3", wear: str = "ideal", blocks: int = 20) -> dict[str, Any]:
    """Time blocks of full cycles and of bare physics steps in turn, the robot standing.

    Returns:
        Medians: cycles per second of both, the ratio of the bare step to the whole cycle, real-time factor.
    """
    body = load_body(body_name)
    full, bare = [], []
    with EmulatedRobot(body, seed=0, wear=load_wear(wear)) as robot:
        steps = round(body.cycle / robot.engine.settings.step)
        for _ in range(blocks):
            began = time.perf_counter()
            for _ in range(_BLOCK):
                robot.advance(None)
            full.append((time.perf_counter() - began) / _BLOCK)
            # The drives' last torques are gone after one step: the bare floor is a robot that sinks a little.
            began = time.perf_counter()
            for _ in range(steps * 4):
                robot.engine.bare_step()
            bare.append((time.perf_counter() - began) / 4)
    cycle, floor = statistics.median(full), statistics.median(bare)
    return {
        "body": body_name,
        "wear": wear,
        "cycles_per_second": 1.0 / cycle,
        "bare_cycles_per_second": 1.0 / floor,
        "ratio": floor / cycle,
        "real_time_factor": body.cycle / cycle,
    }
