"""Foresees a fall by the capture point and the soles.

The capture point is the centre of mass plus its velocity over the frequency of the pendulum; who steps there
comes to rest. Encoders and gyroscope give the velocity over a sole that stands flat. The accelerometer shows a
push before the body turns, so for a short time its integral counts. A push that is stronger than the walk
survives shows by the accelerometer alone, while it lasts.
"""

from __future__ import annotations

import math
from typing import Final

import msgspec
import numpy as np

from bridge.body.kinematics import FloatingBase
from bridge.body.quantities import GRAVITY
from bridge.messages import SensorFrame
from bridge.rotations import rotation
from bridge.types import SIDES, Array, Positive, Side, Vec2
from walker.estimation.mass_over_soles import MassOverSoles
from walker.planning.plan import SIGN, Plan

FREQUENCY: Final = math.sqrt(GRAVITY / 0.25)
"""rad/s; of a pendulum as high as a NAO's mass over its soles."""


class ForesightParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How far the capture point may be beyond the middle of the nearest sole, and how hard a push."""

    ahead: Positive = 0.065
    """m; undisturbed walks of `omni` reach 0.03."""
    behind: Positive = 0.08
    """m; 0.05 in undisturbed walks."""
    capture_ahead: Positive = 0.10
    """m, in a stand and in a capture step of a gait that makes such steps."""
    capture_behind: Positive = 0.14
    """m, likewise."""
    outside_stance: Positive = 0.065
    """m, to the outside of a foot that stands; 0.05."""
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


class Foresight:
    """Follows the capture point over both soles, once per received frame.

    Args:
        parameters: the bounds. What the robot would have caught beyond them is a fall then.
        base: kinematics of the body.
    """

    def __init__(self, parameters: ForesightParameters, base: FloatingBase) -> None:
        self._p = parameters
        self._base = base
        self._mass = {side: MassOverSoles(self._base, parameters.smoothing) for side in SIDES}
        self._velocity: dict[Side, Array] = {}
        self._push: Array = np.zeros(2)

    def update(self, frame: SensorFrame, lean: Vec2, plan: Plan, dt: float) -> bool:
        """One cycle.

        Args:
            frame: newest sensor frame.
            lean: roll and pitch of the torso, rad.
            plan: in force.
            dt: time since the last frame, s.

        Returns:
            Whether the capture point is beyond the bounds, or a walk was pushed too hard. A push in a stand is
            left to the capture step.
        """
        p = self._p
        self._push = self._push + dt * (rotation(*lean, 0.0) @ frame.accelerometer)[:2]
        self._push -= min(dt / p.push_time, 1.0) * self._push
        walks = plan.phase not in ("stand", "stop") and plan.capture is None
        captures = not walks and plan.pendulum is not None
        toes, heels = (p.capture_ahead, p.capture_behind) if captures else (p.ahead, p.behind)
        pushed = walks and math.hypot(*self._push) > p.push
        pose = self._base.place(self._base.in_torso(frame.position), np.eye(4))
        share = min(dt / p.acceleration_time, 1.0)
        x: list[float] = []
        outside = False
        for side in SIDES:
            com, rate, turn = self._mass[side].update(pose, (side,), lean, frame.gyroscope, dt)
            velocity = self._velocity.get(side, rate) + dt * (turn @ frame.accelerometer)[:2]
            velocity += share * (rate - velocity)
            self._velocity[side] = velocity
            ahead, left = com + velocity / FREQUENCY
            x.append(ahead)
            bound = p.outside_stance if plan.support in (side, "both") else p.outside_swing
            outside = outside or SIGN[side] * left > bound
        return bool(pushed or outside or min(x) > toes or max(x) < -heels)
