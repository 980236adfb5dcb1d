"""Heading by the gyroscope: its rate about the vertical, less the bias it has at rest.

On both feet no joint but HipYawPitch turns the torso about the vertical: the bias is found while the robot gets
into its first posture, too.
"""

from __future__ import annotations

import math
from typing import Final

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.messages import SensorFrame

_STILL: Final = 0.1
"""Largest rate about the vertical of a torso that does not turn, rad/s: the gyroscope's bias (three deviations
of the largest that the ensemble has), and its noise."""
_MOVED: Final = 0.004
"""Largest motion of HipYawPitch then, rad: three counts of its encoder."""
_SHARE: Final = 0.2
"""Least load of the one foot over that of the other, of a robot on both."""
_REST: Final = 0.2
"""s of rest before the bias is believed."""
_MEAN: Final = 5.0
"""s over which the bias is averaged, at most."""
_HIP_YAW: Final = INDEX["LHipYawPitch"]


class GyroscopeHeading:
    """Sums up the yaw rate; the robot rests while it is on both feet, or none, and nothing turns it.

    Args:
        body: must have a gyroscope of three axes.
    """

    def __init__(self, body: Body) -> None:
        assert body.inertial_unit.gyroscope_axes == 3
        self._bias = self._heading = self._rested = self._averaged = self._hip_yaw = 0.0
        self._last: SensorFrame | None = None

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
            return self._heading
        dt = frame.time - last.time
        roll, pitch = frame.angle
        _, q, r = frame.gyroscope
        rate = (math.sin(roll) * q + math.cos(roll) * r) / math.cos(pitch)
        self._rest(frame, rate, dt)
        self._heading += (rate - self._bias) * dt
        return self._heading

    def _rest(self, frame: SensorFrame, rate: float, dt: float) -> None:
        hip_yaw, loads = frame.position[_HIP_YAW], (sum(frame.fsr[:4]), sum(frame.fsr[4:]))
        if abs(hip_yaw - self._hip_yaw) > _MOVED or abs(rate) > _STILL or min(loads) < _SHARE * max(loads):
            self._rested, self._hip_yaw = 0.0, hip_yaw
            return
        self._rested += dt
        if self._rested > _REST:
            self._averaged = min(self._averaged + dt, _MEAN)
            self._bias += dt / self._averaged * (rate - self._bias)
