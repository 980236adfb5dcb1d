"""A recording as arrays, one row per message."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from bridge.body import Body
from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame, WalkTelemetry
from bridge.recording.playback import read_recording
from bridge.rotations import R_yaw, yaw
from bridge.types import Array

SINGLE: Final = ("SSL", "SSR")
"""Phases of single support."""


@dataclass(frozen=True)
class Tables:
    """Messages of a recording, each kind with its times; empty where there are none."""

    body: Body
    sensors: Sequence[SensorFrame]
    truth: Sequence[TruthFrame]
    telemetry: Sequence[WalkTelemetry]
    actuators: Sequence[ActuatorFrame]
    notices: Sequence[tuple[float, Notice]]

    @property
    def time(self) -> Array:
        """Of the sensor frames, s, shape (n,)."""
        return column(self.sensors, "time")

    @property
    def truth_time(self) -> Array:
        """Of the ground truth, s, shape (n,)."""
        return column(self.truth, "time")

    def time_of(self, seqs: Sequence[int]) -> Array:
        """Robot time of cycles, s, shape (n,)."""
        return np.array(seqs, dtype=np.float64) * self.body.cycle

    @property
    def telemetry_time(self) -> Array:
        """Of the telemetry, s, shape (n,)."""
        return self.time_of([message.seq for message in self.telemetry])

    @property
    def fell(self) -> float | None:
        """When the robot had fallen by the ground truth, s."""
        return next((frame.time for frame in self.truth if frame.fell), None)

    @property
    def before_fall(self) -> Sequence[TruthFrame]:
        """The ground truth of a robot that has not fallen yet."""
        return list(itertools.takewhile(lambda frame: not frame.fell, self.truth))

    @property
    def events(self) -> list[float]:
        """Times of events in the robot and its world, s."""
        return [when for when, notice in self.notices if notice.level == "info" and not notice.routine]

    def phases(self) -> list[tuple[str, float, float]]:
        """Phase of the plan, its begin and its end, s."""
        found: list[tuple[str, float, float]] = []
        for when, message in zip(self.telemetry_time, self.telemetry, strict=True):
            if found and found[-1][0] == message.phase:
                found[-1] = (message.phase, found[-1][1], float(when) + self.body.cycle)
            else:
                found.append((message.phase, float(when), float(when) + self.body.cycle))
        return found

    def walk_frame(self) -> tuple[Array, float]:
        """Origin (world x and y, m) and heading (rad) of the walk frame.

        At the walker's first word the planned centre of mass is taken for the true one, the torso's heading
        for the walk's.
        """
        if not (self.telemetry and self.truth):
            return np.zeros(2), 0.0
        seqs = [frame.seq for frame in self.truth]
        first = self.truth[min(int(np.searchsorted(seqs, self.telemetry[0].seq)), len(seqs) - 1)]
        heading = float(yaw(first.torso_orientation))
        planned = np.array(self.telemetry[0].com)
        return np.array(first.com[:2]) - R_yaw(heading)[:2, :2] @ planned, heading

    def to_walk_frame(self, points: Array) -> Array:
        """World x and y to the walk frame, shape (n, 2), m."""
        origin, heading = self.walk_frame()
        return np.asarray((points - origin) @ R_yaw(heading)[:2, :2], dtype=np.float64)


def load(path: Path, body: Body, begin: float = 0.0, end: float = math.inf) -> Tables:
    """Read a stretch of a recording.

    Raises:
        ConfigurationError: as `bridge.recording.playback.read_recording`.
    """
    kinds: dict[type[Any], list[Any]] = defaultdict(list)
    for _, when, message in read_recording(path):
        if begin <= when <= end:
            kinds[type(message)].append((when, message) if isinstance(message, Notice) else message)
    return Tables(
        body,
        kinds[SensorFrame],
        kinds[TruthFrame],
        kinds[WalkTelemetry],
        kinds[ActuatorFrame],
        kinds[Notice],
    )


def column(messages: Sequence[Any], field: str, width: int = 0) -> Array:
    """One field of all messages, shape (n,) or (n, width); NaN where it is None."""
    rows = [getattr(message, field) for message in messages]
    if not width:
        return np.array(rows, dtype=np.float64)
    blank = (math.nan,) * width
    return np.array([blank if row is None else row for row in rows], dtype=np.float64).reshape(-1, width)
