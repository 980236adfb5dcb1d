"""LoLA's messages: keys, order and lengths; msgpack maps in a stream of bytes, with or without garbage.

LoLA's socket carries one map after the other, without lengths or separators. After garbage a reader finds the
next whole map that begins with a known key. LoLA's maps are flat: keys are
printable ASCII; values are scalars, texts, or arrays of both, in the old msgpack that LoLA speaks (no `bin`,
`str 8` or `ext`). This narrow form distinguishes a whole map from the rest of a damaged one.

Contents of LoLA's messages: keys, their order on the wire, and lengths.

LoLA is the server on a unix stream socket of the robot. Every 12 ms it sends one msgpack map of sensor values;
a client answers with maps of any of the actuator keys. Joints are in the order of `bridge.body.joints.JOINTS`.
Source: the vendor's page on LoLA (NAOqi SDK 2.8.5) and two captured packets of V6 robots.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Final

import msgpack

from bridge.body.joints import N_JOINTS
from bridge.dcm.actuators import led_names

CYCLE: Final = 0.012
"""s (confirmed: vendor's page on LoLA)."""
DEFAULT_SOCKET: Final = "/tmp/robocup"
"""Socket of the robot (confirmed: every team's code)."""
SENSOR_BYTES: Final = 896
"""Length of every sensor packet (confirmed: teams read exactly that many)."""
IDENTIFIERS: Final = 4
"""Elements of `RobotConfig`: body id (20 characters) and version, head id and version."""
SENSORS: Final = {
    "RobotConfig": IDENTIFIERS,
    "Accelerometer": 3,
    "Angles": 2,
    "Battery": 4,
    "Current": N_JOINTS,
    "FSR": 8,
    "Gyroscope": 3,
    "Position": N_JOINTS,
    "Sonar": 2,
    "Stiffness": N_JOINTS,
    "Temperature": N_JOINTS,
    "Touch": 14,
    "Status": N_JOINTS,
}
"""Length of each array, in the order of the wire; float 32 but for `RobotConfig` (text) and `Status` (int)."""
ACTUATORS: Final = {
    "Position": N_JOINTS,
    "Stiffness": N_JOINTS,
    "REar": 10,
    "LEar": 10,
    "Chest": 3,
    "LEye": 24,
    "REye": 24,
    "LFoot": 3,
    "RFoot": 3,
    "Skull": 12,
    "Sonar": 2,
}
"""Length of each array; all are float 32 but `Sonar` (bool). A map may hold any of them in any order."""


def _places() -> dict[str, tuple[int, ...]]:
    """Key of a map -> place of each of its LEDs in a `LedFrame` (order: vendor's page on LoLA)."""
    rgb = ("Red", "Green", "Blue")
    left, right = [45, 0, *range(315, 45, -45)], range(0, 360, 45)
    skull = ["Front/Left/1", "Front/Left/0", "Middle/Left/0", *(f"Rear/Left/{i}" for i in range(3))]
    skull += [*(f"Rear/Right/{i}" for i in (2, 1, 0)), "Middle/Right/0", "Front/Right/0", "Front/Right/1"]
    names = {
        "REar": [f"Ears/Led/Right/{a}Deg" for a in range(324, -1, -36)],
        "LEar": [f"Ears/Led/Left/{a}Deg" for a in range(0, 360, 36)],
        "Chest": [f"ChestBoard/Led/{c}" for c in rgb],
        "LEye": [f"Face/Led/{c}/Left/{a}Deg" for c in rgb for a in left],
        "REye": [f"Face/Led/{c}/Right/{a}Deg" for c in rgb for a in right],
        "LFoot": [f"LFoot/Led/{c}" for c in rgb],
        "RFoot": [f"RFoot/Led/{c}" for c in rgb],
        "Skull": [f"Head/Led/{place}" for place in skull],
    }
    index = {name: i for i, name in enumerate(led_names())}
    return {key: tuple(index[name] for name in leds) for key, leds in names.items()}


LEDS: Final = _places()
Scalar = float | int | bool | str | None
Map = dict[str, Scalar | list[Scalar]]
MAX_MESSAGE: Final = 4096
"""bytes; LoLA's own maps have 896 and 786."""
MAX_ELEMENTS: Final = 256
"""Most elements of an array or a map."""
MAX_TEXT: Final = 31
"""bytes; newer msgpacks write longer texts as `str 8`."""
_SCALARS: Final = frozenset({float, int, bool, str, type(None)})


class MapStream:
    """Parser of a stream of bytes into whole maps.

    A map is damaged, and is dropped, when it is not the msgpack described above, when it is longer than
    `MAX_MESSAGE`, when the bytes behind it begin no map, or when its end is missing and a whole map begins
    inside it.

    Args:
        known: keys; after garbage, a map must begin with one of them.
    """

    def __init__(self, known: Collection[str]) -> None:
        self._keys = tuple(bytes([0xA0 | len(key)]) + key.encode("ascii") for key in known)
        self._head = re.compile(b"[\x81-\x8f](?:" + b"|".join(map(re.escape, self._keys)) + b")")
        self._bytes = b""
        self._lost = False
        """Whether the present bytes follow garbage."""
        self.dropped = 0
        """Bytes so far outside whole maps."""

    def feed(self, data: bytes) -> list[Map]:
        """The maps that `data` completes, oldest first."""
        self._bytes += data
        found: list[Map] = []
        while self._bytes and (value := self._next()) is not None:
            found.append(value)
        return found

    def _next(self) -> Map | None:
        """Take the next whole map; None: there is none, and only the beginning of one is kept."""
        kept = len(self._bytes)
        for start in self._starts():
            data = self._bytes[start : start + MAX_MESSAGE]
            try:
                value, size = _unpack(data)
            except msgpack.OutOfData:
                if len(data) < MAX_MESSAGE:
                    kept = min(kept, start)
            except ValueError:
                continue
            else:
                end = start + size
                if end == len(self._bytes) or is_map_head(self._bytes[end]):
                    self._drop(start)
                    self._bytes, self._lost = self._bytes[size:], False
                    return value
        self._drop(min(kept, self._cut_head()))
        return None

    def _starts(self) -> Iterator[int]:
        """Possible beginnings of a map: the first byte, unless it follows garbage, and each known key."""
        if not self._lost:
            yield 0
        for head in self._head.finditer(self._bytes, not self._lost):
            yield head.start()

    def _cut_head(self) -> int:
        """Beginning of a map's head that is cut off by the end of the bytes."""
        end = len(self._bytes)
        for start in range(max(0, end - MAX_TEXT - 1), end):
            rest = self._bytes[start + 1 :]
            if 0x81 <= self._bytes[start] <= 0x8F and any(key.startswith(rest) for key in self._keys):
                return start
        return end

    def _drop(self, count: int) -> None:
        if count:
            self._bytes, self._lost = self._bytes[count:], True
            self.dropped += count


def pack_map(values: Mapping[str, Sequence[float | int | bool | str]]) -> bytes:
    """A map of arrays in LoLA's msgpack: numbers as float 32, texts of at most 31 bytes."""
    packed: bytes = msgpack.packb(values, use_single_float=True, use_bin_type=False)
    return packed


def is_map_head(code: int) -> bool:
    """Whether a msgpack map begins with this byte."""
    return code & 0xF0 == 0x80 or code in (0xDE, 0xDF)


def _unpack(data: bytes) -> tuple[Map, int]:
    """The map at the beginning of the bytes, and its length.

    Raises:
        msgpack.OutOfData: the bytes end before the map does.
        ValueError: not a map of LoLA's form.
    """
    if not is_map_head(data[0]):
        raise ValueError
    unpacker = msgpack.Unpacker(
        list_hook=_flat,
        max_str_len=MAX_TEXT,
        max_array_len=MAX_ELEMENTS,
        max_map_len=MAX_ELEMENTS,
        max_bin_len=0,
        max_ext_len=0,
    )
    unpacker.feed(data)
    value: Map = unpacker.unpack()
    _flat(list(value))
    _flat([element for element in value.values() if not isinstance(element, list)])
    return value, unpacker.tell()


def _flat(array: list[Scalar]) -> list[Scalar]:
    """The array itself; ValueError unless it holds scalars and printable texts only."""
    kinds = set(map(type, array))
    if not kinds <= _SCALARS:
        raise ValueError
    if str in kinds and not all(t.isascii() and t.isprintable() for t in array if isinstance(t, str)):
        raise ValueError
    return array
