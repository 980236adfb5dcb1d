"""The lease: one controller at a time may command the robot.

A controller is known by its public key, also in its liveliness token, so two controllers of the same name
are still two; the caller checks the seals of its requests (`bridge.link.seal`). The lease ends when it is given
back, when the holder's liveliness token disappears, when another asks after `SILENCE_LIMIT`, or when the guard
withdraws it. A holder whose token disappeared gets the same lease back if no other controller has held the
robot since.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Final

from bridge.link.seal import KeyPair, Seal
from bridge.messages import LeaseReply

SILENCE_LIMIT: Final = 3.0
"""s of wall clock without a frame of the holder, after which another controller may take over."""


@dataclass(frozen=True, slots=True)
class Holder:
    """The controller that holds the robot."""

    name: str
    seal: Seal
    lease: int
    direct: bool = False
    """As in `LeaseRequest`."""


class LeaseBook:
    """Keeps the one lease. Thread-safe; times come from the caller.

    Args:
        first: number before the first lease; differs from start to start, so that a controller of an earlier
            start is not obeyed.
    """

    def __init__(self, first: int) -> None:
        self._keys = KeyPair()
        self._lock = threading.Lock()
        self._last = first
        self._holder: Holder | None = None
        self._lost: Holder | None = None
        """The last holder, after its session broke off and before the next lease."""
        self._last_sign = 0.0
        self.abandoned = False
        """The last lease ended without a release: the holder died, or the lease was withdrawn."""

    @property
    def holder(self) -> Holder | None:
        """Controller that holds the robot."""
        return self._holder

    def seal(self, key: str) -> Seal:
        """The seal of the controller with this public key; the holder's, and the lost holder's, is kept.

        Raises:
            LinkError: it is no such key.
        """
        with self._lock:
            for known in (self._holder, self._lost):
                if known is not None and known.seal.peer == key:
                    return known.seal
        return self._keys.seal(key)

    def acquire(self, name: str, seal: Seal, now: float, *, direct: bool = False) -> LeaseReply:
        """Grant the lease, or refuse it naming the holder; the holder itself gets the same lease again.

        Args:
            name: of the controller.
            seal: of its public key.
            now: monotonic time, s.
            direct: as in `LeaseRequest`.
        """
        with self._lock:
            holder = self._holder
            if holder is not None and holder.seal.peer == seal.peer:
                self._last_sign = now
                return self._reply(True, f"`{name}` holds the robot.")
            if holder is not None and now - self._last_sign <= SILENCE_LIMIT:
                return self._reply(
                    False,
                    f"The robot is held by controller `{holder.name}`; stop that one first, or wait until it "
                    f"has been silent for {SILENCE_LIMIT:g} s.",
                )
            if self._lost is not None and self._lost.seal.peer == seal.peer:
                self._holder = self._lost  # its session broke off: the same lease, so that its walk continues
            else:
                self._last += 1
                self._holder = Holder(name, seal, self._last, direct)
            self._lost = None
            self.abandoned = False
            self._last_sign = now
            return self._reply(True, f"`{name}` holds the robot.")

    def release(self, seal: Seal) -> LeaseReply:
        """Give the lease back; only its holder can."""
        with self._lock:
            if self._holder is not None and self._holder.seal.peer == seal.peer:
                self._holder = None
            return self._reply(
                False,
                "Another controller holds the robot." if self._holder else "No controller holds the robot.",
            )

    def status(self) -> LeaseReply:
        """Name of the holder."""
        with self._lock:
            return self._reply(
                False, "No controller holds the robot." if self._holder is None else "The robot is held."
            )

    def on_token_lost(self, key: str) -> bool:
        """End the lease of a public key whose liveliness token disappeared; whether there was one."""
        with self._lock:
            ended = self._holder is not None and self._holder.seal.peer == key
            if ended:
                self.abandoned, self._lost, self._holder = True, self._holder, None
            return ended

    def revoke(self) -> None:
        """Withdraw the lease; its holder may ask again."""
        with self._lock:
            self._lost = None
            if self._holder is not None:
                self.abandoned, self._holder = True, None

    def keepalive(self, lease: int, now: float) -> bool:
        """Count a frame as a sign of life; whether it is the holder's.

        Args:
            lease: number in the frame.
            now: monotonic time, s.
        """
        with self._lock:
            if self._holder is None or self._holder.lease != lease:
                return False
            self._last_sign = now
            return True

    def _reply(self, granted: bool, message: str) -> LeaseReply:
        holder = self._holder
        return LeaseReply(
            granted=granted,
            lease=holder.lease if granted and holder else 0,
            holder=holder.name if holder else "",
            key=self._keys.public,
            message=message,
        )
