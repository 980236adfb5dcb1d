"""Driving from the page: keys, gamepad and pad share one driver."""

from __future__ import annotations

import threading
from collections.abc import Callable

from bridge.errors import NaoHilError
from bridge.types import Vec3
from nao_hil.drive.session import Session, Walker


class Driving:
    """The one driver that all who look at the page share.

    Args:
        walker: Gives the walker to drive; raises LinkError without one.
        present: Whether somebody looks: the robot stops by itself when nobody does any more.
    """

    def __init__(self, walker: Callable[[], Walker], present: Callable[[], bool]) -> None:
        self._walker, self._present = walker, present
        self._lock = threading.Lock()
        self._session: Session | None = None

    def press(self, key: str) -> str:
        """Do what a key of `nao-hil drive` does.

        Returns:
            What came of it, in a sentence.

        Raises:
            LinkError: no walker takes commands.
            WalkRefused: the walker has no robot.
        """
        return self._do(lambda session: session.take([key]))

    def steer(self, velocity: Vec3) -> str:
        """Walk at a velocity, forward and to the left, m/s, and turn, rad/s; returns and raises as `press`."""
        return self._do(lambda session: session.steer(velocity))

    def _do(self, act: Callable[[Session], None]) -> str:
        with self._lock:
            if self._session is None:
                self._session = Session(self._walker())
            act(self._session)
            return self._session.reply

    def let_go(self) -> None:
        """The walker was told otherwise: give no sign of life for what was wanted before."""
        with self._lock:
            self._session = None

    def sign(self) -> None:
        """Give a sign of life if one is due; call it every second or oftener."""
        with self._lock:
            if self._session is None:
                return
            try:
                if self._present():
                    self._session.take([])
                    return
            except NaoHilError:
                pass
            self._session = None
