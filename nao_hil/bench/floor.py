"""The floor of benchmarks that step an engine."""

from __future__ import annotations

from emulator.robot import EmulatedRobot


def bare_cycle(robot: EmulatedRobot) -> None:
    """The engine's own time steps of one cycle, nothing applied and nothing read.

    Args:
        robot: one whose engine is stepped; the robot itself does not notice.
    """
    engine = robot.engine
    for _ in range(round(robot.body.cycle / engine.settings.step)):
        engine.bare_step()
