"""Which feet touch the ground, from the force sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import msgspec

from bridge.types import Positive, Side


class ContactParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When a foot counts as touching the ground, by the sum of its four force sensors."""

    on: Positive = 3.0
    """Sum above which a foot that was in the air touches, N: 6 % of the weight, over the sensors' noise and
    below the 5 N that the leg admittance lets come up."""
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
