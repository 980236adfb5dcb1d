"""A symptom before a fall, and the conditions on how long its sign must last."""

from __future__ import annotations

import math
from typing import Final, Literal, NamedTuple

from bridge.stance import FALLEN_TILT
from nao_hil.analysis.diagnosis.balance import Balance, Stand

Kind = Literal["world", "zmp", "slip", "late", "early", "missed", "tilt", "fall"]


EDGE: Final = 0.003
"""Margin under which the zero moment point is at the edge of the support polygon, m."""


LOST: Final = 0.03
"""Distance of the capture point beyond the polygon from which the feet alone do not bring it back, m."""


GAP: Final = 0.05
"""Interruption that does not end a sign, s."""


class Symptom(NamedTuple):
    """Something that went wrong, or was done to the robot."""

    time: float
    """When it began, robot time, s."""
    kind: Kind
    text: str
    """Text for people, without the time."""


class LastingSign:
    """A condition that must last before it counts, and counts once until it has ended."""

    def __init__(self, lasting: float) -> None:
        self._lasting = lasting
        self._began: float | None = None
        self._seen = 0.0
        self._reported = False

    def update(self, time: float, present: bool) -> float | None:
        """The time it began, in the cycle in which it has lasted long enough; None otherwise."""
        if present:
            if self._began is None:
                self._began = time
            self._seen = time
        elif self._began is not None and time - self._seen > GAP:
            self._began, self._reported = None, False
        if self._began is None or self._reported or self._seen - self._began < self._lasting - 1e-9:
            return None
        self._reported = True
        return self._began


class TippingSign:
    """The zero moment point is pinned to the edge and the capture point runs away beyond it."""

    def __init__(self, lasting: float) -> None:
        self._edge = LastingSign(0.0)
        self._lost = LastingSign(lasting)
        self._began = 0.0

    def update(self, time: float, stand: Stand) -> float | None:
        """When the zero moment point came to the edge, once it is a symptom."""
        at_edge = stand.margin is None or stand.margin < EDGE
        beyond = stand.support is not None and stand.support.margin(stand.capture) < 0.0
        began = self._edge.update(time, at_edge and beyond)
        if began is not None:
            self._began = began
        lost = stand.support is not None and stand.support.margin(stand.capture) < -LOST
        return self._began if self._lost.update(time, lost and at_edge) is not None else None


def lean_angle(balance: Balance) -> float:
    """Of the torso from the vertical, rad."""
    return math.acos(min(max(float(balance.best.robot.frames[0][2, 2]), -1.0), 1.0))


def fallen(balance: Balance, lean: float) -> bool:
    """Whether the robot is beyond help: by the ground truth, else by its lean (rad) or its walker's word."""
    if balance.moment.truth is not None:
        return balance.moment.truth.fell
    walk = balance.moment.walk
    return lean > FALLEN_TILT or (walk is not None and walk.state == "fallen")
