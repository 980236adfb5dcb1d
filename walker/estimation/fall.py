"""Is the robot falling?"""

from __future__ import annotations

from typing import TYPE_CHECKING

from walker.estimation.contact import Contacts

if TYPE_CHECKING:  # the parameters' types import this package's own
    from walker.parameters.model import FallParameters


class FallDetector:
    """A fall is a torso that leans too far, or a walk without ground under it for too long.

    Args:
        parameters: the bounds.
    """

    def __init__(self, parameters: FallParameters) -> None:
        self._p = parameters
        self._unsupported = 0.0

    def update(self, angle: tuple[float, float], contacts: Contacts, dt: float, *, walking: bool) -> bool:
        """One cycle.

        Args:
            angle: fused torso roll and pitch, rad.
            contacts: of the feet.
            dt: time since the last frame, s.
            walking: whether the feet are meant to bear the robot; a robot that hangs in a stand is not falling.

        Returns:
            Whether it falls.
        """
        self._unsupported = self._unsupported + dt if walking and contacts.none else 0.0
        return max(map(abs, angle)) > self._p.angle or self._unsupported > self._p.no_support
