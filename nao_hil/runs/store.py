"""Results under the fingerprint of all that they depend on, so that none is computed twice."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import msgspec

from bridge.body import load_body
from emulator.wear import load_wear
from nao_hil.files import write_bytes
from nao_hil.runs.fingerprint import fingerprint
from nao_hil.runs.walk import Walk

Result = TypeVar("Result", bound=msgspec.Struct)


def key(walk: Walk) -> str:
    """Fingerprint of a walk: configuration, seed, world, contents of body and wear profile; not its name."""
    body = walk.body or load_body(walk.config.robot)
    wear = walk.wear or load_wear(walk.config.wear, body)
    config = msgspec.structs.replace(walk.config, robot="", wear="")
    return fingerprint(msgspec.structs.replace(walk, name="", config=config, body=None, wear=None), body, wear)


def stored(file: Path, key: str, kind: type[Result], make: Callable[[], Result]) -> Result:
    """The result in `file` if it was stored under the same key; else the result of `make`, which is stored.

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
