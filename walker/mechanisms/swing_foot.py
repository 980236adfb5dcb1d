"""Swing-foot orientation control: keep the swing foot's sole level when the torso tilts; not in the thesis.

Reads: lean of the torso, plan, roles of the legs, contacts; after a capture step capture point and gyroscope.
Gives: height and turn of both soles against the plan.

A NAO on one leg tilts towards its swing foot, by 7 degrees with the backlash and compliance of a used robot.
The swing foot then lands 12 mm early and tilted. The admittances know the plan only and would take this for the
ground; held in stance, the tilt would stay and grow with every step. So the swing foot is turned about the
stance foot against the measured angle of the torso while it is in the air, and the admittances see the ground
alone. In double support the turn returns to zero, and the legs push the torso upright as planned.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import msgspec

from bridge.planar import Pose2D
from bridge.types import SIDES, Fraction, Positive, Side, Vec2, Vec3
from walker.estimation.contact import Contacts, SupportState
from walker.functions import clip, smoothstep
from walker.gaits.plan import OTHER_SIDE, LandedFoot, Plan
from walker.mechanisms.capture_step import LandedFootBalance, LandedFootParameters

APEX: Final = 0.5
"""Fraction of the swing at which the foot is highest."""


class SwingFootOrientationParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gain and bounds of the swing-foot orientation control."""

    gain: Fraction = 1.0
    """Fraction of the measured angle that is compensated."""
    max_angle: Positive = math.radians(12.0)
    """Largest turn about an axis, rad: 12 degrees of roll lift the foot by 20 mm."""
    level_angle: Positive = 0.45
    """The same of a foot that is to be level in a capture step, all of the angle."""
    max_rate: Positive = 1.5
    """Fastest change in the air, rad/s."""
    return_rate: Positive = 0.2
    """Speed at which the turn returns to zero once the foot is down, rad/s: 7 degrees in 0.6 s."""
    capture_roll_return_rate: Positive = 0.1
    """The same of the roll after a capture step, rad/s: a leg that rights the torso sideways at once throws it
    over the other foot, which hangs in the air meanwhile."""
    standing_roll_return_rate: Positive = 0.3
    """The same once the robot stands on both feet (`LandedFootBalance.stands`), rad/s: the turn must be back
    before the feet close, since it changes the length of a leg."""
    capture_pitch_return_rate: Positive = 0.4
    """The same of the pitch after a capture step ahead, rad/s: a leg that rights the torso at once throws it
    over the heels. A step back has `return_rate`: behind the ankle the sole is too short to wait."""


class SwingFootCorrection(NamedTuple):
    """Correction of one foot's planned pose."""

    lift: float = 0.0
    """Height, m."""
    roll: float = 0.0
    """Roll of the sole, rad, right-handed."""
    pitch: float = 0.0
    """Pitch of the sole, rad, positive toe down."""


class SwingFootOrientation:
    """Turns of both feet against the measured angle of the torso.

    Args:
        parameters: gain and bounds.
        landed: of the balance over a foot that landed from a capture step.
    """

    def __init__(self, parameters: SwingFootOrientationParameters, landed: LandedFootParameters) -> None:
        self._p = parameters
        self._balance = LandedFootBalance(landed)
        self._turn: dict[Side, Vec2] = {"L": (0.0, 0.0), "R": (0.0, 0.0)}

    def update(
        self,
        angle: Vec2,
        plan: Plan,
        support_state: SupportState,
        contacts: Contacts,
        dt: float,
        *,
        landed: LandedFoot | None = None,
        gyroscope: Vec3 = (0.0, 0.0, 0.0),
    ) -> dict[Side, SwingFootCorrection]:
        """One cycle.

        Args:
            angle: measured roll and pitch of the torso, rad.
            plan: the plan.
            support_state: roles of the legs.
            contacts: of the feet.
            dt: time since the last cycle, s.
            landed: measured after a capture step.
            gyroscope: angular velocity in the Torso frame, rad/s.
        """
        self._balance.update(plan, contacts, landed, gyroscope, dt)
        damping = self._balance.damping
        feet = {"L": plan.left, "R": plan.right}
        corrections: dict[Side, SwingFootCorrection] = {}
        for side in SIDES:
            if plan.capture is None:
                turn = self._next(side, angle, support_state, contacts.of(side), dt)
            elif plan.support == "both":
                turn = self._after_capture_step(side, plan.capture, dt, back=plan.captures_backward)
            elif plan.capture == side:
                turn = self._towards(side, angle, 1.0, self._p.level_angle, dt)
            else:
                turn = self._next(side, angle, support_state, contacts.of(side), dt)
            self._turn[side] = turn
            roll, pitch = turn[0] + damping[0], turn[1] + damping[1]
            foot, other = feet[side], feet[OTHER_SIDE[side]]
            # The torso's angles are about axes that head along the mean of both soles.
            ahead, across = Pose2D(other.x, other.y, plan.middle.yaw).local(foot.x, foot.y)
            # In a capture step one foot is turned about the other one, not each about the other.
            lift = roll * across - pitch * ahead if plan.capture in (None, side) else 0.0
            corrections[side] = SwingFootCorrection(lift, roll, pitch)
        return corrections

    def _after_capture_step(self, side: Side, landed: Side, dt: float, *, back: bool) -> Vec2:
        """Correction of the foot that landed; the other one turns into the plane of that sole."""
        p = self._p
        goal = (0.0, 0.0) if side == landed else self._turn[landed]
        rates = p.return_rate, p.return_rate
        if side == landed:
            rates = (
                p.standing_roll_return_rate if self._balance.stands else p.capture_roll_return_rate,
                p.return_rate if back else p.capture_pitch_return_rate,
            )
        roll, pitch = (
            now + clip(to - now, -rate * dt, rate * dt)
            for now, to, rate in zip(self._turn[side], goal, rates, strict=True)
        )
        if side == landed and self._balance.roll is not None:
            now, step = self._turn[side][0], p.max_rate * dt
            roll = now + clip(self._balance.roll - now, -step, step)
        return roll, pitch

    def _next(self, side: Side, angle: Vec2, support_state: SupportState, contact: bool, dt: float) -> Vec2:
        p, (roll, pitch) = self._p, self._turn[side]
        if support_state.role(side) == "stance":
            step = p.return_rate * dt
            return roll - clip(roll, -step, step), pitch - clip(pitch, -step, step)
        if contact and support_state.progress > APEX:
            return roll, pitch  # in contact the torso's turn is no longer the foot's
        return self._towards(side, angle, p.gain * smoothstep(support_state.progress / APEX), p.max_angle, dt)

    def _towards(self, side: Side, angle: Vec2, gain: float, bound: float, dt: float) -> Vec2:
        step = self._p.max_rate * dt
        wanted = (-gain * clip(a, -bound, bound) for a in angle)
        return tuple(  # type: ignore[return-value]
            now + clip(goal - now, -step, step) for now, goal in zip(self._turn[side], wanted, strict=True)
        )
