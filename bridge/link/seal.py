"""Seals: the proof that a message is of the controller with a public key, and comes for the first time.

Robot and controller agree on a secret by X25519 (RFC 7748) from public keys, which anyone may read; the secret
itself never crosses the link. A sealed message carries, as Zenoh's attachment, a count and the HMAC-SHA256
(RFC 2104) of count, key expression and payload under that secret.
"""

from __future__ import annotations

import hashlib
import hmac
import itertools
import threading
from collections.abc import Callable, Iterator
from typing import Final, TypeVar

from bridge.errors import LinkError

T = TypeVar("T")
_COUNT_SIZE: Final = 8
"""bytes, big-endian."""


class KeyPair:
    """A private key of this process, and its public key `public`: 64 hexadecimal digits."""

    def __init__(self) -> None:
        from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey  # not loaded by `--help`

        self._private = X25519PrivateKey.generate()
        self._counts = itertools.count(1)  # goes on when the peer changes and comes back
        self.public = self._private.public_key().public_bytes_raw().hex()

    def seal(self, peer: str) -> Seal:
        """The seal shared with the owner of a public key.

        Raises:
            LinkError: it is no such key.
        """
        from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PublicKey

        try:
            secret = self._private.exchange(X25519PublicKey.from_public_bytes(bytes.fromhex(peer)))
        except ValueError:
            raise LinkError(f"{peer!r} is no public key; 64 digits of an X25519 key are expected.") from None
        return Seal(peer, hashlib.sha256(secret).digest(), self._counts)


class Seal:
    """Seals messages to one peer, or checks the peer's. Thread-safe.

    Args:
        peer: public key of the other side.
        secret: known to both sides only.
        counts: of the messages to seal, rising.
    """

    def __init__(self, peer: str, secret: bytes, counts: Iterator[int]) -> None:
        self.peer = peer
        self._secret = secret
        self._lock = threading.Lock()
        self._counts = counts
        self._newest: dict[str, int] = {}
        """Count of the newest message, by key expression: those of two keys may overtake each other."""
        self._first = -1
        """Count of the first message; a robot that forgot a controller takes nothing from before."""

    def send(self, key: str, payload: bytes, send: Callable[[bytes], T]) -> T:
        """Call `send` with the attachment of a message; messages leave in the order of their counts."""
        with self._lock:
            return send(self._attachment(next(self._counts).to_bytes(_COUNT_SIZE, "big"), key, payload))

    def opens(self, key: str, payload: bytes, attachment: bytes) -> bool:
        """Whether the peer sealed this message, and it is newer than the last one of its key."""
        number = attachment[:_COUNT_SIZE]
        if not hmac.compare_digest(attachment, self._attachment(number, key, payload)):
            return False
        count = int.from_bytes(number, "big")
        with self._lock:
            if count <= self._newest.get(key, self._first):
                return False
            self._newest[key] = count
            if self._first < 0:
                self._first = count
            return True

    def _attachment(self, number: bytes, key: str, payload: bytes) -> bytes:
        return number + hmac.digest(self._secret, number + key.encode() + payload, "sha256")
