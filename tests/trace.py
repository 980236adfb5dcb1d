"""Usage: python -m tests.trace [--gait omni]: files, functions and lines executed in one tick and one cycle."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

from bridge.guard import Guard
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig
from nao_hil.runs.in_process import run

SOURCES = Path(__file__).parents[1]
WARM = 400
"""Cycles before the traced one: the robot walks then."""


def executed(act: Callable[[], Any]) -> tuple[int, int, int]:
    """Files, functions and lines of this project that a call executes.

    Args:
        act: the call.
    """
    lines: set[tuple[str, int]] = set()
    functions: set[tuple[str, str, int]] = set()

    def trace(frame: FrameType, event: str, _argument: object) -> Any:
        code = frame.f_code
        if not code.co_filename.startswith(str(SOURCES)) or ".venv" in code.co_filename:
            return None
        if not code.co_name.startswith("<"):
            functions.add((code.co_filename, code.co_name, code.co_firstlineno))
        if event == "line":
            lines.add((code.co_filename, frame.f_lineno))
        return trace

    sys.settrace(trace)
    try:
        act()
    finally:
        sys.settrace(None)
    return len({file for file, *_ in functions}), len(functions), len(lines)


def main() -> None:
    """Walk, then trace one tick of the controller, and one cycle of robot, guard and controller."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gait", default="omni")
    config = RunConfig(gait=parser.parse_args().gait, engine="mujoco", seed=1)
    with build_robot(config) as robot:
        guard, controller = Guard(robot.body), controller_maker(config)(robot.body, robot.body.cycle)
        run(robot, guard, controller, (), max_cycles=WARM)
        frame = robot.frame
        tick = executed(lambda: controller.tick(frame))
        cycle = executed(lambda: run(robot, guard, controller, (), max_cycles=1))
    for name, (files, functions, lines) in (("tick", tick), ("cycle", cycle)):
        print(f"{name}: {files} files, {functions} functions, {lines} lines")


if __name__ == "__main__":
    main()
