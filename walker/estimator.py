"""The estimator of the robot's state: sensor frames in, `BaseState` out; the one file to replace for another.

Another estimator, such as a Kalman filter, has the constructor, the two methods and the attribute `state` of
`Estimator` (docs/how-to/replace-the-estimator.md).
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bridge.body.joints import N_JOINTS
from bridge.body.kinematics import FloatingBase
from bridge.messages import SensorFrame
from walker.estimation.attitude import Attitude, Lean
from walker.estimation.com import ComEstimator
from walker.estimation.odometry import GyroscopeHeading, Odometry, middle_of_soles
from walker.estimation.state import BaseState
from walker.functions import SmoothedRate
from walker.parameters import ControllerParameters

VELOCITY_TIME: Final = 0.1
"""Time constant of the torso's velocity by the odometry, s."""


class Estimator:
    """Sensor frames in, `BaseState` out, once per received frame.

    Args:
        base: kinematics of the body.
        parameters: of the filters.
    """

    def __init__(self, base: FloatingBase, parameters: ControllerParameters) -> None:
        self._base = base
        self._odometry = Odometry(base, gyroscope=GyroscopeHeading.of(base.body))
        self.restart(parameters)
        zeros = [0.0] * N_JOINTS
        pose = base.place(base.in_torso(zeros), np.eye(4))
        self.state = BaseState(pose, ComEstimator(base, 1.0).update(zeros, (0.0, 0.0), (0.0, 0.0, 0.0), 0.0))
        """State at the last frame."""

    def restart(self, parameters: ControllerParameters) -> None:
        """Forget the history, but for the way that the robot has gone.

        Args:
            parameters: of the filters from now on.
        """
        on = parameters.switches.attitude_correction
        self._attitude = Attitude(parameters.attitude if on else None)
        self._lean = Lean(parameters.lean, parameters.latency)
        self._com = ComEstimator(self._base, parameters.com_smoothing)
        self._heading: float | None = None
        self._velocity = SmoothedRate(VELOCITY_TIME)

    def update(self, frame: SensorFrame, dt: float, heading: float) -> BaseState:
        """One cycle.

        Args:
            frame: newest sensor frame.
            dt: time since the last one, s.
            heading: of the plan in force, rad. Some bodies have no gyroscope about z.
        """
        pose = self._odometry.update(frame)
        angle = self._attitude.update(frame, dt)
        turn = (heading - self._heading) / dt if self._heading is not None and dt > 0.0 else 0.0
        self._heading = heading
        lean = self._lean.update(frame.gyroscope, angle, turn, dt)
        self.state = BaseState(
            pose=pose,
            com=self._com.update(frame.position, lean, frame.gyroscope, dt),
            middle=middle_of_soles(self._base, pose),
            angle=angle,
            lean=lean,
            lean_ahead=self._lean.lean_without_mean,
            velocity=self._velocity.update(pose.frames[0, :3, 3], dt),
            angular_velocity=frame.gyroscope,
        )
        return self.state
