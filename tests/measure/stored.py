"""Results under the fingerprint of their inputs, each computed once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import msgspec

from nao_hil.files import write_bytes

Result = TypeVar("Result", bound=msgspec.Struct)


def stored(file: Path, key: str, kind: type[Result], make: Callable[[], Result]) -> Result:
    """The result in `file` if stored under the same key; else the result of `make`, which is stored.

    Args:
        file: JSON.
        key: Fingerprint of the inputs of the result.
        kind: Type of the result.
        make: Computes the result.
    """
    try:
        found, data = msgspec.json.decode(file.read_bytes(), type=tuple[str, msgspec.Raw])
        if found == key:
            return msgspec.json.decode(data, type=kind)
    except (OSError, msgspec.DecodeError):
        pass
    result = make()
    file.parent.mkdir(parents=True, exist_ok=True)
    write_bytes(file, msgspec.json.encode((key, result)))
    return result
