"""Robot and controller in one process, called directly: no link, no wall clock."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Sequence

import msgspec

from bridge.guard import Guard
from bridge.messages import ActuatorFrame, Notice
from bridge.recording.observer import Observer
from emulator.robot import EmulatedRobot
from nao_hil.runs.build import build_robot, controller_maker, require_upright, with_engine
from nao_hil.runs.config import RunConfig
from nao_hil.runs.neighbours import LocalWalker
from nao_hil.runs.summary import RunStatistics, Summary
from walker.controller import Controller


def walk_in_process(
    settings: RunConfig, observers: Sequence[Observer] = (), stop: Callable[[], bool] = lambda: False
) -> Summary:
    """Walk as configured, until the order is done, the robot lies still after a fall, or `stop()`.

    Args:
        settings: Configuration of the run.
        observers: Called in each cycle.
        stop: Asked after each cycle.

    Raises:
        ConfigurationError: no such body, wear profile or scenario, parameters that cannot be walked, or a robot
            that falls before its first cycle.
    """
    settings = with_engine(settings)
    make, statistics = controller_maker(settings), RunStatistics(settings.seed, settings.engine)
    with build_robot(settings) as robot:
        require_upright(robot)
        controller = make(robot.body, robot.body.cycle)
        began = time.monotonic()
        run(robot, Guard(robot.body, settings.guard), controller, [statistics, *observers], ended=stop)
        summary = statistics.summary(time.monotonic() - began)
        return msgspec.structs.replace(summary, inference=controller.inference)


def run(
    robot: EmulatedRobot,
    guard: Guard,
    controller: Controller,
    observers: Sequence[Observer],
    max_cycles: int | None = None,
    ended: Callable[[], bool] = lambda: False,
    neighbours: Sequence[LocalWalker] = (),
) -> None:
    """Cycle until the controller is done, `ended()`, or `max_cycles`; the frames are those of lockstep.

    Args:
        robot: At the boundary of its first cycle.
        guard: Between controller and robot.
        controller: At the beginning of its order.
        observers: Called in each cycle.
        max_cycles: None: no bound.
        ended: Asked after each cycle.
        neighbours: Walkers of all other robots in its world.
    """
    for observer in observers:
        observer.sensors(robot.frame, robot.truth())
    for _ in itertools.count() if max_cycles is None else range(max_cycles):
        command = guard.cycle(robot.frame, guard.check(controller.tick(robot.frame), robot.frame.seq))
        for observer in observers:
            observer.message(controller.telemetry)
            if command is not None:
                observer.command(command)
        _publish(guard.take_notices(), observers)
        _advance(robot, command, neighbours)
        for observer in observers:
            observer.sensors(robot.frame, robot.truth())
        _publish(robot.take_notices(), observers)
        if controller.done or ended():
            return


def _advance(robot: EmulatedRobot, command: ActuatorFrame | None, neighbours: Sequence[LocalWalker]) -> None:
    """Run the world's next cycle in which the robot's DCM runs."""

    def others() -> dict[str, ActuatorFrame]:
        answers = ((walker.name, walker.answer()) for walker in neighbours)
        return {name: answer for name, answer in answers if answer is not None}

    while robot.stalls():
        robot.world.advance(others())
    robot.world.advance(others() | ({} if command is None else {robot.name: command}))


def _publish(notices: Sequence[Notice], observers: Sequence[Observer]) -> None:
    for notice in notices:
        for observer in observers:
            observer.message(notice)
