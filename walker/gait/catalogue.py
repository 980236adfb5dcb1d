"""Gaits by name, with their parameters from TOML."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from bridge.config import load_toml
from bridge.datasheet import Body
from bridge.errors import ConfigurationError
from walker.gait.reference import Gait
from walker.gait.static import StaticGait, StaticParameters

_PARAMETERS = Path(__file__).with_name("parameters")

GAITS: Final[dict[str, tuple[type, Callable[[Any, Body], Gait]]]] = {
    "static": (StaticParameters, StaticGait),
}
"""Name of a gait -> (type of its parameters, its phase machine)."""


def make_gait(name: str, body: Body, file: Path | None = None) -> Gait:
    """A gait with the parameters of `file`, or the shipped ones.

    Raises:
        ConfigurationError: unknown gait, bad file, or parameters that the body cannot walk.
    """
    if name not in GAITS:
        raise ConfigurationError(f"There is no gait `{name}`; there is: {', '.join(GAITS)}.")
    kind, build = GAITS[name]
    return build(load_toml(file or _PARAMETERS / f"{name}.toml", kind), body)
