"""Falls: detected by the torso's angle, and predicted by the capture point over the soles.

The capture point is the centre of mass plus its velocity over the frequency of the pendulum; a robot that steps
there comes to rest. Encoders and gyroscope give the velocity over a flat stance sole. The accelerometer
shows a push before the body turns, so for a short time its integral counts. A push that is stronger than the
walk survives shows by the accelerometer alone, while it lasts.
"""

from __future__ import annotations

import math
from typing import Annotated, Final

import msgspec
import numpy as np

from bridge.body.quantities import GRAVITY
from bridge.messages import SensorFrame
from bridge.planar import Pose2D
from bridge.rotations import rotation
from bridge.types import SIDES, Array, Fraction, NotNegative, Positive, Side, Vec2
from walker.estimation.contact import Contacts
from walker.estimation.state import BaseState
from walker.functions import capture_point
from walker.gaits.plan import SIGN, Plan


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
    push: Positive = 0.4
    """m/s to which the level part of the accelerometer adds up in a walk; an undisturbed walk of 240 s reached
    0.23 (V6). Of ten pushes of 2.5 to 3 N s, which add up to 0.3 to 0.5, eight felled a V6."""
    push_time: Positive = 0.1
    """Time constant of that sum, s; as long as a push."""


class FallPredictor:
    """Follows the capture point over both soles, once per received frame.

    Args:
        parameters: the bounds. A deviation beyond them counts as a fall, even a recoverable one.
    """

    def __init__(self, parameters: FallPredictorParameters) -> None:
        self._p = parameters
        self._velocity: dict[Side, Array] = {}
        self._push: Array = np.zeros(2)

    def update(self, frame: SensorFrame, state: BaseState, plan: Plan, dt: float) -> str:
        """One cycle.

        Args:
            frame: newest sensor frame.
            state: of the robot by that frame.
            plan: in force.
            dt: time since the last frame, s.

        Returns:
            Why it will fall: the capture point is beyond the bounds, or a walk was pushed too hard; empty: it
            will not. A push at rest is left to the capture step.
        """
        p = self._p
        level = (rotation(*state.lean, 0.0) @ frame.accelerometer)[:2]
        self._push = self._push + dt * level
        self._push -= min(dt / p.push_time, 1.0) * self._push
        walks = plan.phase not in ("stand", "stop") and plan.capture is None
        captures = not walks and plan.pendulum is not None
        toes, heels = (p.capture_ahead, p.capture_behind) if captures else (p.ahead, p.behind)
        share = min(dt / p.acceleration_time, 1.0)
        x: list[float] = []
        outside = False
        for side in SIDES:
            over = state.com.over(side)
            acceleration = Pose2D(yaw=over.heading).local(*level.tolist())
            velocity = self._velocity.get(side, over.velocity) + dt * np.array(acceleration)
            velocity += share * (over.velocity - velocity)
            self._velocity[side] = velocity
            v_x, v_y = velocity.tolist()
            ahead, left = capture_point(over.place, (v_x, v_y), PENDULUM_FREQUENCY)
            x.append(ahead)
            bound = p.outside_stance if plan.support in (side, "both") else p.outside_swing
            outside = outside or SIGN[side] * left > bound
        if walks and math.hypot(*self._push) > p.push:
            return f"a push was harder than foresight.push, {p.push:g} m/s"
        if outside or min(x) > toes or max(x) < -heels:
            where = "beside" if outside else "ahead of" if min(x) > toes else "behind"
            return f"the capture point was too far {where} the soles (the bounds of foresight)"
        return ""
