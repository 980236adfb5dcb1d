"""One connection of the qi messaging protocol: messages with a header of 28 bytes, in both directions.

Header: magic, number, size of the payload, version, kind, flags; then the address: service, object, action. The
first call authenticates (service 0, action 8) and exchanges capabilities; old clients leave it out.
"""

from __future__ import annotations

import asyncio
import itertools
import struct
from collections import Counter
from dataclasses import dataclass
from typing import Any, Final, Protocol

from bridge.adapters.naoqi.qi_values import QiError, decode, encode

MAGIC: Final = 0x42DEAD42
HEADER: Final = struct.Struct(">I")
ADDRESS: Final = struct.Struct("<IIHBBIII")
HEADER_SIZE: Final = 28
MAX_PAYLOAD: Final = 1 << 24
"""bytes"""
MAX_UNREAD: Final = 1 << 26
"""bytes that a client may leave unread before it is disconnected"""
MAX_LINKS: Final = 10_000
"""Events that one client may subscribe to."""
CALL, REPLY, ERROR, POST, EVENT, CAPABILITY, CANCEL, CANCELED = range(1, 9)
AUTHENTICATE: Final = 8
DYNAMIC_PAYLOAD: Final = 1
"""Flag: the payload is a dynamic value for any signature."""
MAIN: Final = 1
"""Number of a service's own object."""
CAPABILITIES: Final = {"ClientServerSocket": True, "MessageFlags": False, "MetaObjectCache": False}
"""A client's own connection may carry calls to it; payloads have the signatures of the methods."""
_AUTHENTICATED: Final = 3


@dataclass(frozen=True)
class Message:
    """One message."""

    kind: int
    number: int
    service: int
    object: int
    action: int
    payload: bytes
    flags: int = 0

    def values(self, signature: str) -> list[Any]:
        """The arguments of a call.

        Args:
            signature: of the method's parameters, a tuple or `m`.

        Raises:
            QiError: the payload does not fit.
        """
        values = decode("m" if self.flags & DYNAMIC_PAYLOAD else signature, self.payload)
        if not isinstance(values, list):
            raise QiError("the arguments of a call are no tuple")
        return values


class Listener(Protocol):
    """Handles the messages of a connection."""

    def handle(self, connection: Connection, message: Message) -> None:
        """A call or a post; may raise `QiError`."""

    def disconnected(self, connection: Connection) -> None:
        """Forget a client after the loss of its connection."""


class Connection(asyncio.Protocol):
    """One client."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self._received = bytearray()
        self._skipped = 0
        """Bytes still to come of a payload that is too long."""
        self._greeted = False
        self._numbers = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[bytes]] = {}
        self._transport: Any = None
        self.endpoint = ""
        """Address of this machine that the client uses."""
        self.takes_calls = False
        """Whether the client accepts calls over this connection."""
        self._links: dict[int, tuple[int, int, int]] = {}
        """Number of the client's link -> its event: service, object, action."""
        self._linked: Counter[tuple[int, int, int]] = Counter()

    def connection_made(self, transport: Any) -> None:
        """See `asyncio.Protocol`."""
        self._transport = transport
        host, port = transport.get_extra_info("sockname")[:2]
        self.endpoint = f"tcp://{host}:{port}"

    def connection_lost(self, _: Exception | None) -> None:
        """See `asyncio.Protocol`."""
        for waiting in self._waiting.values():
            waiting.cancel()
        self._listener.disconnected(self)

    def data_received(self, data: bytes) -> None:
        """See `asyncio.Protocol`."""
        if self._skipped:
            skipped = min(self._skipped, len(data))
            self._skipped -= skipped
            data = data[skipped:]
        self._received += data
        while (message := self._next()) is not None:
            self._dispatch(message)

    def _next(self) -> Message | None:
        received = self._received
        if len(received) < HEADER_SIZE:
            return None
        (magic,) = HEADER.unpack_from(received)
        number, size, version, kind, flags, service, target, action = ADDRESS.unpack_from(received, 4)
        if magic != MAGIC or version != 0:
            self._transport.abort()
            received.clear()
            return None
        end = HEADER_SIZE + size
        if size > MAX_PAYLOAD:
            self._skipped = max(0, end - len(received))
            del received[:end]
            message = Message(kind, number, service, target, action, b"", flags)
            self.fail(message, f"qi: the message has {size} bytes; {MAX_PAYLOAD} at most are taken.")
            return self._next()
        if len(received) < end:
            return None
        payload = bytes(received[HEADER_SIZE:end])
        del received[:end]
        return Message(kind, number, service, target, action, payload, flags)

    def _dispatch(self, message: Message) -> None:
        try:
            if message.service == 0:
                self._greet(message)
            elif message.kind in (CALL, POST):
                if not self._greeted:
                    self._greeted = True
                    self._send(CAPABILITY, 0, 0, 0, 0, encode("{sm}", CAPABILITIES))
                self._listener.handle(self, message)
            elif message.kind in (REPLY, ERROR, CANCELED):
                self._settle(message)
        except QiError as error:
            self.fail(message, f"qi: {error}.")

    def _greet(self, message: Message) -> None:
        if message.kind == CAPABILITY or message.action == AUTHENTICATE:
            offered = decode("{sm}", message.payload)
            self.takes_calls = bool(offered.get("ClientServerSocket"))
        if message.kind == CALL:
            self._greeted = True
            self.reply(message, encode("{sm}", {**CAPABILITIES, "__qi_auth_state": _AUTHENTICATED}))

    def _settle(self, message: Message) -> None:
        waiting = self._waiting.pop(message.number, None)
        if waiting is None or waiting.done():
            return
        if message.kind == REPLY:
            waiting.set_result(message.payload)
        else:
            waiting.set_exception(QiError("the client refused a call"))

    def reply(self, call: Message, payload: bytes) -> None:
        """Answer a call; a post gets no answer."""
        if call.kind == CALL:
            self._send(REPLY, call.number, call.service, call.object, call.action, payload)

    def fail(self, call: Message, sentence: str) -> None:
        """Answer a call with an error."""
        if call.kind == CALL:
            payload = encode("m", sentence)
            self._send(ERROR, call.number, call.service, call.object, call.action, payload)

    def link(self, number: int, address: tuple[int, int, int]) -> None:
        """Link an event, which is sent from now on.

        Args:
            number: of the client's link.

        Raises:
            QiError: the client has too many links.
        """
        if len(self._links) >= MAX_LINKS:
            raise QiError(f"{MAX_LINKS} events are subscribed to already")
        self.unlink(number)
        self._links[number] = address
        self._linked[address] += 1

    def unlink(self, number: int) -> None:
        """End a link, if there is one of this number."""
        address = self._links.pop(number, None)
        if address is not None:
            self._linked[address] -= 1

    def close(self) -> None:
        """Disconnect the client."""
        self._transport.abort()

    def event(self, address: tuple[int, int, int], payload: bytes) -> None:
        """Send an event once for each of the client's links to it."""
        for _ in range(self._linked[address]):
            self._send(EVENT, next(self._numbers), *address, payload)

    def call(self, service: int, action: int, payload: bytes) -> asyncio.Future[bytes]:
        """Call a method of a client's service; the payload of its reply."""
        number = next(self._numbers)
        waiting: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._waiting[number] = waiting
        self._send(CALL, number, service, MAIN, action, payload)
        return waiting

    def post(self, service: int, action: int, payload: bytes) -> None:
        """Call a method without an answer."""
        self._send(POST, next(self._numbers), service, MAIN, action, payload)

    def _send(self, kind: int, number: int, service: int, target: int, action: int, payload: bytes) -> None:
        if self._transport.is_closing():
            return
        if self._transport.get_write_buffer_size() > MAX_UNREAD:
            self._transport.abort()
            return
        head = ADDRESS.pack(number, len(payload), 0, kind, 0, service, target, action)
        self._transport.write(HEADER.pack(MAGIC) + head + payload)
