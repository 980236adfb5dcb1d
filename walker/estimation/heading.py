"""Heading by the gyroscope: its rate about the vertical, less the bias it has at rest."""

from __future__ import annotations

import math
from typing import Final

from bridge.body import Body
from bridge.messages import SensorFrame

_STILL: Final = 0.02
"""Largest rate about any axis of a torso at rest, rad/s: a few times the gyroscope's noise."""
_MOVED: Final = 0.004
"""Largest motion of a joint at rest, rad: three counts of its encoder."""
_REST: Final = 0.2
"""s of rest before the bias is believed."""
_MEAN: Final = 1.0
"""s over which the bias is averaged."""


class GyroscopeHeading:
    """Sums up the yaw rate; the robot rests while neither its joints nor its torso move.

    Args:
        body: must have a gyroscope of three axes.
    """

    def __init__(self, body: Body) -> None:
        assert body.inertial_unit.gyroscope_axes == 3
        self._bias = self._heading = self._rested = 0.0
        self._last: SensorFrame | None = None
        self._pose: tuple[float, ...] = ()

    @staticmethod
    def of(body: Body) -> GyroscopeHeading | None:
        """Of a body whose gyroscope has a vertical axis; None: it has none."""
        return GyroscopeHeading(body) if body.inertial_unit.gyroscope_axes == 3 else None

    def update(self, frame: SensorFrame) -> float:
        """Heading since the first frame, rad.

        Args:
            frame: newest sensor frame.
        """
        last, self._last = self._last, frame
        if last is None:
            self._pose = frame.position
            return self._heading
        dt = frame.time - last.time
        roll, pitch = frame.angle
        _, q, r = frame.gyroscope
        rate = (math.sin(roll) * q + math.cos(roll) * r) / math.cos(pitch)
        self._rest(frame, rate, dt)
        self._heading += (rate - self._bias) * dt
        return self._heading

    def _rest(self, frame: SensorFrame, rate: float, dt: float) -> None:
        moved = max(abs(a - b) for a, b in zip(frame.position, self._pose, strict=True))
        if moved > _MOVED or max(map(abs, frame.gyroscope)) > _STILL:
            self._rested, self._pose = 0.0, frame.position
            return
        self._rested += dt
        if self._rested > _REST:
            self._bias += min(dt / _MEAN, 1.0) * (rate - self._bias)
