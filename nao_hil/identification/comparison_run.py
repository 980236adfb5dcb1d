"""From a recording to its comparison with an emulated robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import msgspec
import numpy as np

from bridge.messages import ActuatorFrame, SensorFrame
from emulator.robot import EmulatedRobot
from emulator.scenarios import load_scenario
from emulator.start import STAND
from emulator.wear import load_wear
from nao_hil.identification.comparison import Comparison, JointComparison, SensorComparison, compare
from nao_hil.identification.readings import COMMANDS, NAMES, Signals, hangs
from nao_hil.identification.recorded import RecordedSignals
from nao_hil.identification.sensors_only import at_rest, compare_fused_angle, follow_angles
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig

HANG: Final = "hang"
_CLEARANCE: Final = 0.1
"""Height of a hanging robot's soles over the floor, m."""


def replay(
    recorded: RecordedSignals, settings: RunConfig, progress: Callable[[int], None] = lambda _: None
) -> Signals:
    """Run the emulated robot under the recorded commands, open loop.

    It begins in the start that the recording names, else at rest in the first measured
    posture, hanging by the settings or where its feet carry nothing; without angles, by the settings.

    Args:
        recorded: Commands; a joint without one holds its first measured angle.
        settings: Of the emulated robot: body, wear, engine, scenario, start and seed.
        progress: Called with each cycle.

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


_READ = ("robot", "wear", "engine", "scenario", "start", "seed")
"""Fields of a configuration that a replay reads."""
_LYING = 1.0
"""Roll or pitch from which on a torso lies, rad."""
_NO_COMMANDS = (
    "No commands were recorded: the emulated robot follows the recorded angles, and only sensors are compared."
)
_AT_REST = (
    "No commands and no angles were recorded: sensors are compared with an emulated robot at rest, from "
    "{0:.2f} s to {1:.2f} s, where the torso does not move; their means depend on the unknown posture."
)
_NEVER_AT_REST = (
    "No commands and no angles were recorded, and the torso never rests for two seconds: gyroscope, "
    "accelerometer and force cells cannot be compared."
)


def compare_recording(
    recorded: RecordedSignals,
    name: str,
    settings: RunConfig,
    progress: Callable[[float], None] = lambda _: None,
) -> tuple[Comparison, Signals]:
    """Replay a recording with two seeds, and measure.

    Without commands the robot follows the recorded angles. Without angles, too, it rests, and the part of the
    recording in which the torso rests is compared; if there is none, only the fused angle is.

    Args:
        recorded: The recording.
        name: Of its file, for the result.
        settings: The emulated robot; the noise floor's replay has the next seed.
        progress: Called with the share that is done.

    Returns:
        The numbers, and the first replay.

    Raises:
        ConfigurationError: no such body, wear profile, scenario or start.
    """
    recorded, source, note = _comparable(recorded)
    joints: tuple[JointComparison, ...] = ()
    sensors: tuple[SensorComparison, ...] = ()
    first = recorded.signals
    if source is not None:
        half = 0.5 / len(first.time)
        first = replay(source, settings, lambda done: progress(half * done))
        other = msgspec.structs.replace(settings, seed=settings.seed + 1)
        second = replay(source, other, lambda done: progress(0.5 + half * done))
        joints, sensors = compare(recorded.body, recorded.signals, first, second)
        note = (*note, *_fall(recorded.signals, first))
    parameters = load_wear(settings.wear, recorded.body).sensors.fused_angle
    result = Comparison(
        recording=name,
        config={key: getattr(settings, key) for key in _READ},
        notes=(*recorded.notes, *note),
        seconds=float(recorded.signals.time[-1]),
        first=joints[0].joint if joints and joints[0].excess > 0.0 else "",
        joints=joints,
        sensors=sensors,
        fused_angle=compare_fused_angle(recorded.sensors, parameters),
        encoder_grid=recorded.encoder_grid,
    )
    return result, first


def _fall(recorded: Signals, replayed: Signals) -> tuple[str, ...]:
    """A sentence if the emulated robot lies where the recorded one is not known to."""
    lies, lay = (np.abs(signals.angle).max(axis=1) > _LYING for signals in (replayed, recorded))
    rows = np.flatnonzero(lies & ~lay)
    if not len(rows):
        return ()
    begin = replayed.time[rows[0]]
    return (f"The emulated robot fell before {begin:.2f} s; compare the time before with --to.",)


def _comparable(recorded: RecordedSignals) -> tuple[RecordedSignals, RecordedSignals | None, tuple[str, ...]]:
    """Signals to measure, signals to replay (None: none), and a sentence on changes of the recording."""
    if recorded.commanded:
        return recorded, recorded, ()
    if recorded.has_angles:
        return recorded, follow_angles(recorded), (_NO_COMMANDS,)
    rows = at_rest(recorded.signals)
    if rows is None:
        return recorded, None, (_NEVER_AT_REST,)
    begin, end = recorded.signals.time[rows][[0, -1]]
    resting = replace(recorded, signals=recorded.signals.part(rows))
    return resting, resting, (_AT_REST.format(begin, end),)
