"""Robot and controller in one process, called directly: for tests and campaigns; no link, no wall clock."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from bridge.guard import Guard
from bridge.messages import Notice
from bridge.observer import Observer
from emulator.robot import EmulatedRobot
from walker.controller import Controller


def run(
    robot: EmulatedRobot,
    guard: Guard,
    controller: Controller,
    observers: Sequence[Observer],
    most: int,
    ended: Callable[[], bool] = lambda: False,
) -> None:
    """Cycle until the controller is done, an observer has seen enough (`ended`), or `most` cycles.

    Gives the very frames that lockstep over the link gives.
    """
    for observer in observers:
        observer.sensors(robot.frame, robot.truth())
    for _ in range(most):
        command = guard.cycle(robot.frame, guard.check(controller.tick(robot.frame), robot.frame.seq))
        for observer in observers:
            observer.telemetry(controller.telemetry)
            if command is not None:
                observer.command(command)
        _tell(guard.take_notices(), observers)
        robot.advance(command)
        for observer in observers:
            observer.sensors(robot.frame, robot.truth())
        _tell(robot.take_notices(), observers)
        if controller.done or ended():
            return


def _tell(notices: Sequence[Notice], observers: Sequence[Observer]) -> None:
    for notice in notices:
        for observer in observers:
            observer.notice(notice)
