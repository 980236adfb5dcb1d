"""Faults between the sensors and the frame: stuck, dead, noisy, offset, without power."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import msgspec
import numpy as np

from bridge.body.joints import INDEX, N_JOINTS
from bridge.messages import SensorFrame
from bridge.messages.elements import sensor_slots
from bridge.messages.faults import (
    HalError,
    JointLimp,
    PowerLoss,
    SensorDead,
    SensorNoisy,
    SensorOffset,
    SensorStuck,
)

FrameFault = SensorStuck | SensorDead | SensorNoisy | SensorOffset | JointLimp | HalError | PowerLoss


class FrameFaults:
    """Spoils sensor frames.

    Args:
        random: of the noise.
    """

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random
        self._held: dict[str, tuple[float, ...]] = {}
        """Values that a stuck sensor repeats, by fault."""

    def forget(self, name: str) -> None:
        """A fault has ended, or restarts."""
        self._held.pop(name, None)

    def spoil(self, frame: SensorFrame, faults: Iterable[FrameFault]) -> SensorFrame:
        """The frame as a controller gets to see it."""
        for fault in faults:
            frame = msgspec.structs.replace(frame, **self._changes(frame, fault))
        return frame

    def _changes(self, frame: SensorFrame, fault: FrameFault) -> dict[str, Any]:
        if isinstance(fault, JointLimp):
            slot = INDEX[fault.joint]
            return {
                field: (*values[:slot], 0.0, *values[slot + 1 :])
                for field, values in (("stiffness", frame.stiffness), ("current", frame.current))
            }
        if isinstance(fault, HalError | PowerLoss):
            none = (0.0,) * N_JOINTS
            off = {} if isinstance(fault, HalError) else {"battery": (0.0, 0.0, *frame.battery[2:])}
            return {"stiffness": none, "current": none, **off}
        field, slots = sensor_slots(fault.sensor)
        values = list(getattr(frame, field))
        for i, value in zip(slots, self._values(fault, [values[i] for i in slots]), strict=True):
            values[i] = value
        return {field: tuple(values)}

    def _values(
        self, fault: SensorStuck | SensorDead | SensorNoisy | SensorOffset, values: list[float]
    ) -> Iterable[float]:
        if isinstance(fault, SensorStuck):
            return self._held.setdefault(fault.name, tuple(values))
        if isinstance(fault, SensorDead):
            return [0.0] * len(values)
        if isinstance(fault, SensorOffset):
            return [value + fault.offset for value in values]
        noise: list[float] = self._random.normal(0.0, fault.deviation, len(values)).tolist()
        return [value + error for value, error in zip(values, noise, strict=True)]
