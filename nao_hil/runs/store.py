"""Results on disk, each under the fingerprint of all that it depends on, so that none is computed twice."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np

from bridge.body import load_body
from bridge.errors import ConfigurationError
from emulator.wear import load_wear
from nao_hil.runs.fingerprint import fingerprint
from nao_hil.runs.track import Track
from nao_hil.runs.walk import Walk, WalkEnd, WalkOutcome

Result = TypeVar("Result", bound=msgspec.Struct)


def key(walk: Walk) -> str:
    """Fingerprint of a walk: configuration, seed, world, contents of body and wear profile; not its name."""
    nameless = msgspec.structs.replace(walk, name="")
    return fingerprint(nameless, load_body(walk.config.robot), load_wear(walk.config.wear))


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

    def get(self, walk: Walk) -> WalkOutcome | None:
        """The walk, if it was walked before; None also for a file that cannot be read."""
        path = self._path(walk)
        try:
            with path.open("rb") as file, np.load(file) as data:
                end = msgspec.json.decode(data["end"].tobytes(), type=WalkEnd)
                return WalkOutcome(walk, end, Track(data["rows"]))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, msgspec.DecodeError):
            return None

    def put(self, result: WalkOutcome) -> None:
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


def stored(file: Path, key: str, kind: type[Result], make: Callable[[], Result]) -> Result:
    """The result in `file` if it was stored under the same key; else the result of `make`, which is stored.

    Args:
        file: JSON.
        key: Fingerprint of what the result depends on.
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
    half = file.with_suffix(".part")
    half.write_bytes(msgspec.json.encode((key, result)))
    os.replace(half, file)
    return result
