"""The shipped controller parameters of each gait, changed where the user says so."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.config import from_dict, load_toml, unknown_name
from bridge.errors import ConfigurationError
from walker.gait import GAITS
from walker.parameters.model import ControllerParameters

_SHIPPED: Final = Path(__file__).parent


def controller_parameters(gait: str, changes: Mapping[str, Any] | None = None) -> ControllerParameters:
    """The controller's parameters for a gait.

    Args:
        gait: name of the gait.
        changes: values that differ from the shipped ones; tables may be given in part.

    Raises:
        ConfigurationError: unknown gait, unknown or ill-typed parameter, or a parameter outside its bounds.
    """
    if gait not in GAITS:
        raise ConfigurationError(unknown_name("gait", gait, GAITS))
    shipped = load_toml(_SHIPPED / f"{gait}.toml", ControllerParameters)
    return from_dict(_merged(msgspec.to_builtins(shipped), changes or {}), "controller", ControllerParameters)


def _merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with `changes` laid over it, table by table."""
    merged = dict(base)
    for key, value in changes.items():
        below = merged.get(key)
        if isinstance(below, Mapping) and isinstance(value, Mapping):
            merged[key] = _merged(below, value)
        else:
            merged[key] = value
    return merged
