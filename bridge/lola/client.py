"""A client of a served LoLA: packets to it, maps from it, and what becomes of one that does not read."""

from __future__ import annotations

import socket

from bridge.lola.address import send_at_once
from bridge.lola.schema import ACTUATORS
from bridge.lola.wire import Map, MapStream

_READ = 65536


class ClientGone(Exception):
    """The client closed its end."""


class LolaClient:
    """One connection. A client that stops reading is ignored from the packet on that did not fit any more.

    Args:
        peer: accepted socket.
    """

    def __init__(self, peer: socket.socket) -> None:
        peer.setblocking(False)
        send_at_once(peer)
        self._peer = peer
        self._stream = MapStream(ACTUATORS)
        self.deaf = False
        """Its buffer was full; it gets nothing more and nothing of it is heeded (as on a robot: reported)."""
        self.packets = 0
        """Sent so far."""
        self.maps = 0
        """Received so far."""

    @property
    def dropped(self) -> int:
        """Bytes received that belonged to no map."""
        return self._stream.dropped

    def fileno(self) -> int:
        """For `select`."""
        return self._peer.fileno()

    def send(self, packet: bytes) -> None:
        """Send a packet, whole.

        Raises:
            ClientGone: it is not there any more.
        """
        if self.deaf:
            return
        try:
            sent = self._peer.send(packet)
        except BlockingIOError:
            sent = 0
        except OSError:
            raise ClientGone from None
        self.deaf = sent < len(packet)
        self.packets += not self.deaf

    def receive(self) -> list[Map]:
        """The maps that have come, oldest first; none of a deaf client.

        Raises:
            ClientGone: it closed its end.
        """
        try:
            data = self._peer.recv(_READ)
        except BlockingIOError:
            return []
        except OSError:
            raise ClientGone from None
        if not data:
            raise ClientGone
        if self.deaf:
            return []
        maps = self._stream.feed(data)
        self.maps += len(maps)
        return maps

    def close(self) -> None:
        """End the connection."""
        self._peer.close()
