"""A stream of msgpack maps without lengths around them, as LoLA and its clients write it, garbage or not.

LoLA's socket carries one map after the other and nothing between. A reader that meets anything else has to find
the next map by itself: it goes on from the byte behind the one where the bad map began, to a map's head with a
known key behind it. What a map may hold is kept narrow on purpose: that is what tells the rest of a broken map
from a whole one. Keys are printable ASCII; values are scalars, texts, or arrays of them, in the old msgpack
that LoLA speaks (no `bin`, `str 8` or `ext`).
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Final

Scalar = float | int | bool | str | None
Map = dict[str, Scalar | list[Scalar]]

MAX_MESSAGE: Final = 4096
"""bytes; LoLA's own maps have 896 and 786."""
MAX_ELEMENTS: Final = 256
"""Of an array or a map."""
MAX_TEXT: Final = 255
"""bytes"""

_NUMBERS: Final = {
    0xCA: struct.Struct(">f"),
    0xCB: struct.Struct(">d"),
    0xCC: struct.Struct(">B"),
    0xCD: struct.Struct(">H"),
    0xCE: struct.Struct(">I"),
    0xCF: struct.Struct(">Q"),
    0xD0: struct.Struct(">b"),
    0xD1: struct.Struct(">h"),
    0xD2: struct.Struct(">i"),
    0xD3: struct.Struct(">q"),
}
_CONSTANTS: Final[dict[int, Scalar]] = {0xC0: None, 0xC2: False, 0xC3: True}
_LENGTH_16, _LENGTH_32 = struct.Struct(">H"), struct.Struct(">I")
_FIRST_PRINTABLE, _LAST_PRINTABLE = 0x20, 0x7E


class _Incomplete(Exception):
    """The bytes end before the value does."""


class _Malformed(Exception):
    """None of LoLA's maps looks like this."""


class MapStream:
    """Takes bytes as they come and gives the whole maps among them.

    A map counts as damaged, and is dropped, when it is not the msgpack described above, when it is longer than
    `MAX_MESSAGE`, or when what follows it in the bytes at hand is no map.

    Args:
        known: keys, one of which must follow the head of a map for it to end a stretch of garbage.
    """

    def __init__(self, known: Collection[str]) -> None:
        self._known = tuple(_pack_text(key) for key in known)
        self._bytes = bytearray()
        self._lost = False
        self.dropped = 0
        """Bytes so far that belonged to no whole map."""

    def feed(self, data: bytes) -> list[Map]:
        """The maps that `data` completes, oldest first."""
        self._bytes += data
        found: list[Map] = []
        at = 0
        while at < len(self._bytes):
            try:
                if self._lost:
                    self._require_known_key(at)
                value, end = self._map(at)
            except _Incomplete:
                break
            except _Malformed:
                self._lost = True
                self.dropped += 1
                at += 1
            else:
                self._lost = False
                found.append(value)
                at = end
        del self._bytes[:at]
        return found

    def _map(self, at: int) -> tuple[Map, int]:
        try:
            value, end = _read_map(self._bytes, at)
        except _Incomplete:
            if len(self._bytes) - at < MAX_MESSAGE:
                raise
            raise _Malformed from None
        if end < len(self._bytes) and not _is_map_head(self._bytes[end]):
            raise _Malformed
        return value, end

    def _require_known_key(self, at: int) -> None:
        if not 0x81 <= self._bytes[at] <= 0x8F:
            raise _Malformed
        rest = bytes(self._bytes[at + 1 : at + 33])
        if rest.startswith(self._known):
            return
        if any(key.startswith(rest) for key in self._known):
            raise _Incomplete
        raise _Malformed


def _is_map_head(code: int) -> bool:
    return code & 0xF0 == 0x80 or code in (0xDE, 0xDF)


def _read_map(data: bytearray, at: int) -> tuple[Map, int]:
    code = data[at]
    if not _is_map_head(code):
        raise _Malformed
    count, at = _count(data, at, small=0x0F, large=0xDE)
    result: Map = {}
    for _ in range(count):
        key, at = _read_scalar(data, at)
        if not isinstance(key, str):
            raise _Malformed
        result[key], at = _read_value(data, at)
    return result, at


def _read_value(data: bytearray, at: int) -> tuple[Scalar | list[Scalar], int]:
    code = _byte(data, at)
    if code & 0xF0 != 0x90 and code not in (0xDC, 0xDD):
        return _read_scalar(data, at)
    count, at = _count(data, at, small=0x0F, large=0xDC)
    elements: list[Scalar] = []
    for _ in range(count):
        element, at = _read_scalar(data, at)
        elements.append(element)
    return elements, at


def _read_scalar(data: bytearray, at: int) -> tuple[Scalar, int]:
    code = _byte(data, at)
    if code in _NUMBERS:
        return _unpack(_NUMBERS[code], data, at + 1)
    if code < 0x80:
        return code, at + 1
    if code >= 0xE0:
        return code - 0x100, at + 1
    if code & 0xE0 == 0xA0 or code in (0xDA, 0xDB):
        return _read_text(data, at)
    if code in _CONSTANTS:
        return _CONSTANTS[code], at + 1
    raise _Malformed


def _read_text(data: bytearray, at: int) -> tuple[str, int]:
    length, at = _count(data, at, small=0x1F, large=0xDA, most=MAX_TEXT)
    text = data[at : at + length]
    if any(not _FIRST_PRINTABLE <= byte <= _LAST_PRINTABLE for byte in text):
        raise _Malformed
    if len(text) < length:
        raise _Incomplete
    return text.decode("ascii"), at + length


def _count(data: bytearray, at: int, *, small: int, large: int, most: int = MAX_ELEMENTS) -> tuple[int, int]:
    """Number of elements or bytes that a head announces, and where they begin.

    Args:
        data: where to read.
        at: place of the head.
        small: mask of the number inside a one-byte head.
        large: code of the head with a 16-bit number; the next one has a 32-bit number.
        most: the largest number allowed.
    """
    code = data[at]
    if code == large:
        count, at = _unpack(_LENGTH_16, data, at + 1)
    elif code == large + 1:
        count, at = _unpack(_LENGTH_32, data, at + 1)
    else:
        count, at = code & small, at + 1
    if count > most:
        raise _Malformed
    return count, at


def _unpack(form: struct.Struct, data: bytearray, at: int) -> tuple[Any, int]:
    end = at + form.size
    if end > len(data):
        raise _Incomplete
    return form.unpack_from(data, at)[0], end


def _byte(data: bytearray, at: int) -> int:
    if at >= len(data):
        raise _Incomplete
    return data[at]


def pack_map(values: Mapping[str, Sequence[float | int | bool | str]]) -> bytes:
    """A map of arrays as LoLA and its clients write it.

    Args:
        values: arrays by key, each of one kind: float (written as float 32), bool, int from 0 to 127, or text
            of less than 32 ASCII characters.
    """
    parts = [bytes([0x80 | len(values)])]
    for key, array in values.items():
        count = len(array)
        parts.append(_pack_text(key))
        parts.append(bytes([0x90 | count]) if count < 16 else b"\xdc" + _LENGTH_16.pack(count))
        parts.append(_pack_elements(array))
    return b"".join(parts)


def _pack_elements(array: Sequence[float | int | bool | str]) -> bytes:
    if isinstance(array[0], float):
        interleaved: list[float | int] = [0xCA] * (2 * len(array))
        interleaved[1::2] = array  # type: ignore[assignment]
        return struct.pack(">" + "Bf" * len(array), *interleaved)
    if isinstance(array[0], bool):
        return bytes(0xC3 if element else 0xC2 for element in array)
    if isinstance(array[0], str):
        return b"".join(_pack_text(str(element)) for element in array)
    return bytes(array)  # type: ignore[arg-type]


def _pack_text(text: str) -> bytes:
    return bytes([0xA0 | len(text)]) + text.encode("ascii")
