"""Gaits that a network has learnt, each described by a sheet: `onnx:SHEET`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Final

from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from walker.gaits.gait import GaitKind
from walker.gaits.learned.gait import LearnedGait
from walker.gaits.learned.parameters import LearnedParameters

PREFIX: Final = "onnx:"
"""Begins the name of such a gait."""
POLICIES: Final = Path(__file__).parent / "policies"
"""Folder of the shipped sheets."""


def learned_kind(name: str) -> GaitKind:
    """The entry of a learned gait in the catalogue.

    Args:
        name: `onnx:SHEET`.
    """
    return GaitKind(LearnedParameters, partial(LearnedGait, name=name))


def sheet_path(name: str) -> Path:
    """The sheet that the name of a gait means: a shipped one by its name, or a file.

    Args:
        name: `onnx:NAME`, or `onnx:` and the path of a TOML file.

    Raises:
        ConfigurationError: no such shipped sheet.
    """
    given = name.removeprefix(PREFIX)
    path = Path(given)
    if path.suffix == ".toml" or path.name != given:
        return path
    shipped = {each.stem: each for each in POLICIES.glob("*.toml")}
    if given not in shipped:
        raise ConfigurationError(
            f"{unknown_name('policy', given, shipped)}; or give onnx:PATH of a sheet (.toml)."
        )
    return shipped[given]
