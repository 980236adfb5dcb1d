"""The state of the robot's floating base, by its sensors: the one place where a filter makes it.

Another estimator, such as a Kalman filter, has the constructor, the two methods and the attribute `state` of
`Estimator`. `walker/estimation/fall.py` and the mechanisms that answer a push estimate the velocity of the mass
themselves.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bridge.body.joints import N_JOINTS
from bridge.body.kinematics import FloatingBase, RobotPose
from bridge.messages import SensorFrame
from bridge.types import Vec2, Vec3
from walker.estimation.attitude import Attitude, Lean
from walker.estimation.odometry import GyroscopeHeading, Odometry, middle_of_soles
from walker.gaits.plan import Foothold
from walker.parameters import ControllerParameters


class BaseState(NamedTuple):
    """Measured state of the robot when its sensors were read, SI units and rad.

    The odometry's frame has z up; its origin is the middle of the soles at the first frame.
    """

    pose: RobotPose
    """All links, feet and centre of mass in the odometry's frame."""
    middle: Foothold = Foothold()
    """Middle of both soles and mean of their headings in the odometry's frame."""
    angle: Vec2 = (0.0, 0.0)
    """Roll and pitch of the torso without drift; follows a disturbance late."""
    lean: Vec2 = (0.0, 0.0)
    """The same without lag."""
    lean_ahead: Vec2 = (0.0, 0.0)
    """`lean` less its slow mean, one latency later."""
    angular_velocity: Vec3 = (0.0, 0.0, 0.0)
    """Angular velocity of the torso, in the Torso frame."""


class Estimator:
    """Sensor frames in, `BaseState` out, once per received frame.

    Args:
        base: kinematics of the body.
        parameters: of the filters.
    """

    def __init__(self, base: FloatingBase, parameters: ControllerParameters) -> None:
        self._base = base
        self._odometry = Odometry(base, gyroscope=GyroscopeHeading.of(base.body))
        self.state = BaseState(base.place(base.in_torso([0.0] * N_JOINTS), np.eye(4)))
        """State at the last frame."""
        self.restart(parameters)

    def restart(self, parameters: ControllerParameters) -> None:
        """Forget the history, but for the way that the robot has gone.

        Args:
            parameters: of the filters from now on.
        """
        on = parameters.switches.attitude_correction
        self._attitude = Attitude(parameters.attitude if on else None)
        self._lean = Lean(parameters.lean, parameters.latency)
        self._heading: float | None = None

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
            pose, middle_of_soles(self._base, pose), angle, lean, self._lean.lean_without_mean, frame.gyroscope
        )
        return self.state
