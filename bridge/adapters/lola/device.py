"""A connection to a robot's LoLA: its packets in, commands out."""

from __future__ import annotations

import select
import time
from collections.abc import Sequence
from typing import Final, NamedTuple

from bridge.adapters.lola.address import Address, connect
from bridge.adapters.lola.codec import Map, MapStream
from bridge.adapters.lola.packets import actuator_map
from bridge.adapters.lola.schema import SENSORS
from bridge.errors import LinkError

SILENCE: Final = 1.0
"""s without a packet after which a LoLA is taken to be gone."""
_CONNECT: Final = 1.0
"""s an attempt to connect may take."""
_SEND: Final = 0.2
"""s a command may take; a LoLA that takes none for so long has gone."""
_READ: Final = 65536


class Packets(NamedTuple):
    """The packets that have come since the last ones were asked for."""

    newest: Map
    number: int


class LolaDevice:
    """An open connection; close it, or use it as a context manager.

    Args:
        address: of LoLA's socket, or of its relay.
        silence: s without a packet after which the connection is given up.

    Raises:
        OSError: nobody is there.
    """

    def __init__(self, address: Address, silence: float = SILENCE) -> None:
        self.address, self._silence = address, silence
        self._peer = connect(address, _CONNECT)
        self._peer.settimeout(_SEND)
        self._stream = MapStream(SENSORS)
        self._heard = time.monotonic()
        self._spoken = False

    def packets(self, timeout: float) -> Packets | None:
        """The packets that are there, waiting up to `timeout` s for the first; None when none came.

        Raises:
            LinkError: the connection has ended, or nothing came for too long.
        """
        deadline = time.monotonic() + timeout
        while True:
            left = max(0.0, deadline - time.monotonic())
            if select.select([self._peer], [], [], left)[0]:
                maps = self._stream.feed(self._received())
                if maps:
                    self._heard, self._spoken = time.monotonic(), True
                    return Packets(maps[-1], len(maps))
            elif time.monotonic() - self._heard > self._silence:
                end = "." if self._spoken else "; is another client connected?"
                raise LinkError(f"LoLA at {self.address} has been silent for {self._silence:g} s{end}")
            else:
                return None

    @property
    def dropped(self) -> int:
        """Bytes so far that belonged to no packet."""
        return self._stream.dropped

    def send(self, position: Sequence[float], stiffness: Sequence[float]) -> None:
        """Send a command of all joints.

        Raises:
            LinkError: the connection has ended.
        """
        try:
            self._peer.sendall(actuator_map(position, stiffness))
        except OSError as error:
            raise self._ended(error) from None

    def _received(self) -> bytes:
        try:
            data = self._peer.recv(_READ)
        except OSError as error:
            raise self._ended(error) from None
        if not data:
            raise self._ended(None)
        return data

    def _ended(self, error: OSError | None) -> LinkError:
        why = f" ({error.strerror or error})" if error else ""
        return LinkError(f"LoLA at {self.address} closed the connection{why}.")

    def close(self) -> None:
        """End the connection."""
        self._peer.close()

    def __enter__(self) -> LolaDevice:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
