"""How a robot stands at one moment: support polygon, zero moment point, margin, capture point.

Each twice where it can be: by the robot's own sensors, and by the ground truth.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from bridge.datasheet import Body
from bridge.datasheet.model import Side
from bridge.messages import SensorFrame, TruthFrame, WalkTelemetry
from lab.diagnosis.moment import Moment
from lab.diagnosis.odometry import SIDES, Figure, Floor, Odometry, Placed, Plane
from walker.estimation.contact import ContactEstimator, Contacts
from walker.gravity import GRAVITY
from walker.kinematics.transforms import Array
from walker.parameters.model import ContactParameters
from walker.support_polygon import SupportPolygon, convex_hull
from walker.zmp import FootForces

Point = tuple[float, float]

LEAST_FORCE: Final = 3.0
"""True vertical force with which a foot stands, N; as the walker takes it from its sensors."""
SMOOTHING: Final = 0.05
"""Time constant of the centre of mass' velocity, s: a difference of cycles is mostly the encoders' steps."""
AT_REST: Final = ("approach", "stand")
"""States of a walker whose planned feet are where the robot's are."""


class Stand(NamedTuple):
    """A robot in the world and how it stands, by one source."""

    robot: Placed
    contacts: Contacts
    support: SupportPolygon | None
    """World frame; None in flight. Truth: the hull of the soles that touch; sensors: that of their force cells,
    beyond which no force can be felt."""
    zmp: Point | None
    """World frame, m."""
    margin: float | None
    """Of the zero moment point inside the support polygon, m."""
    capture: Point
    """Capture point: where a foot would have to stand for the robot to come to rest over it, world frame, m."""


class Plan(NamedTuple):
    """What the walker meant, in the world."""

    zmp: Point
    com: Point
    soles: dict[Side, Plane]
    """Planned soles (below the AnkleRoll origin)."""
    lift: dict[Side, float]
    """Planned height of each sole, m."""
    margin: float | None
    """Of the planned ZMP inside the hull of the planned soles on the ground, m."""


class Balance(NamedTuple):
    """Everything at one moment."""

    moment: Moment
    sensed: Stand
    """By encoders, fused angle and force sensors."""
    true: Stand | None
    plan: Plan | None

    @property
    def best(self) -> Stand:
        """The ground truth where there is one."""
        return self.true or self.sensed


class Observer:
    """Follows a robot moment by moment; new from the start after a reset.

    Args:
        body: The data sheet.
    """

    def __init__(self, body: Body) -> None:
        self.figure = Figure(body)
        self.floor = Floor()
        """The floor as known from elsewhere; sensors are read as if the robot stood on it."""
        self._forces = FootForces(body)
        self._cells: dict[Side, Array] = {
            "L": np.column_stack([body.fsr.L, np.ones(4)]),
            "R": np.column_stack([body.fsr.R, np.ones(4)]),
        }
        self._begin()

    def _begin(self) -> None:
        self._odometry: Odometry | None = None
        self._contact = ContactEstimator(ContactParameters())
        self._walk_frame: Plane | None = None
        self._velocity = {True: _Velocity(), False: _Velocity()}
        self._seq = -1

    def update(self, moment: Moment) -> Balance:
        """One moment, later than the last one; an earlier one begins anew."""
        frame = moment.sensors
        if frame.seq < self._seq:
            self._begin()
        self._seq = frame.seq
        true = self.figure.true(moment.truth) if moment.truth is not None else None
        if self._odometry is None:
            start = self.figure.sole_middle(true.feet) if true else Plane()
            self._odometry = Odometry(self.figure, start)
        sensed = self._sensed(frame, self._odometry.update(frame, self.floor))
        plan = self._plan(moment.walk, sensed.robot) if moment.walk is not None else None
        return Balance(moment, sensed, self._true(moment.truth, true) if moment.truth and true else None, plan)

    def _sensed(self, frame: SensorFrame, robot: Placed) -> Stand:
        contacts = self._contact.update(frame.fsr)
        feet = {side: robot.feet[side] for side in SIDES if contacts.of(side)}
        point = self._forces.zmp(frame.fsr, feet)
        zmp = None if point is None else (float(point[0]), float(point[1]))
        velocity = self._velocity[False].update(frame.time, robot.com)
        return self._stand(robot, contacts, zmp, velocity, self._cells)

    def _true(self, truth: TruthFrame, robot: Placed) -> Stand:
        contacts = Contacts(truth.left.force[2] > LEAST_FORCE, truth.right.force[2] > LEAST_FORCE)
        velocity = self._velocity[True].update(truth.time, np.array(truth.com))
        return self._stand(robot, contacts, truth.zmp, velocity, self.figure.soles)

    def _stand(
        self,
        robot: Placed,
        contacts: Contacts,
        zmp: Point | None,
        velocity: Array,
        bearing: dict[Side, Array],
    ) -> Stand:
        corners = [(bearing[s] @ robot.feet[s][:2].T) for s in SIDES if contacts.of(s)]
        support = SupportPolygon(convex_hull(np.vstack(corners))) if corners else None
        ground = min(float(self.figure.sole_in_world(s, robot.feet[s])[:, 2].min()) for s in SIDES)
        height = max(float(robot.com[2]) - ground, 0.01)
        reach = math.sqrt(height / GRAVITY)
        capture = (float(robot.com[0] + reach * velocity[0]), float(robot.com[1] + reach * velocity[1]))
        margin = support.margin(zmp) if support is not None and zmp is not None else None
        return Stand(robot, contacts, support, zmp, margin, capture)

    def _plan(self, walk: WalkTelemetry, robot: Placed) -> Plan:
        if self._walk_frame is None or walk.state in AT_REST:
            self._walk_frame = self._align(walk, robot)
        at = self._walk_frame
        soles = {side: Plane(*at.point(place), at.yaw) for side, place in (("L", walk.left), ("R", walk.right))}
        lift: dict[Side, float] = {"L": walk.left[2], "R": walk.right[2]}
        typed: dict[Side, Plane] = {"L": soles["L"], "R": soles["R"]}
        on_ground = [self.sole_on_ground(s, typed[s]) for s in SIDES if lift[s] < 1e-4]
        zmp = at.point(walk.zmp)
        margin = SupportPolygon(convex_hull(np.vstack(on_ground))).margin(zmp) if on_ground else None
        return Plan(zmp, at.point(walk.com), typed, lift, margin)

    def _align(self, walk: WalkTelemetry, robot: Placed) -> Plane:
        """The walk frame in the world, in which the planned ankles are where the robot's are."""
        planned = (0.5 * (walk.left[0] + walk.right[0]), 0.5 * (walk.left[1] + walk.right[1]))
        x, y = 0.5 * (robot.feet["L"][:2, 3] + robot.feet["R"][:2, 3])
        yaw = self.figure.sole_middle(robot.feet).yaw
        back = Plane(yaw=yaw).point(planned)
        return Plane(float(x) - back[0], float(y) - back[1], yaw)

    def sole_on_ground(self, side: Side, at: Plane) -> Array:
        """Corners of a sole that lies at a pose on the ground, shape (n, 2), m."""
        corners: Array = (self.figure.soles[side] @ at.transform.T)[:, :2]
        return corners


class _Velocity:
    """Smoothed derivative of a position."""

    def __init__(self) -> None:
        self._last: tuple[float, Array] | None = None
        self._value: Array = np.zeros(3)

    def update(self, time: float, position: Array) -> Array:
        """Velocity, shape (3,), m/s, after a position at a time (s); one that is not later changes nothing."""
        if self._last is not None and time > self._last[0]:
            dt = time - self._last[0]
            raw = (position - self._last[1]) / dt
            self._value = self._value + min(dt / SMOOTHING, 1.0) * (raw - self._value)
        self._last = (time, position)
        return self._value
