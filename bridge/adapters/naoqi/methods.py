"""Methods of a service, and who may call them when."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

import msgspec

from bridge.config import load_toml
from bridge.errors import NaoqiRefused

Kind = Literal["read", "joints", "posture", "walk"]
"""`read` needs nothing; `joints` commands them, and is refused during a walk; `posture` ends a walk for it;
`walk` is for the walker."""


@dataclass(frozen=True)
class Method:
    """One method of a service."""

    call: Callable[..., Any]
    kind: Kind
    signature: inspect.Signature


class _VendorMethods(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    ALMotion: list[str]
    ALMemory: list[str]
    DCM: list[str]
    ALRobotPosture: list[str]
    ALLeds: list[str]
    ALSonar: list[str]


VENDOR: Final[dict[str, list[str]]] = msgspec.structs.asdict(
    load_toml(Path(__file__).with_name("methods.toml"), _VendorMethods)
)
"""Module -> methods that the real one has."""


def of_kind(kind: Kind, table: Mapping[str, Callable[..., Any]]) -> dict[str, Method]:
    """Methods of one kind.

    Args:
        kind: of all of them.
        table: name -> what carries it out.
    """
    return {name: Method(call, kind, inspect.signature(call)) for name, call in table.items()}


def refused(service: str, method: str) -> Method:
    """A method that the vendor's service has and this one refuses.

    Args:
        service: name of the service.
        method: name of the method.
    """

    def refuse(*_: Any) -> None:
        raise NaoqiRefused(f"{service}.{method} is not offered by nao-hil; docs/naoqi.md lists what is.")

    return Method(refuse, "read", inspect.signature(refuse))
