"""From a recording to its comparison with an emulated robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import msgspec
import numpy as np

from emulator.wear import load_wear
from nao_hil.identification.comparison import Comparison, JointComparison, SensorComparison, compare
from nao_hil.identification.readings import Signals
from nao_hil.identification.recorded import RecordedSignals
from nao_hil.identification.replay import replay
from nao_hil.identification.sensors_only import at_rest, compare_fused_angle, follow_angles
from nao_hil.runs.config import RunConfig

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
        progress: Told of the share that is done.

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
        fused_angle=compare_fused_angle(recorded.readings, parameters),
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
    """Signals to measure, signals to replay (None: none), and a sentence if the recording was changed."""
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
