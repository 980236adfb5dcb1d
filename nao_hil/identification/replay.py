"""The commands of a recording, given to the emulated robot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from bridge.messages import ActuatorFrame, SensorFrame
from emulator.robot import EmulatedRobot
from emulator.scenarios import load_scenario
from emulator.start import STAND
from emulator.wear import load_wear
from nao_hil.identification.readings import COMMANDS, NAMES, Signals, hangs
from nao_hil.identification.recorded import RecordedSignals
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig

HANG: Final = "hang"
_CLEARANCE: Final = 0.1
"""Height of a hanging robot's soles over the floor, m."""


def replay(
    recorded: RecordedSignals, settings: RunConfig, progress: Callable[[int], None] = lambda _: None
) -> Signals:
    """Run the emulated robot under the recorded commands, open loop.

    It begins as the recording's robot did where the recording says how, else at rest in the first measured
    posture, hanging if the settings say so or its feet carry nothing; without angles, as the settings say.

    Args:
        recorded: Commands; a joint without one holds its first measured angle.
        settings: Of the emulated robot: body, wear, engine, scenario, start and seed.
        progress: Told of each cycle.

    Raises:
        ConfigurationError: no such body, wear profile, scenario or start.
    """
    signals = recorded.signals
    frames: list[SensorFrame] = []
    with _robot(recorded, settings) as robot:
        rest = np.where(np.isfinite(signals.position[0]), signals.position[0], robot.frame.position)
        position = np.where(np.isfinite(signals.command), signals.command, rest)
        stiffness = np.where(np.isfinite(signals.stiffness), signals.stiffness, 1.0)
        commanded = np.any(np.isfinite(signals.command), axis=1)
        for k in range(len(signals.time)):
            frames.append(robot.frame)
            command = None
            if commanded[k]:
                command = ActuatorFrame(
                    reply_to=robot.seq, position=tuple(position[k]), stiffness=tuple(stiffness[k])
                )
            robot.advance(command)
            progress(k + 1)
    measured = {
        name: np.array([getattr(frame, name) for frame in frames]) for name in NAMES if name not in COMMANDS
    }
    return Signals(signals.time, signals.command, signals.stiffness, **measured, measured=signals.measured)


def _robot(recorded: RecordedSignals, settings: RunConfig) -> EmulatedRobot:
    as_recorded = recorded.whole and settings.start == recorded.config.get("start", settings.start)
    if as_recorded or not recorded.has_angles:
        return build_robot(settings, body=recorded.body)
    first = recorded.signals.position[0]
    posture = tuple(np.where(np.isfinite(first), first, 0.0))
    held = settings.start == HANG or (not settings.start and hangs(recorded.body, recorded.signals) is True)
    return EmulatedRobot(
        recorded.body,
        seed=settings.seed,
        posture=posture,
        engine=settings.engine,
        wear=load_wear(settings.wear, recorded.body),
        scenario=load_scenario(settings.scenario),
        start=STAND,
        held=held,
        lift=_CLEARANCE if held else 0.0,
    )
