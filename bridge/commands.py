"""Commands from people's tools: read strictly, so that a misspelt key is told and not passed over."""

from __future__ import annotations

import re
from typing import Any, Final

import msgspec

from bridge.config import from_dict
from bridge.errors import ConfigurationError, FrameError
from bridge.messages import MAX_PAYLOAD, SCHEMA_VERSION

_PATTERN: Final = re.compile(r"expected text matching regex .*")
_LETTERS: Final = "1 to 64 letters, digits, `_` or `-` are expected"
"""The one pattern there is, that of names, in words."""


def decode_command(payload: bytes, kind: Any, name: str) -> Any:
    """A command from msgpack.

    Frames ignore fields they do not know; a command does not, because a command without what was misspelt would
    be carried out, and be another one.

    Args:
        payload: one msgpack map.
        kind: msgspec struct, or a tagged union of some.
        name: what the errors call it, for example `World command`.

    Raises:
        FrameError: not a command of the kind; names the field, and the nearest one there is.
    """
    if len(payload) > MAX_PAYLOAD:
        raise FrameError(f"{name} refused: {len(payload)} bytes; at most {MAX_PAYLOAD} are allowed.")
    try:
        data = msgspec.msgpack.decode(payload, type=dict[str, Any])
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FrameError(
            f"{name} refused: {len(payload)} bytes that are not one whole msgpack map ({error})."
        ) from None
    version = data.get("version", SCHEMA_VERSION)
    if version != SCHEMA_VERSION:
        raise FrameError(f"{name} refused: schema version {version}; this side speaks {SCHEMA_VERSION}.")
    try:
        return from_dict(data, f"{name} refused", kind)
    except ConfigurationError as error:
        raise FrameError(f"{_PATTERN.sub(_LETTERS, str(error))}.") from None
