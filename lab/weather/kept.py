"""Results of walks in real time on disk: a campaign that was stopped goes on where it was."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import msgspec

from bridge.datasheet import load_body
from emulator.wear import load_wear
from lab.campaign.store import sources
from lab.config import RunConfig

Result = TypeVar("Result", bound=msgspec.Struct)


def depends_on(changes: RunConfig) -> str:
    """Hash of what a walk depends on beside its own folder's name: robot, wear, and the sources."""
    parts = load_body(changes.robot), load_wear(changes.wear), sources()
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


def kept(file: Path, key: str, kind: type[Result], make: Callable[[], Result]) -> Result:
    """What `file` holds, if it was written with the same key; else what `make` gives, then written there."""
    try:
        found, data = msgspec.json.decode(file.read_bytes(), type=tuple[str, msgspec.Raw])
        if found == key:
            return msgspec.json.decode(data, type=kind)
    except (OSError, msgspec.DecodeError):
        pass
    result = make()
    file.parent.mkdir(parents=True, exist_ok=True)
    half = file.with_suffix(".part")
    half.write_bytes(msgspec.json.encode((key, result)))
    os.replace(half, file)
    return result
