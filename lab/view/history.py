"""The numbers that the charts show, cycle by cycle."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from lab.diagnosis import Balance
from lab.view.looks import Floats

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
    "missed",
)
"""s, deg, deg, N, N, mm, mm, mm, ms, cycles since the start."""


class History:
    """A ring of rows, one per sensor frame, and the phase of the walk in each.

    Args:
        size: Rows that are kept.
    """

    def __init__(self, size: int) -> None:
        self._rows = np.full((size, len(COLUMNS)), math.nan)
        self._phases = [""] * size
        self._count = 0
        self._earliest: float | None = None

    def add(self, balance: Balance) -> None:
        """A moment; an earlier one than the last begins anew."""
        frame, walk = balance.moment.sensors, balance.moment.walk
        if self._count and frame.time <= self._rows[(self._count - 1) % len(self._rows), 0]:
            self._count, self._earliest = 0, None
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
            self._lateness(frame.time, frame.wall),
            frame.missed,
        )
        self._phases[i] = walk.phase if walk is not None else ""
        self._count += 1

    def _lateness(self, time: float, wall: int) -> float:
        """How much later than its clock the robot sent a frame, against its earliest one, ms."""
        if wall == 0:
            return math.nan  # a recording
        behind = 1e-9 * wall - time
        if self._earliest is None or behind < self._earliest:
            self._earliest = behind
        return 1e3 * (behind - self._earliest)

    def window(self, end: float, seconds: float) -> tuple[Floats, list[str]]:
        """Rows from `end - seconds` to `end`, oldest first, shape (n, columns), and their phases."""
        kept = min(self._count, len(self._rows))
        order = np.arange(self._count - kept, self._count) % len(self._rows)
        times = self._rows[order, 0]
        order = order[(times >= end - seconds) & (times <= end)]
        return self._rows[order], [self._phases[i] for i in order]


def _mm(metres: float | None) -> float:
    return math.nan if metres is None else 1e3 * metres
