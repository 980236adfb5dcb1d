"""Parameters of the omnidirectional gait."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import msgspec

from bridge.types import Finite, NotNegative, Positive, Vec3
from walker.gaits.gait import GaitParameters, PeriodicStep

Share = Annotated[float, msgspec.Meta(gt=0.0, le=1.0)]
ShortLength = Annotated[float, msgspec.Meta(ge=0.0, le=0.1)]
"""m; the bounds refuse millimetres."""


class OmniParameters(GaitParameters, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Timing, geometry and limits of the steps, SI units and rad."""

    v_x: Finite
    """Forward velocity where none is commanded, m/s."""
    v_y: Finite = 0.0
    """The same to the left, m/s."""
    v_yaw: Finite = 0.0
    """The same, turning to the left, rad/s."""
    T: Positive
    """Duration of a step, s."""
    T_DSP: NotNegative
    """Time at the beginning of a step in which the ZMP moves from the foot before to the stance foot, s."""
    T_start: Positive
    """Time from rest to the first step, and from the last one until the capture point rests, s."""
    z: Positive
    """Height of the centre of mass above the ground, m."""
    l_FA: Positive
    """Step width: distance of the ankles along y, m."""
    l_GH: Positive
    """Gait height: ankle to hip joint along z, m."""
    l_lift: Positive
    """Lift of the swing foot at the middle of its swing, m."""
    zmp_x: Finite
    """Planned ZMP of single support ahead of the ankle, m."""
    zmp_y: Finite
    """The same to the outside of the ankle, m."""
    max_velocity: Vec3
    """Forward, to either side, m/s, and turn, rad/s: semi-axes of the ellipsoid of permitted commands."""
    max_backward: Positive
    """Semi-axis backward, m/s."""
    max_acceleration: Vec3
    """Fastest gain of velocity, m/s^2 and rad/s^2."""
    max_deceleration: Vec3
    """Fastest loss of it."""
    max_length: Positive
    """Longest way along x between two footholds, m."""
    min_width: Positive
    """Smallest distance of the ankles along y at touch-down, m: no foot treads on the other."""
    max_width: Positive
    """Largest one, m."""
    foothold_gain: tuple[NotNegative, NotNegative] = (0.0, 0.0)
    """Share of the capture point's deviation at touch-down by which the foothold is moved, along x and y."""
    turning_foothold_gain: tuple[NotNegative, NotNegative] = (0.0, 0.0)
    """The same at the largest turn rate, with a linear change in between: in a turn on the spot a larger share
    rocks the robot from step to step."""
    foothold_deadband: tuple[NotNegative, NotNegative] = (0.0, 0.0)
    """Deviation now that is left alone, m."""
    catch_up_time: Positive = 0.15
    """Time constant with which the planned centre of mass follows the pendulum after a moved foothold, s."""
    heading_gain: NotNegative = 0.0
    """Share of the heading's error that the next step takes back."""
    max_heading_correction: NotNegative = 0.5
    """Largest turn rate by which a step does so, rad/s."""
    T_capture: Positive
    """Duration of a capture step ahead, s."""
    T_backward_capture: Positive
    """The same of one back, s."""
    backward_capture_lift: ShortLength
    """Lift of the foot in a capture step back, m: the leg that swings back lifts it too."""
    backward_capture_inset: ShortLength
    """Way by which a capture step back ends nearer to the other foot, m."""
    capture_settling_time: Positive
    """Time constant with which the planned centre of mass moves between the feet after a capture step, s."""
    turn_share: Share
    """Share of a turn made by the steps of the foot on the inner side, which turn the toes outward."""
    first_swing: Literal["L", "R"] = "R"
    """The foot that makes the first step."""

    @property
    def periodic_step(self) -> PeriodicStep:
        """A step at the velocity where none is commanded."""
        return PeriodicStep(self.v_x * self.T, self.T)

    @property
    def limits(self) -> OmniParameters:
        """See `share`."""
        return self

    @property
    def velocity(self) -> Vec3:
        """The velocity without a command, m/s, m/s, rad/s."""
        return self.v_x, self.v_y, self.v_yaw

    def with_velocity(self, velocity: Vec3) -> OmniParameters:
        """The parameters with another velocity where none is commanded, clipped to the limits.

        Args:
            velocity: forward and to the left, m/s, and turn, rad/s.
        """
        x, y, turn = self.clipped(velocity)
        return msgspec.structs.replace(self, v_x=x, v_y=y, v_yaw=turn)

    def clipped(self, velocity: Vec3) -> Vec3:
        """A velocity, shortened to the ellipsoid of the limits where it is outside.

        Args:
            velocity: forward and to the left, m/s, and turn, rad/s.
        """
        x, y, turn = velocity
        share = self.share(velocity)
        return velocity if share <= 1.0 else (x / share, y / share, turn / share)

    def share(self, velocity: Vec3) -> float:
        """Part of the limits that a velocity takes up: 1 on the ellipsoid, over 1 outside.

        Args:
            velocity: forward and to the left, m/s, and turn, rad/s.
        """
        x, y, turn = velocity
        ahead = self.max_velocity[0] if x > 0.0 else self.max_backward
        return math.hypot(x / ahead, y / self.max_velocity[1], turn / self.max_velocity[2])
