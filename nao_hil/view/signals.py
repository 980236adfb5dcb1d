"""Signals that a chart can show, the charts shown at first, and the phases of a walk."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from math import degrees
from typing import Any, Final, NamedTuple

import numpy as np

from bridge.body.joints import JOINTS, LEGS
from bridge.messages.columns import COLUMNS
from bridge.messages.frames import ELEMENTS, SensorFrame
from bridge.types import Array
from nao_hil.analysis.diagnosis import Balance

BLUE, ORANGE, GREEN, RED, GREY = "#339af0", "#ff922b", "#40c057", "#fa5252", "#868e96"
PHASES: Final = {
    "DSL": "#495057",
    "DSR": "#495057",
    "SSL": "#1c7ed6",
    "SSR": "#e8590c",
    "start": "#2b8a3e",
    "stop": "#2b8a3e",
    "stand": "#343a40",
}
"""Phases of a walk and their colours."""


def _mm(metres: float | None) -> float | None:
    return None if metres is None else 1e3 * metres


QUANTITIES: Final = {"angle": "deg", "command": "deg", "current": "A", "temperature": "°C"}
"""Signals of each joint: quantity and unit."""
_CONVERTED: Final = {
    *("position", "stiffness", "current", "temperature"),
    *("accelerometer", "gyroscope", "angle"),
}
"""Fields of the sensor frame that other signals show; those of all others are signals as they are."""
_PLAIN: Final = [field for field in ELEMENTS if field not in _CONVERTED]
_BALANCE: Final[dict[str, tuple[str, Callable[[Balance], float | None]]]] = {
    "torso roll": ("deg", lambda b: degrees(b.cycle.sensors.angle[0])),
    "torso pitch": ("deg", lambda b: degrees(b.cycle.sensors.angle[1])),
    "force left foot": ("N", lambda b: sum(b.cycle.sensors.fsr[:4])),
    "force right foot": ("N", lambda b: sum(b.cycle.sensors.fsr[4:])),
    "ZMP margin planned": ("mm", lambda b: _mm(b.plan.margin if b.plan else None)),
    "ZMP margin by FSR": ("mm", lambda b: _mm(b.sensed.margin)),
    "ZMP margin true": ("mm", lambda b: _mm(b.true.margin if b.true else None)),
    "gyroscope roll": ("deg/s", lambda b: degrees(b.cycle.sensors.gyroscope[0])),
    "gyroscope pitch": ("deg/s", lambda b: degrees(b.cycle.sensors.gyroscope[1])),
    "gyroscope yaw": ("deg/s", lambda b: degrees(b.cycle.sensors.gyroscope[2])),
    "accelerometer x": ("m/s²", lambda b: b.cycle.sensors.accelerometer[0]),
    "accelerometer y": ("m/s²", lambda b: b.cycle.sensors.accelerometer[1]),
    "accelerometer z": ("m/s²", lambda b: b.cycle.sensors.accelerometer[2]),
    "height left foot planned": ("mm", lambda b: _mm(b.cycle.walk.left[2] if b.cycle.walk else None)),
    "height right foot planned": ("mm", lambda b: _mm(b.cycle.walk.right[2] if b.cycle.walk else None)),
    "largest leg current": ("A", lambda b: max(b.cycle.sensors.current[i] for i in LEGS)),
    "hottest motor": ("°C", lambda b: max(b.cycle.sensors.temperature)),
}
"""Signals of the whole robot: unit, and value; None: not known."""
SIGNALS: Final = (
    {"cycle late": "ms"}
    | {name: unit for name, (unit, _) in _BALANCE.items()}
    | {f"{field} {name}": COLUMNS[SensorFrame][field].unit for field in _PLAIN for name in ELEMENTS[field]}
    | {f"{q} {joint}": unit for joint in JOINTS for q, unit in QUANTITIES.items()}
)
"""Signal -> unit."""
MIN_PAUSE: Final = 500.0
"""A longer time from one frame to the next is a pause of the world, ms."""
LATENESS_WINDOW: Final = 10.0
"""Robot time over which the earliest frame counts as punctual, s."""


class Line(NamedTuple):
    """One curve: its signal, its name in the chart, its colour."""

    signal: str
    name: str
    colour: str


class Chart(NamedTuple):
    """One strip chart."""

    title: str
    lines: tuple[Line, ...]
    least: tuple[float, float]
    """Range that is always shown."""
    height: float
    """Pixels."""
    most: tuple[float | None, float | None] = (None, None)
    """Range that is never left."""

    def to_json(self) -> dict[str, Any]:
        """The chart as the page's script takes it."""
        return {**self._asdict(), "lines": [line._asdict() for line in self.lines]}


def _pair(signal: str) -> tuple[Line, Line]:
    return Line(signal.format("left"), "left", BLUE), Line(signal.format("right"), "right", ORANGE)


_UNKNOWN: Final = [math.nan] * len(JOINTS)
CHARTS: Final = (
    Chart(
        "torso angle, deg",
        (Line("torso pitch", "pitch", BLUE), Line("torso roll", "roll", ORANGE)),
        (-5.0, 5.0),
        74.0,
        (-30.0, 30.0),
    ),
    Chart("vertical force on each foot, N", _pair("force {} foot"), (0.0, 55.0), 62.0, (0.0, 120.0)),
    Chart(
        "ZMP to the edge, mm",
        (
            Line("ZMP margin planned", "planned", BLUE),
            Line("ZMP margin by FSR", "by FSR", ORANGE),
            Line("ZMP margin true", "true", GREEN),
        ),
        (-10.0, 80.0),
        80.0,
        (-40.0, 120.0),
    ),
    Chart("cycle late, ms", (Line("cycle late", "late", BLUE),), (0.0, 2.0), 40.0),
    Chart(
        "gyroscope, deg/s",
        (
            Line("gyroscope roll", "roll", ORANGE),
            Line("gyroscope pitch", "pitch", BLUE),
            Line("gyroscope yaw", "yaw", GREEN),
        ),
        (-60.0, 60.0),
        62.0,
        (-240.0, 240.0),
    ),
    Chart("planned height of each foot, mm", _pair("height {} foot planned"), (0.0, 20.0), 54.0, (-10.0, 60.0)),
)
"""The charts shown at first; any signal can be added."""


def signal_values(balance: Balance, late: float = math.nan) -> Array:
    """Values of `SIGNALS` in a cycle, in their order; NaN where a value is not known.

    Args:
        balance: In the cycle.
        late: Its lateness, ms.
    """
    frame, asked = balance.cycle.sensors, balance.cycle.asked
    values = (value(balance) for _, value in _BALANCE.values())
    command = asked.position if asked is not None else _UNKNOWN
    joints = np.array([np.degrees(frame.position), np.degrees(command), frame.current, frame.temperature])
    return np.concatenate(
        [
            [late, *(math.nan if value is None else value for value in values)],
            *(getattr(frame, field) for field in _PLAIN),
            joints.T.ravel(),
        ]
    )


class Lateness:
    """Lateness of each frame against the most punctual one of the last seconds; a pause is no lateness."""

    def __init__(self) -> None:
        self._recent: deque[tuple[float, float]] = deque()
        self._last, self._paused = math.nan, 0.0

    def update(self, time: float, wall: int) -> float:
        """Lateness of the next frame, ms.

        Args:
            time: Robot time, s.
            wall: Wall clock at sending, ns; 0: not known.
        """
        if not wall:
            return math.nan
        behind = 1e-6 * wall - 1e3 * time
        if abs(behind - self._last) > MIN_PAUSE:
            self._paused += behind - self._last
        self._last = behind
        now = behind - self._paused
        while self._recent and (self._recent[-1][1] >= now or self._recent[-1][0] > time):
            self._recent.pop()
        self._recent.append((time, now))
        while self._recent[0][0] < time - LATENESS_WINDOW:
            self._recent.popleft()
        return now - self._recent[0][1]
