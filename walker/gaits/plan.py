"""The plan of one cycle, and the feedback that changes it: feet, centre of mass and zero moment point.

The walk frame is on the nominal ground: x forward, y left, z up, origin midway between the ankles where the
walker began.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Literal, NamedTuple

from bridge.planar import Pose2D
from bridge.types import Side, Vec2, Vec3

Support = Literal["L", "R", "both"]
Phase = Literal["stand", "start", "DSL", "SSL", "DSR", "SSR", "stop"]
OTHER_SIDE: Final[dict[Side, Side]] = {"L": "R", "R": "L"}
SIGN: Final[dict[Side, float]] = {"L": 1.0, "R": -1.0}
"""Sign of a foot's y."""


class SolePose(NamedTuple):
    """Pose of a sole (frame 9 of the thesis, below the ankle) in the walk frame."""

    x: float
    """Place ahead, m."""
    y: float
    """Place to the left, m."""
    z: float = 0.0
    """m above the nominal ground"""
    roll: float = 0.0
    """rad, positive: left edge up; orientation: R_yaw R_pitch R_roll (2.4)"""
    pitch: float = 0.0
    """rad, positive: toe down"""
    yaw: float = 0.0
    """rad, positive: toe to the left"""

    @property
    def foothold(self) -> Pose2D:
        """Place and heading on the ground."""
        return Pose2D(self.x, self.y, self.yaw)

    def transformed(self, origin: Pose2D) -> SolePose:
        """The same sole in another frame.

        Args:
            origin: where the frame of this pose is in the other one.
        """
        return self._replace(**origin.pose(self.foothold)._asdict())

    def expressed_in(self, origin: Pose2D) -> SolePose:
        """The same sole in the frame of a pose on the ground, the inverse of `transformed`.

        Args:
            origin: where that frame is in the frame of this pose.
        """
        return self._replace(**origin.local_pose(self.foothold)._asdict())


class Pendulum(NamedTuple):
    """The inverted pendulum that a plan follows, as far as feedback needs it."""

    com: tuple[float, float]
    """Its mass in the walk frame, m. The planned centre of mass may still be on its way there."""
    omega: float
    """Natural frequency, 1/s."""
    target: Pose2D
    """Pose2D at the end of the step under way."""
    moved: tuple[float, float] = (0.0, 0.0)
    """Shift by feedback since the beginning, that of its footholds included, m."""
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Commanded, of the step under way, m/s, m/s, rad/s."""

    def transformed(self, origin: Pose2D) -> Pendulum:
        """The same in the frame in which this one's origin is `origin`."""
        moved = Pose2D(yaw=origin.yaw).point(*self.moved)
        return Pendulum(origin.point(*self.com), self.omega, origin.pose(self.target), moved, self.velocity)


class PolicyCommand(NamedTuple):
    """Inputs of a network that gives the joint angles, see `walker.policy`."""

    velocity: Vec3
    """Commanded, forward and to the left, m/s, and turn, rad/s."""
    turns: float
    """Turns of the clock of the steps."""
    amplitude: float
    """Amplitude of its sine and cosine, 0..1."""


@dataclass(frozen=True, slots=True)
class Plan:
    """Planned motion at one instant, in the walk frame, SI units."""

    phase: Phase
    support: Support
    """The foot that bears the weight; `both` in double support."""
    progress: float
    """Fraction of the phase that has passed, 0..1."""
    step: int
    """Steps completed (swing feet put down)."""
    left: SolePose
    right: SolePose
    com: tuple[float, float]
    """Centre of mass, x and y, m."""
    zmp: tuple[float, float]
    """Planned ZMP, m."""
    hip_height: float
    """Height of the hip joints (frame 0 of the legs) above the nominal ground, m."""
    pendulum: Pendulum | None = None
    """Pendulum of gaits that take `Feedback`; None: the others."""
    capture: Side | None = None
    """The foot of a capture step, from the beginning of that step until the robot stands."""
    policy: PolicyCommand | None = None
    """Joint angles that a network gives; None: they follow from the plan."""
    stop_poses: tuple[Pose2D, ...] = ()
    """`middle` at rest if the feet close after the step under way, and after one more. Empty but at
    the end of a step of a gait that walks to a place."""

    def foot(self, side: Side) -> SolePose:
        """The sole of one side."""
        return self.left if side == "L" else self.right

    @property
    def captures_backward(self) -> bool:
        """Whether the capture step is, or was, backward: behind the other foot, along that one's heading."""
        if self.capture is None:
            return False
        foot, other = self.foot(self.capture), self.foot(OTHER_SIDE[self.capture])
        return other.foothold.local(foot.x, foot.y)[0] < 0.0

    @property
    def middle(self) -> Pose2D:
        """Middle between both soles, and the mean of their yaws."""
        left, right = self.left, self.right
        return Pose2D(0.5 * (left.x + right.x), 0.5 * (left.y + right.y), 0.5 * (left.yaw + right.yaw))

    def transformed(self, origin: Pose2D, steps: int = 0) -> Plan:
        """The plan of a walk that begins at another place.

        Args:
            origin: where the frame of this plan is, in the frame of the result.
            steps: number of steps completed before.
        """
        return replace(
            self,
            step=self.step + steps,
            left=self.left.transformed(origin),
            right=self.right.transformed(origin),
            com=origin.point(*self.com),
            zmp=origin.point(*self.zmp),
            pendulum=self.pendulum.transformed(origin) if self.pendulum else None,
            stop_poses=tuple(origin.pose(end) for end in self.stop_poses),
        )


class CaptureStep(NamedTuple):
    """Measured pendulum of a robot that falls unless it makes a capture step."""

    com: Vec2
    """Centre of mass, m."""
    xi: Vec2
    """Capture point, m."""


class LandedFoot(NamedTuple):
    """Measured about the foot that landed from a capture step."""

    xi: float
    """Capture point to the left of its ankle, in its frame, m."""
    roll: float
    """Roll of the torso when this cycle's command is carried out, rad."""


class Feedback(NamedTuple):
    """Measured, in the frame of the plan."""

    deviation: Vec2 = (0.0, 0.0)
    """Capture point of the robot less that of the plan when this cycle's command is carried out, m."""
    foothold_bias: float = 0.0
    """Shift of the feet behind their footholds at touch-down, along the heading of the stance foot, m."""
    heading: float = 0.0
    """Heading of the robot less that of the plan, since the walk began, rad."""
    velocity: Vec2 = (0.0, 0.0)
    """Correction of the command for walking at the commanded velocity, forward and to the left, m/s."""
    extend_step: bool = False
    """The step under way must not end: the robot is on the outer edge of its stance foot."""
    capture_step: CaptureStep | None = None
    """While the robot makes a capture step; when this cycle's command is carried out."""
    landed: LandedFoot | None = None
    """After a capture step, until the feet close."""

    def expressed_in(self, origin: Pose2D) -> Feedback:
        """The same in the frame of a pose on the ground."""
        deviation = Pose2D(yaw=-origin.yaw).point(*self.deviation)
        measured = self.capture_step and CaptureStep(*(origin.local(*each) for each in self.capture_step))
        return self._replace(deviation=deviation, capture_step=measured)


NO_FEEDBACK = Feedback()
"""Feedback without sensors."""
