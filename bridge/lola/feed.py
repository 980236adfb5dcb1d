"""The robot's half of a served LoLA: its newest frame, and the lease, kept by a thread of their own.

The loop that serves the socket must never wait for the robot: asking for the lease may take a second when the
robot is slow to answer. So this thread listens and asks; the loop reads what it left, and is woken by a byte.
"""

from __future__ import annotations

import contextlib
import logging
import socket
import threading
import time
from types import TracebackType
from typing import NamedTuple

from bridge.errors import FrameError, LeaseRefused, LinkError
from bridge.link import ControllerLink
from bridge.messages import SensorFrame

logger = logging.getLogger(__name__)

_LISTEN = 0.1
"""s between two looks at everything else while no frame comes."""
_ASK_AGAIN = 1.0
"""s between two requests for a lease that somebody else holds."""


class Arrival(NamedTuple):
    """A sensor frame and when it came."""

    frame: SensorFrame
    at: int
    """Monotonic clock, ns."""


class RobotFeed:
    """Listens to a robot until it goes away; a context manager.

    Args:
        link: whose `wait_robot` has found the robot.
        lockstep: every frame counts, also one that is repeated; otherwise only the newest.
    """

    def __init__(self, link: ControllerLink, *, lockstep: bool) -> None:
        self._link = link
        self._receive = link.next if lockstep else link.latest
        self.wanted = False
        """Whether the lease is to be held."""
        self.deserted = False
        """The lease that is not wanted any more was not given back in good order: the robot is still stiff."""
        self.gone = False
        """The robot went away."""
        self.newest: Arrival | None = None
        """The newest frame so far."""
        self._ask_at = 0.0
        self._ended = threading.Event()
        self._bell, self.bell = socket.socketpair()
        """Readable when a frame came, the lease was granted, or the robot is gone."""
        self._bell.setblocking(False)
        self.bell.setblocking(False)
        self._thread = threading.Thread(target=self._run, name="lola-feed", daemon=True)

    def heard(self) -> None:
        """Empty the bell."""
        with contextlib.suppress(BlockingIOError):
            while self.bell.recv(4096):
                pass

    def ring(self) -> None:
        """Wake the loop; any thread or signal handler may call this."""
        with contextlib.suppress(OSError):  # it is full, so the loop is woken anyway, or the loop has ended
            self._bell.send(b"!")

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                frame = self._receive(_LISTEN)
            except FrameError as error:
                logger.warning("%s", error)
                continue
            if frame is not None:
                self.newest = Arrival(frame, time.monotonic_ns())
                self.ring()
            if not self._link.robot_alive:
                self.gone = True
                self.ring()
                return
            self._heed_notices()
            self._mind_lease()
        self._leave()

    def _leave(self) -> None:
        if self.deserted:
            self._link.desert()
        else:
            self._link.release()

    def _heed_notices(self) -> None:
        for notice in self._link.notices():
            logger.warning("the robot says: %s", notice.text)
            if notice.code == "no-lease":
                self._link.lease = 0  # it was given to another, or withdrawn

    def _mind_lease(self) -> None:
        if not self.wanted:
            self._leave()
        elif not self._link.lease and time.monotonic() >= self._ask_at:
            try:
                self._link.acquire()
                self.ring()
            except LeaseRefused as error:
                self._ask_at = time.monotonic() + _ASK_AGAIN
                logger.warning("%s", error)
            except LinkError:
                pass  # it does not answer; asked again at the next look

    def __enter__(self) -> RobotFeed:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()
        self._link.wake()
        self._thread.join()
        self._bell.close()
        self.bell.close()
