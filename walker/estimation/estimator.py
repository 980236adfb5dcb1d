"""All estimates of one cycle together."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bridge.datasheet import Body
from bridge.datasheet.model import Side
from bridge.messages import SensorFrame, Vec2
from walker.delay import DelayWatch
from walker.estimation.attitude import Attitude
from walker.estimation.contact import ContactEstimator, Contacts
from walker.estimation.fall import FallDetector
from walker.estimation.ground import GroundTilt
from walker.gait import Foot, Reference
from walker.kinematics.transforms import Transform
from walker.zmp import FootForces

if TYPE_CHECKING:  # the parameters' types import this package's own
    from walker.parameters.model import ControllerParameters


class Estimate(NamedTuple):
    """What one sensor frame tells."""

    contacts: Contacts
    zmp: Vec2 | None
    """Measured zero moment point in the walk frame, m; None without load."""
    angle: Vec2
    """Torso roll and pitch, rad."""
    falling: bool
    ground: Vec2 = (0.0, 0.0)
    """Roll and pitch of the ground under the standing feet, rad."""
    delay: float = 0.0
    """By which answers are late at the robot, in the mean, s."""
    gap: float = 0.0
    """By which the answer in force was older than that, s."""


class Estimator:
    """Turns sensor frames into estimates, once per received frame.

    Args:
        body: places of the force sensors.
        parameters: thresholds.
        cycle: of the robot, s.
    """

    def __init__(self, body: Body, parameters: ControllerParameters, cycle: float) -> None:
        self._attitude = Attitude(parameters.attitude)
        self._contact = ContactEstimator(parameters.contact)
        self._fall = FallDetector(parameters.fall)
        self._forces = FootForces(body)
        self._ground = GroundTilt(parameters.ground, body)
        self._height = body.lengths.FootHeight
        self._delay = DelayWatch(cycle)

    def update(
        self,
        frame: SensorFrame,
        dt: float,
        reference: Reference,
        turned: tuple[Vec2, Vec2] = ((0.0, 0.0), (0.0, 0.0)),
        *,
        walking: bool,
    ) -> Estimate:
        """One cycle.

        Args:
            frame: newest sensor frame.
            dt: time since the last one, s.
            reference: the plan in force: the feet that touch are taken to stand, level, where it put them.
            turned: as in `GroundTilt.update`.
            walking: as in `FallDetector.update`.
        """
        contacts = self._contact.update(frame.fsr)
        angle = self._attitude.update(frame, dt)
        zmp = self._zmp(frame, contacts, reference)
        falling = self._fall.update(angle, contacts, dt, walking=walking)
        moves = reference.phase != "stand"
        ground = self._ground.update(frame, angle, turned, dt, walking=moves)
        self._delay.take(frame)
        return Estimate(contacts, zmp, angle, falling, ground, self._delay.mean, self._delay.gap)

    def take_ground(self, turn: Vec2) -> None:
        """As `GroundTilt.take`."""
        self._ground.take(turn)

    def _zmp(self, frame: SensorFrame, contacts: Contacts, reference: Reference) -> Vec2 | None:
        feet: dict[Side, Transform] = {}
        if contacts.left:
            feet["L"] = self._pose(reference.left)
        if contacts.right:
            feet["R"] = self._pose(reference.right)
        point = self._forces.zmp(frame.fsr, feet)
        return None if point is None else (float(point[0]), float(point[1]))

    def _pose(self, foot: Foot) -> Transform:
        pose = np.eye(4)
        pose[:3, 3] = foot.x, foot.y, self._height
        return pose
