"""Sensor values that cannot be read: the last ones in their place, for a bounded time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import msgspec

from bridge.guard.config import SensorSettings
from bridge.messages import SensorFrame
from bridge.messages.frames import ELEMENTS

_NEVER_READ: Final = {"accelerometer": (0.0, 0.0, 9.81), "battery": (1.0, 0.0, 0.0, 0.0)}
"""In place of a field that has never been read, zeros but for these, which report neither a fall nor an empty
battery."""
_POSE: Final = frozenset({"position", "stiffness", "angle"})
"""Fields without which the guard cannot judge how the robot stands."""


@dataclass
class _Fault:
    """A field that cannot be read, until it is readable again."""

    unread: int = 0
    """Cycles without a reading up to now."""
    read: int = 0
    """Cycles with a reading up to now."""
    lost: bool = False
    """Its last reading was too old."""


class SensorMonitor:
    """Replaces the numbers of a frame that are not finite by the last good ones, and reports it once.

    Args:
        settings: time for which a last value counts.
    """

    def __init__(self, settings: SensorSettings) -> None:
        self._limit = settings.unreadable_cycles
        self._last: SensorFrame | None = None
        self._never_read = set(ELEMENTS)
        self._faults: dict[str, _Fault] = {}
        self._reports: list[tuple[str, str]] = []

    @property
    def lost(self) -> bool:
        """A field was unreadable for too long, and has not been readable again for as long."""
        return any(fault.lost for fault in self._faults.values())

    @property
    def pose_known(self) -> bool:
        """Joints, stiffnesses and fused angle have been read at least once."""
        return not self._never_read & _POSE

    def take_reports(self) -> list[tuple[str, str]]:
        """Code and sentence of each notice since the last call."""
        reports, self._reports = self._reports, []
        return reports

    def update(self, frame: SensorFrame) -> SensorFrame:
        """One cycle.

        Args:
            frame: as read; an unreadable number is NaN.

        Returns:
            The frame with finite numbers only.
        """
        unread = {field: bad for field in ELEMENTS if (bad := _unreadable(getattr(frame, field)))}
        self._never_read &= unread.keys()
        if unread or self._faults:
            frame = msgspec.structs.replace(
                frame, **{f: self._filled(frame, f, bad) for f, bad in unread.items()}
            )
            self._count(unread)
        self._last = frame
        return frame

    def _filled(self, frame: SensorFrame, field: str, bad: Sequence[int]) -> tuple[float, ...]:
        values = list(getattr(frame, field))
        zeros = (0.0,) * len(ELEMENTS[field])
        last = getattr(self._last, field) if self._last is not None else _NEVER_READ.get(field, zeros)
        for slot in bad:
            values[slot] = last[slot]
        return tuple(values)

    def _count(self, unread: dict[str, list[int]]) -> None:
        for field, bad in unread.items():
            if field not in self._faults:
                self._faults[field] = _Fault()
                self._reports.append(("sensor-unreadable", self._sentence(field, bad)))
            fault = self._faults[field]
            fault.unread, fault.read = fault.unread + 1, 0
            fault.lost = fault.lost or fault.unread >= self._limit or field in self._never_read
        for field in self._faults.keys() - unread.keys():
            fault = self._faults[field]
            fault.unread, fault.read = 0, fault.read + 1
            if fault.read >= self._limit:
                del self._faults[field]
                self._reports.append(("sensor-readable", f"`{field}` is readable again."))

    def _sentence(self, field: str, bad: Sequence[int]) -> str:
        more = f" and {len(bad) - 1} more" if len(bad) > 1 else ""
        return (
            f"`{field}.{ELEMENTS[field][bad[0]]}`{more} cannot be read; the last value counts for "
            f"{self._limit} cycles, then the robot goes down."
        )


def _unreadable(values: Sequence[float]) -> list[int]:
    """Indices of the numbers that are not finite."""
    if math.isfinite(sum(values)):
        return []
    return [slot for slot, value in enumerate(values) if not math.isfinite(value)]
