"""Summary of a recording."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import Any

import msgspec

from bridge.body import fall
from bridge.errors import ConfigurationError
from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame, WalkTelemetry
from bridge.recording.canonical import RECORDED, FrameHash
from bridge.recording.playback import read_recording, recorded_config, recording_end
from bridge.rotations import tilt
from nao_hil.analysis.diagnosis import diagnose
from nao_hil.runs.walk_figures import FallWatch


class Contents(msgspec.Struct, frozen=True, kw_only=True):
    """Of one recording; the JSON of `nao-hil info`."""

    file: str
    complete: bool
    """False: its writer was killed; it reads up to its last whole chunk."""
    after: int
    """Bytes behind its end, which are not read: of a second file joined to it, for example."""
    config: Any
    """Of the run; None when the recording has none."""
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
    """Of each code."""
    steps: int
    """In all walks, by the walker's word."""
    fell: bool | None
    """By the ground truth; None without it. A robot that began lying, or went down by order, has not fallen."""
    distance: float | None
    """Of the torso over ground, to the fall if it fell, m; None without ground truth."""
    torso_max: float
    """Largest tilt of the torso, rad: by the ground truth, or the robot's fused angle."""
    frames_sha256: str
    diagnosis: str | None
    """First event of the fall, in a sentence; None for a robot that did not fall, or of an unknown body."""
    fall_cause: str
    """Why its walker took the robot for falling, the last time; empty: never."""


class _Sum:
    def __init__(self) -> None:
        self.messages = dict.fromkeys(RECORDED.values(), 0)
        self.notices: Counter[str] = Counter()
        self.hash = FrameHash()
        self.frames: tuple[SensorFrame, SensorFrame] | None = None
        self.truth: tuple[TruthFrame, TruthFrame] | None = None
        self.fell = False
        self._watch = FallWatch()
        self.tilt = self.fused = 0.0
        self.steps = self._step = 0
        self.fall_cause = ""

    def take(self, topic: str, message: Any) -> None:
        """Take in the next message, which came on a topic of `bridge.recording.canonical.RECORDED`."""
        self.messages[topic] += 1
        if isinstance(message, SensorFrame):
            self.hash.add(message)
            self.frames = (self.frames[0] if self.frames else message, message)
            self.fused = max(self.fused, fall.tilt(message.angle))
        elif isinstance(message, ActuatorFrame):
            self.hash.add(message)
        elif isinstance(message, TruthFrame):
            if not self.fell:
                self.truth = (self.truth[0] if self.truth else message, message)
            self.fell |= self._watch.update(down=message.fell)
            self.tilt = max(self.tilt, float(tilt(message.torso_orientation)))
        elif isinstance(message, WalkTelemetry):
            if self.frames and message.seq > self.frames[1].seq:
                return  # of the robot before it restarted
            self.steps += message.step - self._step if message.step > self._step else 0
            self._step = message.step
            self.fall_cause = message.fall_cause or self.fall_cause
            self._watch.telemetry(message)
        elif isinstance(message, Notice):
            self.notices[message.code] += 1
            self._watch.notice(message)


def inspect(path: Path) -> Contents:
    """Read a recording from end to end.

    Raises:
        ConfigurationError: no such file, not a recording, or a damaged one.
    """
    found = _Sum()
    for topic, _, message in read_recording(path):
        found.take(topic, message)
    first, last = found.frames or (None, None)
    ending = recording_end(path)
    cycles = found.messages["sensors"]
    return Contents(
        file=str(path),
        complete=ending.complete,
        after=ending.after,
        config=recorded_config(path),
        begin=first.time if first else 0.0,
        end=last.time if last else 0.0,
        cycles=cycles,
        gaps=last.seq - first.seq + 1 - cycles if first and last else 0,
        cycles_missed=last.missed - first.missed if first and last else 0,
        messages=found.messages,
        notices=dict(sorted(found.notices.items())),
        steps=found.steps,
        fell=found.fell if found.truth else None,
        distance=_way(found.truth) if found.truth else None,
        torso_max=found.tilt if found.truth else found.fused,
        frames_sha256=found.hash.hexdigest(),
        diagnosis=_diagnosis(path)
        if found.fell or (not found.truth and fall.has_fallen(found.fused))
        else None,
        fall_cause=found.fall_cause,
    )


def _diagnosis(path: Path) -> str | None:
    try:
        diagnosis = diagnose(path)
    except ConfigurationError:
        return None
    return diagnosis.sentence if diagnosis is not None else None


def _way(ends: tuple[TruthFrame, TruthFrame]) -> float:
    return math.dist(ends[0].torso_position[:2], ends[1].torso_position[:2])
