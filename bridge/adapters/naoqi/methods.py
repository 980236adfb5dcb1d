"""Methods of a service: who may call them when, which ones the vendor's has, and how far ours go."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Literal

import msgspec
from msgspec.structs import replace

from bridge.config import read_toml
from bridge.errors import NaoqiRefused
from bridge.validation import convert

Kind = Literal["read", "joints", "posture", "walk"]
"""`read` needs nothing; `joints` commands them, and is refused during a walk; `posture` ends a walk for it;
`walk` is for the walker."""
Table = dict[str, Callable[..., Any]]
"""Name of a method -> what carries it out."""


@dataclass(frozen=True)
class Method:
    """One method of a service."""

    call: Callable[..., Any]
    kind: Kind
    offered: bool = True
    """Otherwise it only refuses."""

    @cached_property
    def signature(self) -> inspect.Signature:
        """Its parameters; read once they are needed, for a robot has 3,000 methods."""
        return inspect.signature(self.call)


class VendorService(msgspec.Struct, frozen=True):
    """What the vendor's service has."""

    methods: list[str] = []
    like: list[str] = []
    """Tables whose methods it has as well."""
    partly: dict[str, str] = {}
    """Method -> what ours leaves out or assumes."""
    no: dict[str, str] = {}
    """Method -> why it is refused; `*`: all others."""


def _vendor_services() -> dict[str, VendorService]:
    tables = convert(read_toml(Path(__file__).with_name("methods.toml")), dict[str, VendorService])
    services = {}
    for name, own in tables.items():
        like = [tables[of] for of in own.like]
        methods = sum((of.methods for of in like), own.methods)
        partly = {method: reason for of in like for method, reason in of.partly.items()} | own.partly
        services[name] = replace(own, methods=methods, partly=partly)
    common = {of for own in tables.values() for of in own.like}
    return {name: services[name] for name in services if name not in common}


VENDOR: Final = _vendor_services()
"""By service; methods of every module are under `ALModule`."""


def of_kind(kind: Kind, table: Mapping[str, Callable[..., Any]]) -> dict[str, Method]:
    """Methods of one kind.

    Args:
        kind: of all of them.
        table: name -> what carries it out.
    """
    return {name: Method(call, kind) for name, call in table.items()}


def refusals(service: str, methods: Iterable[str], offered: Iterable[str]) -> dict[str, Method]:
    """Methods that the vendor's service has and this one refuses.

    Args:
        service: name of the service.
        methods: of the vendor's.
        offered: methods that this one offers.
    """
    there = set(offered)
    default = f"{service} offers {', '.join(sorted(there)) or 'nothing'}"
    return {name: _refusal(service, name, default) for name in methods if name not in there}


def _refusal(service: str, method: str, default: str) -> Method:
    reasons = VENDOR[service].no if service in VENDOR else {}
    reason = reasons.get(method) or reasons.get("*") or default

    def refuse(*_: Any) -> None:
        raise NaoqiRefused(f"{service}.{method} is not offered by nao-hil: {reason}.")

    return Method(refuse, "read", offered=False)
