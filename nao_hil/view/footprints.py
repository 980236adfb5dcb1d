"""Outlines of the soles where feet were meant to come down, and where they did."""

from __future__ import annotations

from typing import Final, Literal, NamedTuple

import numpy as np

from bridge.body.kinematics import FloatingBase
from bridge.rotations import heading
from bridge.types import SIDES, Array, Side
from nao_hil.analysis.diagnosis import Balance
from walker.estimation.odometry import on_ground
from walker.gaits.plan import Foothold

Kind = Literal["planned", "made"]

NEAR: Final = 0.004
"""An outline this close to the last one of its kind is the same, m."""


class Footprint(NamedTuple):
    """One outline."""

    kind: Kind
    corners: Array
    """World frame, shape (n, 2), m."""


class Footprints:
    """Follows the feet of a robot.

    Args:
        kinematics: Of its body.
    """

    def __init__(self, kinematics: FloatingBase) -> None:
        self._kinematics = kinematics
        self._down: dict[tuple[Kind, Side], bool] = {}
        self._last: dict[Kind, Array] = {}

    def update(self, balance: Balance) -> list[Footprint]:
        """What the next moment adds."""
        found: list[Footprint] = []
        for side in SIDES:
            foot = balance.best.robot.feet[side]
            at = Foothold(float(foot[0, 3]), float(foot[1, 3]), heading(foot))
            found += self._touch("made", side, balance.best.contacts.of(side), at)
            if balance.plan is not None:
                found += self._touch("planned", side, balance.plan.lift[side] < 1e-4, balance.plan.soles[side])
        return found

    def _touch(self, kind: Kind, side: Side, down: bool, at: Foothold) -> list[Footprint]:
        before, self._down[kind, side] = self._down.get((kind, side), False), down
        if not down or before:
            return []
        corners = (self._kinematics.soles[side] @ on_ground(at).T)[:, :2]
        last = self._last.get(kind)
        if last is not None and np.abs(last[0] - corners[0]).max() < NEAR:
            return []
        self._last[kind] = corners
        return [Footprint(kind, corners)]
