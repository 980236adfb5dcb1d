"""The numbers that the charts show, cycle by cycle."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from bridge.body.joints import JOINTS
from nao_hil.analysis.diagnosis import Balance
from nao_hil.view.looks import Floats

LEGS: Final = [i for i, name in enumerate(JOINTS) if "Hip" in name or "Knee" in name or "Ankle" in name]
COLUMNS: Final = (
    "time",
    "roll",
    "pitch",
    "left",
    "right",
    "margin_plan",
    "margin_fsr",
    "margin_true",
    "late",
    "rate_roll",
    "rate_pitch",
    "rate_yaw",
    "lift_left",
    "lift_right",
    "current",
    "heat",
)
"""s, deg, deg, N, N, mm, mm, mm, ms, deg/s, deg/s, deg/s, mm, mm, A, °C."""

PAUSE: Final = 500.0
"""A longer time from one frame to the next was a pause of the world, ms."""


class History:
    """A ring of rows, one per sensor frame, and the phase of the walk in each.

    Args:
        size: Rows that are kept.
    """

    def __init__(self, size: int) -> None:
        self._rows = np.full((size, len(COLUMNS)), math.nan)
        self._phases = [""] * size
        self._count = 0

    def add(self, balance: Balance) -> None:
        """A moment; an earlier one than the last begins anew."""
        frame, walk = balance.moment.sensors, balance.moment.walk
        if self._count and frame.time <= self._rows[(self._count - 1) % len(self._rows), 0]:
            self._count = 0
        i = self._count % len(self._rows)
        self._rows[i] = (
            frame.time,
            math.degrees(frame.angle[0]),
            math.degrees(frame.angle[1]),
            sum(frame.fsr[:4]),
            sum(frame.fsr[4:]),
            _mm(balance.plan.margin if balance.plan else None),
            _mm(balance.sensed.margin),
            _mm(balance.true.margin if balance.true else None),
            1e-6 * frame.wall - 1e3 * frame.time if frame.wall else math.nan,  # recordings have no wall clock
            *(math.degrees(rate) for rate in frame.gyroscope),
            _mm(walk.left[2] if walk is not None else None),
            _mm(walk.right[2] if walk is not None else None),
            max(frame.current[i] for i in LEGS),
            max(frame.temperature),
        )
        self._phases[i] = walk.phase if walk is not None else ""
        self._count += 1

    def window(self, end: float, seconds: float) -> tuple[Floats, list[str]]:
        """Rows from `end - seconds` to `end`, oldest first, shape (n, columns), and their phases.

        A frame is late against the earliest one of the window: after a stall the robot goes on in the present.
        A pause of the world is no lateness.
        """
        kept = min(self._count, len(self._rows))
        order = np.arange(self._count - kept, self._count) % len(self._rows)
        times = self._rows[order, 0]
        order = order[(times >= end - seconds) & (times <= end)]
        rows = self._rows[order]
        late = rows[:, COLUMNS.index("late")]
        if np.isfinite(late).any():
            steps = np.diff(late)
            late[1:] -= np.cumsum(np.where(np.abs(steps) > PAUSE, steps, 0.0))
            late -= np.nanmin(late)
        return rows, [self._phases[i] for i in order]


def _mm(metres: float | None) -> float:
    return math.nan if metres is None else 1e3 * metres
