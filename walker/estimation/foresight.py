"""Foresees a fall by the capture point and the soles.

The capture point is the centre of mass plus its velocity over the frequency of the pendulum; who steps there
comes to rest. Encoders and gyroscope give the velocity over a sole that stands flat. The accelerometer shows a
push before the body turns, so for a short time its integral counts.
"""

from __future__ import annotations

import math
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.messages import SensorFrame
from bridge.types import Array, Positive, Side, Vec2
from walker.estimation.mass_over_soles import MassOverSoles
from walker.model.floating_base import SIDES, FloatingBase
from walker.model.gravity import GRAVITY
from walker.planning.plan import SIGN, Support

FREQUENCY: Final = math.sqrt(GRAVITY / 0.25)
"""rad/s; of a pendulum as high as a NAO's mass over its soles."""


class ForesightParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How far the capture point may be beyond the middle of the sole that is nearest to it."""

    ahead: Positive = 0.065
    """m; undisturbed walks of `omni` reach 0.03."""
    behind: Positive = 0.08
    """m; 0.05 in undisturbed walks."""
    outside_stance: Positive = 0.065
    """m, to the outside of a foot that stands; 0.05."""
    outside_swing: Positive = 0.045
    """m, to the outside of a foot that swings; 0.04."""
    acceleration_time: Positive = 0.2
    """Time constant with which the integral of the accelerometer is drawn to the velocity by the others, s."""
    smoothing: Positive = 0.03
    """As in `MassOverSoles`, s."""


class Foresight:
    """Follows the capture point over both soles, once per received frame.

    Args:
        parameters: the bounds. What the robot would have caught beyond them is a fall then.
        body: data sheet.
    """

    def __init__(self, parameters: ForesightParameters, body: Body) -> None:
        self._p = parameters
        self._base = FloatingBase(body)
        self._mass = {side: MassOverSoles(self._base, parameters.smoothing) for side in SIDES}
        self._velocity: dict[Side, Array] = {}

    def update(self, frame: SensorFrame, lean: Vec2, support: Support, dt: float) -> bool:
        """One cycle.

        Args:
            frame: newest sensor frame.
            lean: roll and pitch of the torso, rad.
            support: of the plan in force.
            dt: time since the last frame, s.

        Returns:
            Whether the capture point is beyond the bounds.
        """
        p = self._p
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
            bound = p.outside_stance if support in (side, "both") else p.outside_swing
            outside = outside or SIGN[side] * left > bound
        return bool(outside or min(x) > p.ahead or max(x) < -p.behind)
