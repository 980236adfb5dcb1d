"""Gaits by name, with their parameters: the shipped ones, changed where the user says so.

To add a gait takes its folder here and its name in `GAITS`.
"""

from __future__ import annotations

import functools
import importlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.body import Body
from bridge.config import from_dict, load_toml
from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from walker.planning.gait import Gait, GaitKind
from walker.planning.parameters import GaitParameters

GAITS: Final = ("static", "dynamic", "huang", "omni")
"""Names of the gaits: each is a folder beside this file, whose package has the gait's `KIND`."""


@functools.lru_cache
def gait_kind(name: str) -> GaitKind:
    """What the folder of a gait tells.

    Raises:
        ConfigurationError: unknown gait.
    """
    if name not in GAITS:
        raise ConfigurationError(unknown_name("gait", name, GAITS))
    kind: GaitKind = importlib.import_module(f"walker.planning.{name}").KIND
    return kind


def gait_file(name: str, file: str) -> Path:
    """Path of a file in the folder of a gait.

    Args:
        name: of the gait.
        file: its name.

    Raises:
        ConfigurationError: unknown gait.
    """
    gait_kind(name)
    return Path(__file__).parent / name / file


def gait_parameters(name: str, changes: Mapping[str, Any] | None = None) -> GaitParameters:
    """The shipped parameters of a gait, with some of them changed.

    Args:
        name: of the gait.
        changes: values that differ from the shipped ones.

    Raises:
        ConfigurationError: unknown gait, unknown or ill-typed parameter.
    """
    kind = gait_kind(name).parameters
    shipped = load_toml(gait_file(name, "gait.toml"), kind)
    return from_dict(msgspec.to_builtins(shipped) | dict(changes or {}), f"gait {name}", kind)


def make_gait(name: str, parameters: GaitParameters, body: Body) -> Gait[Any]:
    """A gait for a body.

    Args:
        name: of the gait.
        parameters: of its type.
        body: data sheet.

    Raises:
        ConfigurationError: parameters that this body cannot walk; names the violated bound.
    """
    return gait_kind(name).make(parameters, body)
