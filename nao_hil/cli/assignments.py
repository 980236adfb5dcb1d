"""The option `--set NAME=VALUE` of the commands that design and plan."""

from __future__ import annotations

import json
import math
from typing import Annotated, Any, Final

import typer

from bridge.errors import ConfigurationError

Assignments = Annotated[
    list[str] | None,
    typer.Option("--set", help="Change one parameter; may be repeated.", metavar="NAME=VALUE"),
]
_NO_NUMBERS: Final = ("nan", "inf", "infinity")


def assignments(values: list[str]) -> dict[str, Any]:
    """Names and values of `--set`; a value is JSON, or text where it is not.

    Raises:
        ConfigurationError: not NAME=VALUE, or a number that is not finite.
    """
    table: dict[str, Any] = {}
    for value in values:
        name, equals, text = value.partition("=")
        if not equals or not name:
            raise ConfigurationError(f"--set {value}: is not NAME=VALUE, such as --set D_s=0.05.")
        try:
            table[name] = json.loads(text)
        except ValueError:
            table[name] = text
        if (
            table[name] != table[name]
            or table[name] in (math.inf, -math.inf)
            or text.lower().strip("+-") in _NO_NUMBERS
        ):
            raise ConfigurationError(f"--set {value}: must be a finite number, such as --set D_s=0.05.")
    return table
