"""A thread that receives a served robot's frames and holds its lease.

The loop that serves the socket must never wait for the robot, whose answer to a request for the lease may take
a second. This thread receives and requests; it wakes the loop with a byte on a socket pair.
"""

from __future__ import annotations

import contextlib
import logging
import socket
import threading
import time
from types import TracebackType
from typing import Final, NamedTuple

from bridge.errors import FrameError, LeaseRefused, LinkError
from bridge.link import ControllerLink
from bridge.messages import SensorFrame
from bridge.recording.observer import log_notice

logger = logging.getLogger(__name__)

_RECEIVE_TIMEOUT: Final = 0.1
"""s to wait for a frame before the robot's presence, notices and lease are checked again."""
_LEASE_INTERVAL: Final = 1.0
"""s between two requests for a lease that another controller holds."""


class Arrival(NamedTuple):
    """A sensor frame and its time of arrival."""

    frame: SensorFrame
    at: int
    """Monotonic clock, ns."""


class RobotListener:
    """Listens to a robot until its token disappears; a context manager.

    Args:
        link: with a robot found by `wait_robot`.
        lockstep: every frame counts, also a repeated one; otherwise only the newest.
    """

    def __init__(self, link: ControllerLink, *, lockstep: bool) -> None:
        self._link = link
        self._receive = link.next if lockstep else link.latest
        self.lease_wanted = False
        """Whether the lease is to be held."""
        self.abandoned = False
        """The lease ends with a stiff robot, which its guard is to bring down."""
        self.lost = False
        """The robot's token has disappeared."""
        self.newest: Arrival | None = None
        """The newest frame so far."""
        self.held: tuple[float, ...] = ()
        """25 joint angles that the robot held when the lease was granted, rad; see `ControllerLink.held`."""
        self._next_request = 0.0
        self._ended = threading.Event()
        self._waker, self.wakeup = socket.socketpair()
        """`wakeup` is readable after a frame, the grant of the lease, or the loss of the robot."""
        self._waker.setblocking(False)
        self.wakeup.setblocking(False)
        self._thread = threading.Thread(target=self._run, name="lola-robot", daemon=True)

    def clear_wakeup(self) -> None:
        """Make `wakeup` unreadable until the next event."""
        with contextlib.suppress(BlockingIOError):
            while self.wakeup.recv(4096):
                pass

    def _wake(self) -> None:
        with contextlib.suppress(OSError):  # full, so the loop wakes anyway; or the loop has ended
            self._waker.send(b"!")

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                frame = self._receive(_RECEIVE_TIMEOUT)
            except FrameError as error:
                logger.warning("%s", error)
                continue
            if frame is not None:
                self.newest = Arrival(frame, time.monotonic_ns())
                self._wake()
            if not self._link.robot_alive:
                self.lost = True
                self._wake()
                return
            self._read_notices()
            self._update_lease()
        self._give_up_lease()

    def _give_up_lease(self) -> None:
        if self.abandoned:
            self._link.abandon()
        else:
            self._link.release()

    def _read_notices(self) -> None:
        for notice in self._link.notices():
            log_notice(logger, notice)
            if notice.code == "no-lease":
                self._link.lease = 0  # another controller has it, or it is withdrawn

    def _update_lease(self) -> None:
        if not self.lease_wanted:
            self._give_up_lease()
        elif not (self._link.lease and self.held) and time.monotonic() >= self._next_request:
            try:
                if not self._link.lease:
                    self.held = ()  # of an earlier lease
                    self._link.acquire()
                self.held = (self._link.held() or self.newest.frame.position) if self.newest else ()
                self._wake()
            except LeaseRefused as error:
                self._next_request = time.monotonic() + _LEASE_INTERVAL
                logger.warning("%s", error)
            except LinkError:
                pass  # no answer; the next round repeats the request

    def __enter__(self) -> RobotListener:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()
        self._link.wake()
        self._thread.join()
        self._waker.close()
        self.wakeup.close()
