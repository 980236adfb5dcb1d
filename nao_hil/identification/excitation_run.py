"""The motion of `excitation`, done by an emulated robot in this process or by any robot on the link."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import msgspec

from bridge.body import load_body
from bridge.errors import ConfigurationError
from bridge.guard import Guard
from bridge.recording.recorder import Recorder
from bridge.validation import unknown_name
from emulator.start import STAND
from nao_hil.commands import actuator_frame
from nao_hil.connection import Connection
from nao_hil.identification.excitation import SHORTEST, excitation
from nao_hil.identification.replay import HANG
from nao_hil.runs.build import build_robot
from nao_hil.runs.capture import described
from nao_hil.runs.config import RunConfig

Progress = Callable[[float], None]


class ExcitationResult(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil excite`."""

    recording: str
    robot: str
    seconds: float
    cycles: int
    cycles_left_out: int
    """Cycles of a robot in real time that were not answered."""
    clipped: int | None
    """Commands that the guard had to change: none; None: not known of a robot on the link."""
    seed: int | None
    """Of the emulated robot; None: a robot on the link."""


def check_start(start: str, duration: float) -> None:
    """Whether there is a motion of this kind.

    Raises:
        ConfigurationError: another start, or too short for every joint to move.
    """
    if start not in (HANG, STAND):
        raise ConfigurationError(unknown_name("start", start, (HANG, STAND)))
    if not (math.isfinite(duration) and duration >= SHORTEST):
        raise ConfigurationError(f"--duration {duration:g}: the motion takes {SHORTEST:g} s at least.")


def excite_emulated(
    settings: RunConfig, duration: float, file: Path, progress: Progress = lambda _: None
) -> ExcitationResult:
    """Move an emulated robot in this process, behind its guard.

    Args:
        settings: Body, wear, engine, scenario, start and seed.
        duration: s
        file: Recording to write.
        progress: Told of the share that is done.

    Raises:
        ConfigurationError: no such body, wear profile, scenario or start, or too short a duration.
    """
    check_start(settings.start, duration)
    clipped = 0
    with build_robot(settings) as robot, Recorder(file, settings) as recorder:
        guard = Guard(robot.body, settings.guard)
        hanging = settings.start == HANG
        commands = excitation(robot.body, robot.frame.position, duration, hanging=hanging)
        for number, position in enumerate(commands):
            recorder.sensors(robot.frame, robot.truth())
            wanted = actuator_frame(robot.seq, position, 1.0)
            command = guard.cycle(robot.frame, guard.check(wanted, robot.seq))
            if command is None or command.position != wanted.position:
                clipped += 1
            for notice in guard.take_notices():
                recorder.notice(notice)
            if command is not None:
                recorder.command(command)
            robot.advance(command)
            progress((number + 1) / len(commands))
        recorder.sensors(robot.frame, robot.truth())
    return ExcitationResult(
        recording=str(file),
        robot=robot.body.name,
        seconds=robot.time,
        cycles=len(commands),
        cycles_left_out=0,
        clipped=clipped,
        seed=settings.seed,
    )


def excite_linked(
    connection: Connection, start: str, duration: float, file: Path, progress: Progress = lambda _: None
) -> ExcitationResult:
    """Move a robot on the link, from where it is; changes by its guard are not recorded.

    Args:
        connection: To the robot; holds the lease.
        start: `hang`: the legs move too.
        duration: s
        file: Recording to write.
        progress: Told of the share that is done.

    Raises:
        ConfigurationError: too short a duration.
        LinkError: the robot went away, or its guard took it.
    """
    check_start(start, duration)
    body, frame = load_body(connection.info.body), connection.frame
    commands = excitation(body, frame.position, duration, hanging=start == HANG)
    first, answered = frame.seq, 0
    with Recorder(file, described(connection.info) | {"start": start}) as recorder:
        while frame.seq - first < len(commands):
            recorder.write(frame)
            position = commands[frame.seq - first]
            recorder.write(actuator_frame(frame.seq, position, 1.0))
            frame = connection.step(position, 1.0)
            answered += 1
            progress((frame.seq - first) / len(commands))
        recorder.write(frame)
    return ExcitationResult(
        recording=str(file),
        robot=body.name,
        seconds=(frame.seq - first) * body.cycle,
        cycles=len(commands),
        cycles_left_out=len(commands) - answered,
        clipped=None,
        seed=None,
    )
