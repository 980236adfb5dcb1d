"""Messages to msgpack and back, checked: a wrong one raises `FrameError` that names the field."""

from __future__ import annotations

import math
import re
from typing import Any, Final, TypeVar

import msgspec

from bridge.body.joints import JOINTS, N_JOINTS
from bridge.errors import FrameError
from bridge.messages.frames import MAX_PAYLOAD, SCHEMA_VERSION, Versioned
from bridge.validation import READING_TYPES, Invalid, convert

M = TypeVar("M", bound=Versioned)

_UNREADABLE: Final = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)
_SLOT: Final = re.compile(r"(?:position|stiffness|current|temperature|joints)\[(\d+)\]")

_encoder = msgspec.msgpack.Encoder()
_decoders: dict[Any, msgspec.msgpack.Decoder[Any]] = {}


def encode(message: Versioned) -> bytes:
    """Msgpack map of a message, field names as keys."""
    return _encoder.encode(message)


def decode(payload: bytes, kind: type[M]) -> M:
    """A message from msgpack. Fields that the kind does not have are ignored.

    Args:
        payload: one msgpack map.
        kind: msgspec struct of the message.

    Raises:
        FrameError: not msgpack, too long, a missing, ill-typed, wrongly sized or non-finite field, or another
            schema version; the sentence names the field and the expected value.
    """
    name = kind.__name__
    _require_short(payload, name)
    decoder = _decoders.get(kind)
    if decoder is None:
        with READING_TYPES:
            decoder = _decoders[kind] = msgspec.msgpack.Decoder(kind)
    try:
        message: M = decoder.decode(payload)
    except msgspec.ValidationError as error:
        _converted(_table(payload, name), kind, name, ignore_unknown=True)
        # Only for a map that holds a key twice: the decoder reads both values, a table has the second.
        raise FrameError(f"{name} refused: {error}.") from None
    except _UNREADABLE as error:
        raise _unreadable(payload, name, error) from None
    _require_version(message.version, name)
    return message


def decode_command(payload: bytes, kind: Any, name: str) -> Any:
    """A command from msgpack.

    A frame may have fields that its reader does not know. A command may not: without a misspelt field it would
    be another command.

    Args:
        payload: one msgpack map.
        kind: msgspec struct, or a tagged union of some.
        name: of the message in errors, for example `World command`.

    Raises:
        FrameError: not a command of the kind; names the field, and the nearest one there is.
    """
    _require_short(payload, name)
    return _converted(_table(payload, name), kind, name, ignore_unknown=False)


def require_finite(name: str, values: tuple[float, ...]) -> None:
    """Check a field of a frame that is not decoded from a payload.

    Args:
        name: field, one of those in joint order.
        values: 25 of them.

    Raises:
        FrameError: a value is NaN or infinite; names the first one.
    """
    if math.isfinite(sum(values)):  # else a value is not finite, or the sum overflows
        return
    for i, value in enumerate(values):
        if not math.isfinite(value):
            raise FrameError(
                f"ActuatorFrame refused: {_place(f'{name}[{i}]')}: is {value}, but must be a finite number."
            )


def _table(payload: bytes, name: str) -> dict[str, Any]:
    try:
        table: dict[str, Any] = msgspec.msgpack.decode(payload, type=dict[str, Any])
    except _UNREADABLE as error:
        raise _unreadable(payload, name, error) from None
    return table


def _converted(table: dict[str, Any], kind: Any, name: str, *, ignore_unknown: bool) -> Any:
    """The message; its version is checked before its fields, which depend on it."""
    _require_version(table.get("version", SCHEMA_VERSION), name)
    try:
        return convert(table, kind, ignore_unknown=ignore_unknown)
    except Invalid as error:
        where = f"{_place(error.path)}: " if error.path else ""
        raise FrameError(f"{name} refused: {where}{error.reason[:300]}.") from None


def _require_short(payload: bytes, name: str) -> None:
    if len(payload) > MAX_PAYLOAD:
        raise FrameError(f"{name} refused: {len(payload)} bytes; at most {MAX_PAYLOAD} are allowed.")


def _unreadable(payload: bytes, name: str, error: Exception) -> FrameError:
    return FrameError(f"{name} refused: {len(payload)} bytes that are not one whole msgpack map ({error}).")


def _require_version(version: Any, name: str) -> None:
    if version != SCHEMA_VERSION:
        shown = repr(version)[:40]  # of any type
        raise FrameError(f"{name} refused: schema version {shown}; this side speaks {SCHEMA_VERSION}.")


def _place(path: str) -> str:
    """Path of a field, with the joint's name next to its slot."""
    slot = _SLOT.fullmatch(path)
    return f"`{path}` ({JOINTS[int(slot[1])]})" if slot and int(slot[1]) < N_JOINTS else f"`{path}`"
