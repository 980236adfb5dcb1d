"""Results of searches, kept by configuration: a plan is searched once for a body and its parameters."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Final

import msgspec

from bridge.datasheet import Body
from walker.gait.huang.hip import Choice
from walker.gait.huang.parameters import HuangParameters

VERSION: Final = 4
"""Of the planner: another one finds other results for the same configuration."""


class CachedChoice(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A choice on disk."""

    choice: Choice
    margin: float


def key(p: HuangParameters, body: Body) -> str:
    """Name of a configuration: the ground and the first foot make no difference to the cycle."""
    flat = msgspec.structs.replace(p, ground=type(p.ground)(), first_swing="R", progress=1.0)
    text = msgspec.json.encode((VERSION, flat, body))
    return hashlib.sha256(text).hexdigest()[:32]


def cache_folder() -> Path:
    """Where plans are kept: NAO_HIL_CACHE, else under the user's cache folder."""
    named = os.environ.get("NAO_HIL_CACHE")
    if named:
        return Path(named)
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "nao-hil" / "plans"


def load(name: str) -> CachedChoice | None:
    """A kept plan; None where there is none, or none that can be read."""
    try:
        return msgspec.json.decode((cache_folder() / f"{name}.json").read_bytes(), type=CachedChoice)
    except (OSError, RuntimeError, msgspec.MsgspecError):
        return None


def store(name: str, found: CachedChoice) -> None:
    """Keep a plan, where there is a place to write; without one it is searched again next time."""
    try:
        folder = cache_folder()
        folder.mkdir(parents=True, exist_ok=True)
        part = folder / f"{name}.{os.getpid()}.part"
        part.write_bytes(msgspec.json.encode(found))
        part.replace(folder / f"{name}.json")
    except (OSError, RuntimeError):
        pass
