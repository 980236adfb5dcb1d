"""Balance of a robot in one cycle: support polygon, zero moment point, margin, capture point.

Each twice where it can be: by the robot's own sensors, and by the ground truth.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from bridge.body import Body
from bridge.body.kinematics import FloatingBase, RobotPose, homogeneous
from bridge.messages import SensorFrame, TruthFrame, WalkTelemetry
from bridge.planar import Pose2D
from bridge.polygon import SupportPolygon, convex_hull
from bridge.rotations import heading, matrix
from bridge.types import SIDES, Array, Pose, Side, Vec2
from nao_hil.runs.run import Cycle
from walker.estimation.contact import ContactEstimator, ContactParameters, Contacts, FootForces
from walker.estimation.odometry import GroundPlane, GyroscopeHeading, Odometry, middle_of_soles, on_ground
from walker.functions import LinearPendulum, SmoothedRate, capture_point

SMOOTHING: Final = 0.05
"""Time constant of the velocity, s: a difference of cycles is mostly the encoders' steps."""


LEAST_FORCE: Final = 3.0
"""True vertical force with which a foot stands, N; as the walker takes it from its sensors."""
AT_REST: Final = ("approach", "stand")
"""States of a walker whose planned feet are where the robot's are."""


class Stand(NamedTuple):
    """Pose and balance of a robot by one source."""

    robot: RobotPose
    contacts: Contacts
    support: SupportPolygon | None
    """World frame; None in flight. Truth: the hull of the soles that touch; sensors: that of their force cells,
    beyond which no force can be felt."""
    zmp: Vec2 | None
    """World frame, m."""
    margin: float | None
    """Margin of the zero moment point inside the support polygon, m."""
    capture: Vec2
    """Capture point: where a foot would have to stand for the robot to come to rest over it, world frame, m."""


class PlannedStand(NamedTuple):
    """Plan of the walker, in the world."""

    zmp: Vec2
    com: Vec2
    soles: dict[Side, Pose2D]
    """Planned soles (below the AnkleRoll origin)."""
    lift: dict[Side, float]
    """Planned height of each sole, m."""
    margin: float | None
    """Margin of the planned ZMP inside the hull of the planned soles on the ground, m."""


class Balance(NamedTuple):
    """Balance of a robot in one cycle."""

    cycle: Cycle
    sensed: Stand
    """By encoders, fused angle and force sensors."""
    true: Stand | None
    plan: PlannedStand | None
    felt: Vec2 | None
    """Zero moment point by the force sensors, under the best known feet, world frame, m."""

    @property
    def best(self) -> Stand:
        """The ground truth where there is one."""
        return self.true or self.sensed


class BalanceEstimator:
    """Follows a robot cycle by cycle; new from the start after a reset."""

    def __init__(self, body: Body) -> None:
        self.body, self.kinematics = body, FloatingBase(body)
        self.ground = GroundPlane()
        """The ground as known from elsewhere; sensors are read as if the robot stood on it."""
        self._forces = FootForces(body)
        self._cells: dict[Side, Array] = {
            "L": np.column_stack([body.fsr.L, np.ones(4)]),
            "R": np.column_stack([body.fsr.R, np.ones(4)]),
        }
        self._begin()

    def _begin(self) -> None:
        self._odometry: Odometry | None = None
        self._contact = ContactEstimator(ContactParameters())
        self._walk_frame: Pose2D | None = None
        self._stood_on: list[Side] = []
        self._velocity = {True: SmoothedRate(SMOOTHING), False: SmoothedRate(SMOOTHING)}
        """Velocity of the centre of mass: by the truth (True), by the sensors (False)."""
        self._times = {True: math.nan, False: math.nan}
        self._seq = -1

    def update(self, cycle: Cycle) -> Balance:
        """One cycle, later than the last one; an earlier one restarts."""
        frame = cycle.sensors
        if frame.seq < self._seq:
            self._begin()
        self._seq = frame.seq
        true = true_pose(self.kinematics, cycle.truth) if cycle.truth is not None else None
        if self._odometry is None:
            start = middle_of_soles(self.kinematics, true) if true else Pose2D()
            self._odometry = Odometry(self.kinematics, start, GyroscopeHeading.of(self.body))
        sensed = self._sensed(frame, self._odometry.update(frame, self.ground))
        plan = self._plan(cycle.walk, true or sensed.robot) if cycle.walk is not None else None
        felt = self._felt(frame, true or sensed.robot, sensed.contacts)
        stands = self._true(cycle.truth, true) if cycle.truth and true else None
        return Balance(cycle, sensed, stands, plan, felt)

    def _sensed(self, frame: SensorFrame, robot: RobotPose) -> Stand:
        contacts = self._contact.update(frame.fsr)
        zmp = self._felt(frame, robot, contacts)
        return self._stand(robot, contacts, zmp, self._com(False, frame.time, robot.com), self._cells)

    def _com(self, true: bool, time: float, place: Array) -> tuple[Vec2, Vec2]:
        """Centre of mass and its velocity, x and y, world frame, m and m/s."""
        before, self._times[true] = self._times[true], time
        (x, y, _), (v_x, v_y, _) = place.tolist(), self._velocity[true].update(place, time - before).tolist()
        return (x, y), (v_x, v_y)

    def _felt(self, frame: SensorFrame, robot: RobotPose, contacts: Contacts) -> Vec2 | None:
        feet = {side: robot.feet[side] for side in SIDES if contacts.of(side)}
        point = self._forces.zmp(frame.fsr, feet)
        return None if point is None else (float(point[0]), float(point[1]))

    def _true(self, truth: TruthFrame, robot: RobotPose) -> Stand:
        contacts = Contacts(truth.left.force[2] > LEAST_FORCE, truth.right.force[2] > LEAST_FORCE)
        com = self._com(True, truth.time, np.array(truth.com))
        return self._stand(robot, contacts, truth.zmp, com, self.kinematics.soles)

    def _stand(
        self,
        robot: RobotPose,
        contacts: Contacts,
        zmp: Vec2 | None,
        com: tuple[Vec2, Vec2],
        bearing: dict[Side, Array],
    ) -> Stand:
        corners = [(bearing[s] @ robot.feet[s][:2].T) for s in SIDES if contacts.of(s)]
        support = SupportPolygon(convex_hull(np.vstack(corners))) if corners else None
        ground = min(float(self.kinematics.sole_in_world(s, robot.feet[s])[:, 2].min()) for s in SIDES)
        height = max(float(robot.com[2]) - ground, 0.01)
        margin = support.margin(zmp) if support is not None and zmp is not None else None
        capture = capture_point(*com, LinearPendulum(height).nu)
        return Stand(robot, contacts, support, zmp, margin, capture)

    def _plan(self, walk: WalkTelemetry, robot: RobotPose) -> PlannedStand:
        poses: dict[Side, Pose] = {"L": walk.left, "R": walk.right}
        lift = {side: pose[2] for side, pose in poses.items()}
        standing = [side for side in SIDES if lift[side] < 1e-4]
        stepped = len(standing) == 1 and standing != self._stood_on
        if self._walk_frame is None or walk.state in AT_REST:
            self._walk_frame = self._align(poses, list(SIDES), robot)
        elif stepped:  # the plan does not know of a foot that slipped or turned
            self._walk_frame = self._align(poses, standing, robot)
        if stepped:
            self._stood_on = standing
        at = self._walk_frame
        soles = {side: at.pose(Pose2D(*pose[:2], pose[5])) for side, pose in poses.items()}
        down = [self.sole_on_ground(side, soles[side]) for side in standing]
        zmp = at.point(*walk.zmp)
        margin = SupportPolygon(convex_hull(np.vstack(down))).margin(zmp) if down else None
        return PlannedStand(zmp, at.point(*walk.com), soles, lift, margin)

    def _align(self, poses: dict[Side, Pose], sides: list[Side], robot: RobotPose) -> Pose2D:
        """The walk frame in the world, in which some planned feet are in the middle where the robot's are."""
        *planned, turn = np.mean([[poses[side][i] for i in (0, 1, 5)] for side in sides], axis=0)
        x, y = np.mean([robot.feet[side][:2, 3] for side in sides], axis=0)
        one = heading(robot.feet[sides[0]])
        now = one if len(sides) == 1 else middle_of_soles(self.kinematics, robot).yaw
        back = Pose2D(yaw=now - turn).point(*planned)
        return Pose2D(float(x) - back[0], float(y) - back[1], float(now - turn))

    def sole_on_ground(self, side: Side, at: Pose2D) -> Array:
        """Corners of a sole that lies at a pose on the ground, shape (n, 2), m."""
        corners: Array = (self.kinematics.soles[side] @ on_ground(at).T)[:, :2]
        return corners


def true_pose(robot: FloatingBase, truth: TruthFrame) -> RobotPose:
    """The robot at the pose of the ground truth.

    Args:
        robot: Kinematics of the body.
        truth: its torso and joints are read.
    """
    torso = homogeneous(matrix(truth.torso_orientation), truth.torso_position)
    return robot.place(robot.in_torso(truth.joints), torso)
