"""Walks on disk, each under a hash of everything that it depends on: what was walked is not walked again."""

from __future__ import annotations

import hashlib
import os
import zipfile
from functools import cache
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from bridge.datasheet import load_body
from bridge.errors import ConfigurationError
from emulator.wear import load_wear
from lab.campaign.track import Track
from lab.campaign.walk import Walk, WalkEnd, WalkResult

_ROOT: Final = Path(__file__).parents[2]
_DEPENDS_ON: Final = ("bridge", "emulator", "walker", "lab/campaign", "lab/inprocess.py")
"""Sources and numbers that a walk may depend on."""


@cache
def sources() -> str:
    """Hash of the code and the shipped numbers as they are now; once per process."""
    digest = hashlib.sha256()
    for part in _DEPENDS_ON:
        path = _ROOT / part
        files = sorted(path.rglob("*")) if path.is_dir() else [path]
        for file in files:
            if file.suffix in (".py", ".toml"):
                digest.update(str(file.relative_to(_ROOT)).encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()


def key(walk: Walk) -> str:
    """Hash of a walk: its configuration and seed, its world, body, wear, and the sources; not its name."""
    parts = (
        msgspec.structs.replace(walk, name=""),
        load_body(walk.config.robot),
        load_wear(walk.config.wear),
        sources(),
    )
    # by repr, which names every field: the encoders leave some out that are at their default, by identity
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


class Store:
    """A folder of walks.

    Args:
        folder: Made if it is not there.

    Raises:
        ConfigurationError: it cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigurationError(
                f"{folder}: the folder for the walks cannot be made ({error.strerror}); give a writable one."
            ) from None

    def get(self, walk: Walk) -> WalkResult | None:
        """The walk, if it was walked before; None also for a file that cannot be read."""
        path = self._path(walk)
        try:
            with path.open("rb") as file, np.load(file) as data:
                end = msgspec.json.decode(data["end"].tobytes(), type=WalkEnd)
                return WalkResult(walk, end, Track(data["rows"]))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, msgspec.DecodeError):
            return None

    def put(self, result: WalkResult) -> None:
        """Keep a walk; a file is there whole or not at all."""
        path = self._path(result.walk)
        half = path.with_suffix(".part")
        with half.open("wb") as file:
            np.savez_compressed(
                file,
                rows=result.track.rows,
                end=np.frombuffer(msgspec.json.encode(result.end), dtype=np.uint8),
                walk=np.frombuffer(msgspec.json.encode(result.walk), dtype=np.uint8),
            )
        os.replace(half, path)

    def _path(self, walk: Walk) -> Path:
        return self._folder / f"{key(walk)}.npz"
