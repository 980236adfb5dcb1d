"""Messages between the serving process and the one that draws for its cameras, over a socket pair."""

from __future__ import annotations

import contextlib
import socket
import struct
import threading
from typing import Any, Final

import msgspec

_LENGTH: Final = struct.Struct("!I")
MAX_MESSAGE: Final = 1 << 24
"""bytes"""


class Unsendable(Exception):
    """A message that the other end could not read; one sentence."""


class Pipe:
    """One end; any thread may send, one receives.

    Args:
        end: connected stream socket.
    """

    def __init__(self, end: socket.socket) -> None:
        self._socket = end
        self._stream = end.makefile("rb")
        self._lock = threading.Lock()
        self._encoder = msgspec.msgpack.Encoder()
        self._decoder = msgspec.msgpack.Decoder()

    def send(self, message: list[Any]) -> None:
        """Send one message; nothing happens when the other end is gone.

        Raises:
            Unsendable: something in it is no number, text, list or map, or it is too large or too deep.
        """
        try:
            payload = self._encoder.encode(message)
        except (TypeError, ValueError, OverflowError, RecursionError) as error:
            raise Unsendable(f"{error}") from None
        if len(payload) > MAX_MESSAGE:
            raise Unsendable(f"{len(payload)} bytes are more than {MAX_MESSAGE}")
        with self._lock:
            try:
                self._socket.sendall(_LENGTH.pack(len(payload)) + payload)
            except OSError:
                return

    def receive(self) -> list[Any] | None:
        """The next message that can be read; None when the other end is gone."""
        while True:
            payload = self._payload()
            if payload is None:
                return None
            try:
                message: list[Any] = self._decoder.decode(payload)
            except (msgspec.DecodeError, ValueError, RecursionError):
                continue  # not in UTF-8, or a level deeper than fits on the stack of this end
            return message

    def _payload(self) -> bytes | None:
        try:
            head = self._stream.read(_LENGTH.size)
            if len(head) < _LENGTH.size:
                return None
            (length,) = _LENGTH.unpack(head)
            payload = self._stream.read(length) if length <= MAX_MESSAGE else b""
        except (OSError, ValueError):  # ValueError: this end was closed meanwhile
            return None
        return payload if len(payload) == length else None

    def close(self) -> None:
        """Close this end; a `receive` in another thread ends."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
