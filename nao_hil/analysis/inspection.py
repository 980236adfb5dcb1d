"""Summary of a recording."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import msgspec

from bridge.body import fall
from bridge.errors import ConfigurationError
from bridge.messages import Notice, SensorFrame, WalkTelemetry
from bridge.recording.playback import recording_end
from nao_hil.analysis.diagnosis import diagnose
from nao_hil.runs.run import Run, load
from nao_hil.runs.summary import RunStatistics


class Contents(msgspec.Struct, frozen=True, kw_only=True):
    """Contents of one recording; the JSON of `nao-hil info`."""

    file: str
    complete: bool
    """False: its writer was killed; it reads up to its last whole chunk."""
    after: int
    """Bytes behind its end, which are not read: of a second file joined to it, for example."""
    config: Any
    """Configuration of the run; None when the recording has none."""
    begin: float
    """Robot time of the first sensor frame, s."""
    end: float
    """And of the last, s."""
    cycles: int
    """Sensor frames."""
    gaps: int
    """Cycles between the first and the last frame that are missing."""
    cycles_missed: int
    """Cycles in which the controller did not answer in time, by the robot's count."""
    messages: dict[str, int]
    """On each topic."""
    notices: dict[str, int]
    """Number of notices of each code."""
    steps: int
    """In all walks, by the walker's word."""
    fell: bool | None
    """By the ground truth; None without it. A robot that began lying, or went down by order, has not fallen."""
    distance: float | None
    """Distance of the torso over ground, to the fall if it fell, m; None without ground truth."""
    torso_max: float
    """Largest tilt of the torso, rad: by the ground truth, or the robot's fused angle."""
    frames_sha256: str
    diagnosis: str | None
    """First event of the fall, in a sentence; None for a robot that did not fall, or of an unknown body."""
    fall_cause: str
    """Why its walker took the robot for falling, the last time; empty: never."""


def inspect(path: Path) -> Contents:
    """Read a recording from end to end.

    Raises:
        ConfigurationError: no such file, not a recording, or a damaged one.
    """
    run, statistics = load(path), RunStatistics(0, "")
    messages = dict.fromkeys(run, 0)
    notices: Counter[str] = Counter()
    frames: list[SensorFrame] = []
    fused, fall_cause = 0.0, ""
    for topic, _, message in run.messages():
        messages[topic] += 1
        statistics.take(message)
        if isinstance(message, SensorFrame):
            frames[1:] = [message]
            fused = max(fused, fall.tilt(message.angle))
        elif isinstance(message, WalkTelemetry) and statistics.is_current(message):
            fall_cause = message.fall_cause or fall_cause
        elif isinstance(message, Notice):
            notices[message.code] += 1
    first, last = (frames[0], frames[-1]) if frames else (None, None)
    summary, ending, truth = statistics.summary(0.0), recording_end(path), messages["world/truth"] > 0
    return Contents(
        file=str(path),
        complete=ending.complete,
        after=ending.after,
        config=run.config or None,
        begin=first.time if first else 0.0,
        end=last.time if last else 0.0,
        cycles=messages["sensors"],
        gaps=last.seq - first.seq + 1 - messages["sensors"] if first and last else 0,
        cycles_missed=last.missed - first.missed if first and last else 0,
        messages=messages,
        notices=dict(sorted(notices.items())),
        steps=summary.steps,
        fell=summary.fell if truth else None,
        distance=summary.distance if truth else None,
        torso_max=summary.torso_max if truth else fused,
        frames_sha256=summary.frames_sha256,
        diagnosis=_diagnosis(run) if summary.fell or (not truth and fall.has_fallen(fused)) else None,
        fall_cause=fall_cause,
    )


def _diagnosis(run: Run) -> str | None:
    try:
        diagnosis = diagnose(run)
    except ConfigurationError:
        return None
    return diagnosis.sentence if diagnosis is not None else None
