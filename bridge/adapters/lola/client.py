"""A client of a served LoLA: packets to it, maps from it, and its joint setpoints."""

from __future__ import annotations

import logging
import socket
from typing import Final

from bridge.adapters.lola.address import send_at_once
from bridge.adapters.lola.codec import MAX_TEXT, Map, MapStream, is_map_head
from bridge.adapters.lola.schema import ACTUATORS
from bridge.adapters.lola.setpoints import JOINT_KEYS, Setpoints
from bridge.messages import SensorFrame
from bridge.validation import unknown_name

logger = logging.getLogger(__name__)

_READ: Final = 65536


class ClientGone(Exception):
    """The client closed its end."""


class LolaClient:
    """One connection.

    Args:
        peer: accepted socket.
    """

    def __init__(self, peer: socket.socket) -> None:
        peer.setblocking(False)
        send_at_once(peer)
        self._peer = peer
        self._proven = peer.family == socket.AF_UNIX
        """It speaks LoLA. A web browser reaches TCP ports, and what it sends begins with an HTTP method."""
        self._stream = MapStream(ACTUATORS)
        self._warned: set[str] = set()
        """Kinds of errors that were logged."""
        self.setpoints: Setpoints | None = None
        """None before the first map with positions or stiffnesses."""
        self.stalled = False
        """A packet found its buffer full: it gets no more packets, and its maps are ignored (as on a robot:
        reported)."""
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
            ClientGone: it has closed the connection.
        """
        try:
            sent = self._peer.send(packet)
        except BlockingIOError:
            sent = 0
        except OSError:
            raise ClientGone from None
        self.stalled = sent < len(packet)
        self.packets += not self.stalled

    def receive(self) -> list[Map]:
        """The maps that have come, oldest first; none of a stalled client.

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
        if not self._proven and not is_map_head(data[0]):
            logger.warning("a client over TCP does not begin with a map; its connection is closed")
            raise ClientGone
        self._proven = True
        if self.stalled:
            return []
        before = self.dropped
        maps = self._stream.feed(data)
        if self.dropped > before:
            found = f"{self.dropped - before} bytes are no map of LoLA and were dropped"
            spoken = f"it speaks msgpack without `bin`, `str 8` and texts of over {MAX_TEXT} letters"
            self.warn("bytes", f"{found}; {spoken}.")
        self.maps += len(maps)
        return maps

    def update(self, maps: list[Map], frame: SensorFrame) -> None:
        """Take over the joint values of its maps; each kind of error is logged once.

        Args:
            maps: as received, oldest first.
            frame: the newest one: joints without a setpoint stay as measured.
        """
        for values in maps:
            for key in values.keys() - ACTUATORS.keys():
                self.warn("key", f"the client's map has an {unknown_name('key', str(key), ACTUATORS)}.")
            if self.setpoints is None:
                if not any(key in values for key in JOINT_KEYS):
                    continue
                self.setpoints = Setpoints(frame.position, frame.stiffness)
            for error in self.setpoints.update(values):
                self.warn(error.kind, f"the client's {error.text}")

    def warn(self, kind: str, text: str) -> None:
        """Log a warning, the first one of its kind on this connection.

        Args:
            kind: the same for the same mistake.
            text: one sentence.
        """
        if kind not in self._warned:
            self._warned.add(kind)
            logger.warning("%s", text)

    def close(self) -> None:
        """End the connection."""
        self._peer.close()
