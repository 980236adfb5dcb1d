"""Which feet touch the ground, from the force sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from bridge.datasheet.model import Side

if TYPE_CHECKING:  # the parameters' types import this package's own
    from walker.parameters.model import ContactParameters


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
