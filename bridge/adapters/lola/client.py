"""A client of a served LoLA: packets to it, maps from it, and its joint setpoints."""

from __future__ import annotations

import fcntl
import logging
import math
import socket
import struct
import termios
from collections.abc import Sequence
from typing import Final, NamedTuple, TypeGuard

from bridge.adapters.lola.address import send_at_once
from bridge.adapters.lola.codec import ACTUATORS, LEDS, MAX_TEXT, Map, MapStream, is_map_head
from bridge.body.joints import JOINTS, N_JOINTS, degrees_warning
from bridge.messages import SensorFrame
from bridge.messages.frames import N_LEDS
from bridge.validation import unknown_name

JOINT_KEYS = ("Position", "Stiffness")
logger = logging.getLogger(__name__)
_READ_SIZE: Final = 65536


class MapError(NamedTuple):
    """An error in a client's map."""

    kind: str
    """The same for any joint and value."""
    text: str
    """One sentence."""


class Setpoints:
    """The last value of each joint; a map may leave out keys.

    Args:
        stiffness: 25 stiffnesses in force, the initial setpoints.
    """

    def __init__(self, stiffness: Sequence[float]) -> None:
        self._values: dict[str, list[float]] = {
            "Position": [math.nan] * N_JOINTS,
            "Stiffness": list(stiffness),
        }

    def update(self, values: Map) -> list[MapError]:
        """Take over the joint values of a map; unknown keys are ignored.

        An array of another length is ignored, an element that is no finite number leaves its joint unchanged,
        and a stiffness outside -1 to 1 is clipped.

        Returns:
            The first error of each kind.
        """
        errors: dict[str, MapError] = {}
        for key in JOINT_KEYS:
            if key not in values:
                continue
            array = values[key]
            if isinstance(array, list) and len(array) == N_JOINTS:
                for slot, value in enumerate(array):
                    error = self._put(key, slot, value)
                    if error is not None:
                        errors.setdefault(error.kind, error)
            else:
                found = f"{len(array)} elements" if isinstance(array, list) else "no array"
                text = f"`{key}` needs {N_JOINTS} numbers and has {found}; it was ignored."
                errors[key] = MapError(f"{key}, length", text)
        return list(errors.values())

    def _put(self, key: str, slot: int, value: object) -> MapError | None:
        if not _is_number(value):
            text = f"`{key}` of {JOINTS[slot]} is {value!r} and was ignored; a finite number is expected."
            return MapError(f"{key}, number", text)
        if key == "Stiffness" and not -1.0 <= value <= 1.0:
            self._values[key][slot] = math.copysign(1.0, value)
            text = f"`{key}` of {JOINTS[slot]} is {value:g} and was clipped; -1 to 1 is allowed."
            return MapError(f"{key}, range", text)
        self._values[key][slot] = float(value)
        if key == "Position" and (why := degrees_warning(JOINTS[slot], value)):
            return MapError(f"{key}, range", f"`{key}` of {why}")
        return None

    def position(self, held: Sequence[float]) -> tuple[float, ...]:
        """Position of all joints, rad; of a joint without a setpoint the angle that the robot holds."""
        own = self._values["Position"]
        return tuple(at if math.isnan(p) else p for p, at in zip(own, held, strict=True))

    @property
    def stiffness(self) -> tuple[float, ...]:
        """Stiffness of all joints."""
        return tuple(self._values["Stiffness"])


def _is_number(value: object) -> TypeGuard[float]:
    return not isinstance(value, bool) and isinstance(value, (int, float)) and math.isfinite(value)


class ClientGone(Exception):
    """The client closed its end."""


class LolaClient:
    """One connection."""

    def __init__(self, peer: socket.socket) -> None:
        peer.setblocking(False)
        send_at_once(peer)
        self._peer = peer
        self._speaks_lola = peer.family == socket.AF_UNIX
        """It speaks LoLA. A web browser reaches TCP ports too; its requests begin with an HTTP method."""
        self._stream = MapStream(ACTUATORS)
        self._warned: set[str] = set()
        """Kinds of errors logged so far."""
        self.setpoints: Setpoints | None = None
        """None before the first map with positions or stiffnesses."""
        self.leds = [0] * N_LEDS
        """Brightness of each LED by the maps so far, 0 to 255, see `LedFrame`."""
        self.packets = 0
        """Sent so far."""
        self.maps = 0
        """Received so far."""

    @property
    def dropped(self) -> int:
        """Bytes received outside maps."""
        return self._stream.dropped

    @property
    def has_read(self) -> bool:
        """It has read all packets; over TCP its machine has received them."""
        queued = fcntl.ioctl(self._peer, termios.TIOCOUTQ, struct.pack("i", 0))
        return struct.unpack("i", queued) == (0,)

    def fileno(self) -> int:
        """For `select`."""
        return self._peer.fileno()

    def send(self, packet: bytes) -> None:
        """Send a packet, whole.

        Raises:
            ClientGone: it has closed the connection, or its buffer is full because it does not read.
        """
        try:
            sent = self._peer.send(packet)
        except BlockingIOError:
            sent = 0
        except OSError:
            raise ClientGone from None
        if sent < len(packet):
            logger.warning("the client does not read; its connection is closed, as a robot does it")
            raise ClientGone
        self.packets += 1

    def receive(self) -> list[Map]:
        """The received maps, oldest first.

        Raises:
            ClientGone: it closed its end.
        """
        try:
            data = self._peer.recv(_READ_SIZE)
        except BlockingIOError:
            return []
        except OSError:
            raise ClientGone from None
        if not data:
            raise ClientGone
        if not self._speaks_lola and not is_map_head(data[0]):
            logger.warning("a client over TCP does not begin with a map; its connection is closed")
            raise ClientGone
        self._speaks_lola = True
        before = self.dropped
        maps = self._stream.feed(data)
        if self.dropped > before:
            found = f"{self.dropped - before} bytes are no map of LoLA and were dropped"
            spoken = f"it speaks msgpack without `bin`, `str 8` and texts of over {MAX_TEXT} letters"
            self.warn("bytes", f"{found}; {spoken}.")
        self.maps += len(maps)
        return maps

    def update(self, maps: list[Map], frame: SensorFrame) -> None:
        """Take over the values of its maps; each kind of error is logged once."""
        for values in maps:
            for key in values.keys() - ACTUATORS.keys():
                self.warn("key", f"the client's map has an {unknown_name('key', str(key), ACTUATORS)}.")
            for key in LEDS.keys() & values.keys():
                self._light(key, values[key])
            if self.setpoints is None:
                if not any(key in values for key in JOINT_KEYS):
                    continue
                self.setpoints = Setpoints(frame.stiffness)
            for error in self.setpoints.update(values):
                self.warn(error.kind, f"the client's {error.text}")

    def _light(self, key: str, values: object) -> None:
        """Take over an array of LEDs, 0 to 1 each; a wrong one is ignored."""
        places = LEDS[key]
        if not isinstance(values, list) or len(values) != len(places) or not all(map(_is_number, values)):
            self.warn(key, f"the client's `{key}` needs {len(places)} numbers; it was ignored.")
            return
        for place, value in zip(places, values, strict=True):
            self.leds[place] = round(255.0 * min(max(value, 0.0), 1.0))

    def warn(self, kind: str, text: str) -> None:
        """Log the first warning of its kind on this connection.

        Args:
            kind: see `MapError`.
        """
        if kind not in self._warned:
            self._warned.add(kind)
            logger.warning("%s", text)

    def close(self) -> None:
        """End the connection."""
        self._peer.close()
