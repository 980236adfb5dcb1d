"""The vendor's predefined postures, as joint angles in frame order."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

import msgspec

from bridge.body.joints import JOINTS
from bridge.config import load_toml
from bridge.errors import ConfigurationError
from bridge.validation import unknown_name


class _Postures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    source: str
    postures: dict[str, dict[str, float]]


def load_postures(path: str | Path) -> dict[str, tuple[float, ...]]:
    """Postures of a TOML file: tables `postures.NAME`, each with all 25 joints by name.

    Returns:
        Name -> 25 positions in frame order, rad (hands: 0 closed, 1 open).

    Raises:
        ConfigurationError: unreadable, or a posture with a joint missing or misspelt.
    """
    postures = load_toml(path, _Postures).postures
    for name, position in postures.items():
        for joint in position:
            if joint not in JOINTS:
                raise ConfigurationError(f"{path}: postures.{name}: {unknown_name('joint', joint, JOINTS)}")
        missing = [joint for joint in JOINTS if joint not in position]
        if missing:
            raise ConfigurationError(f"{path}: postures.{name}: missing {', '.join(missing)}")
    return {name: tuple(position[joint] for joint in JOINTS) for name, position in postures.items()}


POSTURES: Final[Mapping[str, tuple[float, ...]]] = MappingProxyType(
    load_postures(Path(__file__).with_name("postures.toml"))
)
"""Stand, StandInit, StandZero, Crouch, Sit, SitRelax, LyingBelly, LyingBack: 25 positions in frame order.

A body without a joint ignores its value.
"""
