"""Gaits by name, with their parameters: the shipped ones, changed where the user says so."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.config import from_dict, load_toml, unknown_name
from bridge.datasheet import Body
from bridge.errors import ConfigurationError
from walker.gait.dynamic import DynamicGait
from walker.gait.huang import HuangGait, HuangParameters
from walker.gait.pendulum import DynamicParameters
from walker.gait.reference import Gait
from walker.gait.static import StaticGait, StaticParameters

_SHIPPED: Final = Path(__file__).with_name("parameters")

GAITS: Final[dict[str, tuple[type[msgspec.Struct], Callable[[Any, Body], Gait]]]] = {
    "static": (StaticParameters, StaticGait),
    "dynamic": (DynamicParameters, DynamicGait),
    "huang": (HuangParameters, HuangGait),
}
"""Name of a gait -> (type of its parameters, its phase machine)."""


def gait_parameters(name: str, changes: Mapping[str, Any] | None = None) -> msgspec.Struct:
    """The shipped parameters of a gait, with some of them changed.

    Raises:
        ConfigurationError: unknown gait, unknown or ill-typed parameter.
    """
    if name not in GAITS:
        raise ConfigurationError(unknown_name("gait", name, GAITS))
    kind, _ = GAITS[name]
    shipped = load_toml(_SHIPPED / f"{name}.toml", kind)
    return from_dict(msgspec.to_builtins(shipped) | dict(changes or {}), f"gait {name}", kind)


def make_gait(name: str, parameters: msgspec.Struct, body: Body) -> Gait:
    """A gait in its initial stand.

    Raises:
        ConfigurationError: parameters that this body cannot walk; names the violated bound.
    """
    return GAITS[name][1](parameters, body)
