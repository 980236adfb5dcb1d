"""Values and signatures of the qi messaging protocol in bytes, all little-endian.

A signature names a type: `i` a number of 32 bits, `[m]` a list of dynamic values, `(sI)<Name,field,...>` a
structure. A dynamic value, `m`, is a signature and a value of it. The names of the types are those of libqi's
`signature.hpp`; the layout is that of its binary codec.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

Decoder = Callable[[memoryview, int, int], tuple[Any, int]]
"""`(payload, offset, depth) -> (value, next offset)`."""
Encoder = Callable[[bytearray, Any], None]

_NUMBERS: Final = {
    **{"b": "?", "c": "b", "C": "B", "w": "h", "W": "H", "i": "i", "I": "I"},
    **{"l": "q", "L": "Q", "f": "f", "d": "d"},
}
_MAX_DEPTH: Final = 64
_MAX_SIGNATURE: Final = 1024
"""letters of a signature in a payload"""
_FLOAT_RANGE: Final = 1e7
"""Larger magnitudes, for example times of day, have 64 bits: 32 have a mantissa of 24."""
_COUNT: Final = struct.Struct("<I")
_FLOAT, _DOUBLE = struct.Struct("<I1sf"), struct.Struct("<I1sd")
_INT, _LONG, _UNSIGNED = (struct.Struct(f"<I1s{code}") for code in "iqQ")
_VOID: Final = b"\1\0\0\0v"
_TRUE, _FALSE = b"\1\0\0\0b\1", b"\1\0\0\0b\0"
_TEXT, _RAW, _OBJECT = b"\1\0\0\0s", b"\1\0\0\0r", b"\1\0\0\0o"
_LIST, _MAP = b"\3\0\0\0[m]", b"\4\0\0\0{mm}"


class QiError(Exception):
    """Bytes that are no value of their signature, or a value that has none; one sentence."""


@dataclass(frozen=True)
class ObjectReference:
    """An object behind a service, for example the one with the signal of an event."""

    meta_object: bytes
    service: int
    number: int


def decode(signature: str, payload: bytes | memoryview) -> Any:
    """The value of a payload.

    Raises:
        QiError: it is no such value.
    """
    view = memoryview(payload)
    try:
        value, end = _codec(signature)[0](view, 0, 0)
    except (struct.error, IndexError):
        raise QiError(f"a payload of {len(view)} bytes ends within a value of type {signature:.60}") from None
    if end != len(view):
        raise QiError(f"{len(view) - end} bytes follow a value of type {signature:.60}")
    return value


def encode(signature: str, value: Any) -> bytes:
    """A value in bytes.

    Args:
        value: numbers, text, bytes, None, lists, tuples and dictionaries of them; `ObjectReference`.

    Raises:
        QiError: the value has no such type.
    """
    out = bytearray()
    try:
        _codec(signature)[1](out, value)
    except (struct.error, TypeError, ValueError, AttributeError) as error:
        raise QiError(f"{value!r:.60} is no value of type {signature:.60} ({error})") from None
    except RecursionError:
        raise QiError("the value is nested too deeply") from None
    return bytes(out)


@lru_cache(maxsize=256)
def _codec(signature: str) -> tuple[Decoder, Encoder]:
    codec, rest = _parse(signature, 0)
    if rest:
        raise QiError(f"the signature {signature!r:.60} continues after its type")
    return codec


def _parse(signature: str, depth: int) -> tuple[tuple[Decoder, Encoder], str]:
    """The codec of the first type of a signature, and the rest of the signature."""
    letter, rest = signature[:1], signature[1:]
    if depth > _MAX_DEPTH:
        raise QiError("a signature is nested too deeply")
    if letter in _NUMBERS:
        return _number(_NUMBERS[letter]), rest
    simple: dict[str, tuple[Decoder, Encoder]] = {
        "v": (_decode_void, _encode_nothing),
        "s": (_decode_text, _encode_text),
        "r": (_decode_raw, _encode_raw),
        "m": (_decode_dynamic, encode_dynamic),
        "o": (_decode_object, _encode_object),
    }
    if letter in simple:
        return simple[letter], rest
    if letter == "[":
        item, rest = _parse(rest, depth + 1)
        return _list(item), _closed(rest, "]")
    if letter == "{":
        key, rest = _parse(rest, depth + 1)
        item, rest = _parse(rest, depth + 1)
        return _map(key, item), _closed(rest, "}")
    if letter == "(":
        members = []
        while rest[:1] != ")":
            member, rest = _parse(rest, depth + 1)
            members.append(member)
        return _tuple(members), _without_names(rest[1:])
    raise QiError(f"{signature!r:.60} is no type")


def _closed(rest: str, bracket: str) -> str:
    if rest[:1] != bracket:
        raise QiError(f"a {bracket} is missing before {rest!r:.60}")
    return rest[1:]


def _without_names(rest: str) -> str:
    """A signature without the names of the structure before it, `<Name,field,...>`."""
    depth = 0
    for i, letter in enumerate(rest):
        depth += (letter == "<") - (letter == ">")
        if depth == 0:
            return rest[i + 1 :] if letter == ">" else rest
    return rest


def _number(code: str) -> tuple[Decoder, Encoder]:
    layout = struct.Struct("<" + code)
    size = layout.size

    def decode_number(view: memoryview, at: int, _: int) -> tuple[Any, int]:
        return layout.unpack_from(view, at)[0], at + size

    def encode_number(out: bytearray, value: Any) -> None:
        out += layout.pack(value)

    return decode_number, encode_number


def _decode_void(_: memoryview, at: int, __: int) -> tuple[None, int]:
    return None, at


def _encode_nothing(_: bytearray, __: Any) -> None:
    return


def _decode_raw(view: memoryview, at: int, _: int) -> tuple[bytes, int]:
    (length,) = _COUNT.unpack_from(view, at)
    end = at + 4 + length
    if end > len(view):
        raise QiError(f"a text or raw value of {length} bytes ends after its payload")
    return bytes(view[at + 4 : end]), end


def _decode_text(view: memoryview, at: int, depth: int) -> tuple[str | bytes, int]:
    """A text; bytes if it is not in UTF-8, as by libqi's package for Python."""
    raw, end = _decode_raw(view, at, depth)
    try:
        return raw.decode(), end
    except UnicodeDecodeError:
        return raw, end


def _encode_raw(out: bytearray, value: bytes | bytearray) -> None:
    out += _COUNT.pack(len(value))
    out += value


def _encode_text(out: bytearray, value: str | bytes) -> None:
    _encode_raw(out, value.encode() if isinstance(value, str) else value)


def _count(view: memoryview, at: int) -> int:
    count: int = _COUNT.unpack_from(view, at)[0]
    if count > len(view) - at:
        raise QiError(f"{count} items are more than a payload of {len(view)} bytes has")
    return count


def _list(item: tuple[Decoder, Encoder]) -> tuple[Decoder, Encoder]:
    decode_item, encode_item = item

    def decode_list(view: memoryview, at: int, depth: int) -> tuple[list[Any], int]:
        """The items, after their count."""
        values, count = [], _count(view, at)
        at += 4
        for _ in range(count):
            value, at = decode_item(view, at, depth)
            values.append(value)
        return values, at

    def encode_list(out: bytearray, values: Sequence[Any]) -> None:
        out += _COUNT.pack(len(values))
        for value in values:
            encode_item(out, value)

    return decode_list, encode_list


def _map(key: tuple[Decoder, Encoder], item: tuple[Decoder, Encoder]) -> tuple[Decoder, Encoder]:
    def decode_map(view: memoryview, at: int, depth: int) -> tuple[dict[Any, Any], int]:
        """Keys and values, after their count."""
        values, count = {}, _count(view, at)
        at += 4
        for _ in range(count):
            name, at = key[0](view, at, depth)
            if isinstance(name, list | dict):
                raise QiError("a list or a map is the key of a map")
            values[name], at = item[0](view, at, depth)
        return values, at

    def encode_map(out: bytearray, values: dict[Any, Any]) -> None:
        out += _COUNT.pack(len(values))
        for name, value in values.items():
            key[1](out, name)
            item[1](out, value)

    return decode_map, encode_map


def _tuple(members: Sequence[tuple[Decoder, Encoder]]) -> tuple[Decoder, Encoder]:
    def decode_tuple(view: memoryview, at: int, depth: int) -> tuple[list[Any], int]:
        values = []
        for decode_member, _ in members:
            value, at = decode_member(view, at, depth)
            values.append(value)
        return values, at

    def encode_tuple(out: bytearray, values: Sequence[Any]) -> None:
        for (_, encode_member), value in zip(members, values, strict=True):
            encode_member(out, value)

    return decode_tuple, encode_tuple


def _decode_dynamic(view: memoryview, at: int, depth: int) -> tuple[Any, int]:
    if depth > _MAX_DEPTH:
        raise QiError("a value is nested too deeply")
    signature, at = _decode_text(view, at, depth)
    if not isinstance(signature, str) or len(signature) > _MAX_SIGNATURE:
        raise QiError("a signature is too long or not in UTF-8")
    return _codec(signature)[0](view, at, depth + 1)


def encode_dynamic(out: bytearray, value: Any) -> None:
    """Append a value with its signature in a robot's ALValue: floats have 32 bits.

    Raises:
        TypeError: it has no such signature.
    """
    kind = type(value)
    if kind is float:
        layout, letter = (_FLOAT, b"f") if abs(value) < _FLOAT_RANGE else (_DOUBLE, b"d")
        out += layout.pack(1, letter, value)
    elif kind is str:
        out += _TEXT
        _encode_text(out, value)
    elif value is None:
        out += _VOID
    elif kind is bool:
        out += _TRUE if value else _FALSE
    elif kind is int:
        if -(1 << 31) <= value < 1 << 31:
            out += _INT.pack(1, b"i", value)
        else:
            layout, letter = (_LONG, b"l") if value < 1 << 63 else (_UNSIGNED, b"L")
            out += layout.pack(1, letter, value)
    elif isinstance(value, list | tuple):
        out += _LIST
        out += _COUNT.pack(len(value))
        for item in value:
            encode_dynamic(out, item)
    elif isinstance(value, bytes | bytearray):
        out += _RAW
        _encode_raw(out, value)
    elif isinstance(value, dict):
        out += _MAP
        out += _COUNT.pack(len(value))
        for name, item in value.items():
            encode_dynamic(out, name)
            encode_dynamic(out, item)
    elif isinstance(value, ObjectReference):
        out += _OBJECT
        _encode_object(out, value)
    elif hasattr(value, "item"):  # a number of numpy
        encode_dynamic(out, value.item())
    else:
        raise TypeError(f"{kind.__name__} is sent by no program")


def _decode_object(_: memoryview, __: int, ___: int) -> tuple[Any, int]:
    raise QiError("objects are not taken as arguments")


def _encode_object(out: bytearray, value: ObjectReference) -> None:
    out += value.meta_object
    out += _COUNT.pack(value.service)
    out += _COUNT.pack(value.number)
