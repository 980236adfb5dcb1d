"""Which feet touch the ground, where the zero moment point is, and which leg bears the weight.

The force sensors give contacts and zero moment point. Plan and contacts together give the support: the phases
of the plan keep the thesis' times, and touch-down may be early or late.

- *Early*: the swing foot touches before its single support ends. The phase continues, the foot stays a swing
  foot; the leg admittance gives way to the ground as fast as the plan presses against it, so the foot descends
  no further, and it ends as high above the plan as the obstacle is.
- *Late*: the single support ends and the foot touches nothing. The foot stays a swing foot and is lowered
  further, while the plan waits for it if the gait can wait. Both are bounded: then the foot counts as landed,
  and the fall detector judges the rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import msgspec
import numpy as np

from bridge.body.kinematics import Transform
from bridge.body.model import Body
from bridge.types import Array, NotNegative, Positive, Side
from walker.gaits.plan import OTHER_SIDE, Plan, Support


class ContactParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Thresholds of a foot's contact, on the sum of its four force sensors."""

    on: Positive = 3.0
    """Sum above which a foot in the air counts as touching, N: 6 % of the weight, over the sensors' noise and
    below the 5 N that the leg admittance lets build up."""
    off: Positive = 1.5
    """Sum below which a foot that touched is in the air, N."""

    def __post_init__(self) -> None:
        if self.off >= self.on:
            raise ValueError(f"off = {self.off} N must be less than on = {self.on} N")


class Contacts(NamedTuple):
    """Which feet touch the ground."""

    left: bool
    right: bool

    def of(self, side: Side) -> bool:
        """One foot."""
        return self.left if side == "L" else self.right

    @property
    def none(self) -> bool:
        """Both feet are in the air."""
        return not (self.left or self.right)


class ContactEstimator:
    """Contact of both feet with hysteresis, so that noise about one threshold does not make it chatter.

    Args:
        parameters: the two thresholds.
    """

    def __init__(self, parameters: ContactParameters) -> None:
        self._p = parameters
        self._contacts = Contacts(False, False)

    def update(self, fsr: Sequence[float]) -> Contacts:
        """One cycle; `fsr` are the eight forces of a frame, left foot first, N."""
        left, right = self._contacts
        self._contacts = Contacts(self._touches(left, sum(fsr[:4])), self._touches(right, sum(fsr[4:])))
        return self._contacts

    def _touches(self, before: bool, force: float) -> bool:
        return force > (self._p.off if before else self._p.on)


class FootForces:
    """Zero moment points from the four force sensors of each foot.

    Args:
        body: The data sheet: places of the sensors.
        min_force: Force below which a foot, or both together, bear no load worth a place, N.
    """

    def __init__(self, body: Body, min_force: float = 1.0) -> None:
        self._places: dict[Side, Array] = {
            "L": np.column_stack([np.array(body.fsr.L), np.ones(4)]),
            "R": np.column_stack([np.array(body.fsr.R), np.ones(4)]),
        }
        self._min_force = min_force

    def zmp(self, fsr: Sequence[float], feet: Mapping[Side, Transform]) -> Array | None:
        """Zero moment point of the supporting feet, shape (3,), m; None without load.

        The mean of the sensors' places, weighted with the vertical parts of their forces: exact for soles in
        one horizontal plane, otherwise the usual approximation.

        Args:
            fsr: A sensor frame's eight forces: left FL, FR, RL, RR, then right, N.
            feet: Poses of the feet to count (frame 8, AnkleRoll), shape (4, 4), m, in one frame with z up.
        """
        forces = {"L": fsr[:4], "R": fsr[4:]}
        return self._mean([(side, pose, forces[side]) for side, pose in feet.items()])

    def _mean(self, loads: Sequence[tuple[Side, Transform, Sequence[float]]]) -> Array | None:
        total, moment = 0.0, np.zeros(3)
        for side, pose, forces in loads:
            upward = np.maximum(forces, 0.0) * pose[2, 2]
            moment += (upward @ self._places[side]) @ pose[:3].T
            total += float(upward.sum())
        return moment / total if self._min_force < total < math.inf else None


Role = Literal["swing", "stance"]


class TouchDownParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Behaviour when the plan puts a foot down where there is no ground."""

    max_wait: NotNegative = 0.0
    """Time for which the plan waits for the ground, s."""
    search_depth: NotNegative = 0.010
    """Depth to which the foot is lowered beyond `leg.target_depth` in search of the ground, m."""
    search_rate: Positive = 0.04
    """Speed of that, m/s."""


class SupportState(NamedTuple):
    """Leg that bears the weight in this cycle, and progress of the other one's swing."""

    support: Support
    """The leg that bears the weight."""
    progress: float = 1.0
    """Fraction of the swing that has passed, 0..1; 1 for a foot that should have landed."""
    search_depth: float = 0.0
    """Depth to which the swing foot is lowered in search of late ground, m."""
    wait: bool = False
    """The plan is to wait for the swing foot."""

    def role(self, side: Side) -> Role:
        """Role of one leg, for its admittance."""
        return "stance" if self.support in (side, "both") else "swing"


class SupportStateMachine:
    """Follows the plan's supports, and keeps a foot in its swing until it has landed.

    Args:
        parameters: bounds of the search for late ground; None: the plan is believed.
    """

    def __init__(self, parameters: TouchDownParameters | None) -> None:
        self._p = parameters
        self._landing: Side | None = None
        self._late = 0.0

    def update(self, plan: Plan, contacts: Contacts, dt: float) -> SupportState:
        """One cycle.

        Args:
            plan: the plan.
            contacts: of the feet.
            dt: time since the last cycle, s.
        """
        if self._p is None or plan.support != "both":
            if plan.support != "both":
                self._landing, self._late = OTHER_SIDE[plan.support], 0.0
            return SupportState(plan.support, plan.progress)
        if self._landing is None or contacts.of(self._landing):
            return self._landed()
        self._late += dt
        if self._late > max(self._p.max_wait, self._p.search_depth / self._p.search_rate):
            return self._landed()
        return SupportState(
            OTHER_SIDE[self._landing],
            search_depth=min(self._p.search_rate * self._late, self._p.search_depth),
            wait=self._late <= self._p.max_wait,
        )

    def _landed(self) -> SupportState:
        self._landing = None
        return SupportState("both")
