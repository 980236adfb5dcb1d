"""Sitting down from the crouch: the body's motion, then the ramp of the stiffness."""

from __future__ import annotations

from bridge.body import Body
from bridge.body.joints import N_JOINTS
from bridge.guard.config import CrouchSettings
from bridge.guard.descent import Descent
from bridge.messages import SensorFrame
from bridge.motion import Motion, MotionPlayer


class SitDown:
    """Plays the motion to its end, then lets go.

    Args:
        motion: of this body, from a stand or a crouch to the seat.
        body: data sheet; its cycle is the time between two frames.
        settings: of the ramp of the stiffness, and its end.
    """

    def __init__(self, motion: Motion, body: Body, settings: CrouchSettings) -> None:
        self._player, self._cycle, self._settings = MotionPlayer(motion, body), body.cycle, settings
        self._release: Descent | None = None

    @property
    def done(self) -> bool:
        """The stiffness is down."""
        return self._release is not None and self._release.done

    def advance(self, frame: SensorFrame) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Positions and stiffnesses of the next cycle.

        Args:
            frame: of the present boundary.
        """
        player = self._player
        if not player.done:
            return player.advance(frame, self._cycle), (player.stiffness,) * N_JOINTS
        if self._release is None:
            position, stiffness = player.position, (player.stiffness,) * N_JOINTS
            self._release = Descent(
                position, stiffness, position, self._settings, self._cycle, moving=False, standing=True
            )
        return self._release.advance(frame)
