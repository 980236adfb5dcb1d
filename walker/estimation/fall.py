"""Falls: detected by the torso's angle, and predicted by the capture point over the soles.

The capture point is the centre of mass plus its velocity over the frequency of the pendulum; a robot that steps
there comes to rest. Encoders and gyroscope give the velocity over a flat stance sole. The accelerometer
shows a push before the body turns, so for a short time its integral counts. A push that is stronger than the
walk survives shows by the accelerometer alone, while it lasts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Final

import msgspec
import numpy as np

from bridge.body.kinematics import FloatingBase, RobotPose
from bridge.body.quantities import GRAVITY
from bridge.messages import SensorFrame
from bridge.rotations import R_yaw, heading, rotation
from bridge.types import SIDES, Array, Fraction, NotNegative, Positive, Side, Vec2, Vec3
from walker.estimation.contact import Contacts
from walker.gaits.plan import SIGN, Plan


class MassOverSoles:
    """Follows the centre of mass over the middle of soles, once per received frame.

    Args:
        base: kinematics of the body.
        smoothing: time constant of the velocity by the joints' motion, s; the gyroscope gives that by the turn.
    """

    def __init__(self, base: FloatingBase, smoothing: float) -> None:
        self._base, self._smoothing = base, smoothing
        self._sides: tuple[Side, ...] = ()
        self._offset: Array = np.zeros(3)
        self._rate: Array = np.zeros(3)

    def update(
        self, pose: RobotPose, sides: Sequence[Side], lean: Vec2, gyroscope: Vec3, dt: float
    ) -> tuple[Array, Array, Array]:
        """One cycle.

        Args:
            pose: of the robot in the Torso frame.
            sides: of the soles.
            lean: roll and pitch of the torso, rad.
            gyroscope: angular velocity in the Torso frame, rad/s.
            dt: time since the last cycle, s.

        Returns:
            Place over the middle of the soles and velocity, x ahead and y to the left of them, m and m/s; the
            rotation from the Torso frame.
        """
        centres = self._base.centres
        ways = (pose.com - (pose.feet[side] @ centres[side])[:3] for side in sides)
        offset: Array = sum(ways, np.zeros(3)) / len(sides)
        if tuple(sides) == self._sides and dt > 0.0:
            share = min(dt / self._smoothing, 1.0)
            self._rate = self._rate + share * ((offset - self._offset) / dt - self._rate)
        self._offset, self._sides = offset, tuple(sides)
        level = rotation(*lean, 0.0)
        yaw = sum(heading(level @ pose.feet[side][:3, :3]) for side in sides) / len(sides)
        turn = R_yaw(-yaw) @ level
        (w_x, w_y, w_z), (x, y, z) = gyroscope, offset.tolist()
        turning = w_y * z - w_z * y, w_z * x - w_x * z, w_x * y - w_y * x
        return (turn @ offset)[:2], (turn @ (turning + self._rate))[:2], turn

    def reset(self) -> None:
        """Let the next velocity begin with the joints' last."""
        self._sides = ()


class FallParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Fall detection, and the protective pose."""

    angle: Annotated[float, msgspec.Meta(gt=0.0, le=math.pi / 2)] = math.radians(30.0)
    """Fused torso roll or pitch, rad. With the mass 0.23 m above a sole that ends 0.10 m ahead and 0.05 m
    behind, no ankle brings a NAO back from 24 degrees; the rest is for the error of the fused angle."""
    capture_angle: Annotated[float, msgspec.Meta(gt=0.0, le=math.pi / 2)] = math.radians(45.0)
    """The same from the beginning of a capture step until the robot stands: the feet follow the mass."""
    no_support: Positive = 0.5
    """Time in the walk for which no foot touches, s: lifted, or lying on its back with the legs in the air."""
    brace_time: NotNegative = 0.4
    """s that a robot takes to move into its protective pose, with `brace_stiffness`."""
    brace_stiffness: Fraction = 0.4
    stiffness: Fraction = 0.1
    """Stiffness while falling and lying: the gears give way, the limbs do not flap."""


class FallDetector:
    """A fall is a torso that leans too far, or a walk without ground under it for too long.

    Args:
        parameters: the bounds.
    """

    def __init__(self, parameters: FallParameters) -> None:
        self._p = parameters
        self._unsupported = 0.0

    def update(
        self, angle: Vec2, contacts: Contacts, dt: float, *, walking: bool, capturing: bool = False
    ) -> str:
        """One cycle.

        Args:
            angle: fused torso roll and pitch, rad.
            contacts: of the feet.
            dt: time since the last frame, s.
            walking: whether the feet are meant to bear the robot; a suspended robot is not falling.
            capturing: whether it makes a capture step, or has not settled after one.

        Returns:
            Why it falls; empty: it does not.
        """
        self._unsupported = self._unsupported + dt if walking and contacts.none else 0.0
        name = "capture_angle" if capturing else "angle"
        bound, leans = getattr(self._p, name), max(angle, key=abs)
        if abs(leans) > bound:
            axis = "rolled" if leans == angle[0] else "pitched"
            return f"the torso {axis} beyond fall.{name}, {math.degrees(bound):.0f} deg"
        if self._unsupported > self._p.no_support:
            return f"no foot touched the ground for over fall.no_support, {self._p.no_support:g} s"
        return ""


PENDULUM_FREQUENCY: Final = math.sqrt(GRAVITY / 0.25)
"""rad/s; of a pendulum as high as a NAO's mass over its soles."""


class FallPredictorParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Bounds of the capture point beyond the middle of the nearest sole, and of a push."""

    ahead: Positive = 0.065
    """m; undisturbed walks of `omni` reach 0.03."""
    behind: Positive = 0.08
    """m; 0.05 in undisturbed walks."""
    capture_ahead: Positive = 0.10
    """m, at rest and in a capture step of a gait that makes such steps."""
    capture_behind: Positive = 0.14
    """m, likewise."""
    outside_stance: Positive = 0.065
    """m, to the outside of the stance foot; 0.05."""
    outside_swing: Positive = 0.045
    """m, to the outside of a foot that swings; 0.04."""
    acceleration_time: Positive = 0.2
    """Time constant with which the integral of the accelerometer is drawn to the velocity by the others, s."""
    smoothing: Positive = 0.03
    """As in `MassOverSoles`, s."""
    push: Positive = 0.4
    """m/s to which the level part of the accelerometer adds up in a walk; an undisturbed walk of 240 s reached
    0.23 (V6). Of ten pushes of 2.5 to 3 N s, which add up to 0.3 to 0.5, eight felled a V6."""
    push_time: Positive = 0.1
    """Time constant of that sum, s; as long as a push."""


class FallPredictor:
    """Follows the capture point over both soles, once per received frame.

    Args:
        parameters: the bounds. A deviation beyond them counts as a fall, even a recoverable one.
        base: kinematics of the body.
    """

    def __init__(self, parameters: FallPredictorParameters, base: FloatingBase) -> None:
        self._p = parameters
        self._base = base
        self._mass = {side: MassOverSoles(self._base, parameters.smoothing) for side in SIDES}
        self._velocity: dict[Side, Array] = {}
        self._push: Array = np.zeros(2)

    def update(self, frame: SensorFrame, lean: Vec2, plan: Plan, dt: float) -> str:
        """One cycle.

        Args:
            frame: newest sensor frame.
            lean: roll and pitch of the torso, rad.
            plan: in force.
            dt: time since the last frame, s.

        Returns:
            Why it will fall: the capture point is beyond the bounds, or a walk was pushed too hard; empty: it
            will not. A push at rest is left to the capture step.
        """
        p = self._p
        self._push = self._push + dt * (rotation(*lean, 0.0) @ frame.accelerometer)[:2]
        self._push -= min(dt / p.push_time, 1.0) * self._push
        walks = plan.phase not in ("stand", "stop") and plan.capture is None
        captures = not walks and plan.pendulum is not None
        toes, heels = (p.capture_ahead, p.capture_behind) if captures else (p.ahead, p.behind)
        pose = self._base.place(self._base.in_torso(frame.position), np.eye(4))
        share = min(dt / p.acceleration_time, 1.0)
        x: list[float] = []
        outside = False
        for side in SIDES:
            com, rate, turn = self._mass[side].update(pose, (side,), lean, frame.gyroscope, dt)
            velocity = self._velocity.get(side, rate) + dt * (turn @ frame.accelerometer)[:2]
            velocity += share * (rate - velocity)
            self._velocity[side] = velocity
            ahead, left = com + velocity / PENDULUM_FREQUENCY
            x.append(ahead)
            bound = p.outside_stance if plan.support in (side, "both") else p.outside_swing
            outside = outside or SIGN[side] * left > bound
        if walks and math.hypot(*self._push) > p.push:
            return f"a push was harder than foresight.push, {p.push:g} m/s"
        if outside or min(x) > toes or max(x) < -heels:
            where = "beside" if outside else "ahead of" if min(x) > toes else "behind"
            return f"the capture point was too far {where} the soles (the bounds of foresight)"
        return ""
