"""The parameters of a study with their ranges, from the command line and from a file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bridge.config import read_toml
from bridge.errors import ConfigurationError
from nao_hil.campaigns.study import Range


def read_space(texts: Sequence[str], file: Path | None) -> dict[str, Range]:
    """Ranges by name.

    Args:
        texts: `NAME=LOW:HIGH`, or `NAME=LOW:HIGH:log` for a logarithmic one.
        file: TOML: `NAME = [LOW, HIGH]` or `[LOW, HIGH, "log"]`, in tables or with quoted dotted names.

    Raises:
        ConfigurationError: not of these forms, or no parameter at all.
    """
    found = dict(_flat(read_toml(file), str(file))) if file else {}
    for text in texts:
        name, equals, values = text.partition("=")
        if not equals or not name:
            raise _wrong(text)
        found[name] = _range(text, values.split(":"))
    if not found:
        raise ConfigurationError("tune: name at least one parameter, such as controller.damping.roll=0:0.15.")
    return found


def _flat(table: dict[str, Any], where: str, prefix: str = "") -> list[tuple[str, Range]]:
    found = []
    for key, value in table.items():
        if isinstance(value, dict):
            found += _flat(value, where, f"{prefix}{key}.")
        elif isinstance(value, list):
            found.append((prefix + key, _range(f"{where}: {prefix}{key}", value)))
        else:
            raise _wrong(f"{where}: {prefix}{key}")
    return found


def _range(where: str, values: Sequence[Any]) -> Range:
    log = len(values) == 3 and values[2] == "log"
    try:
        low, high = map(float, values[:2] if log else values)
    except (TypeError, ValueError):
        raise _wrong(where) from None
    if not (math.isfinite(low) and math.isfinite(high) and low < high) or (log and low <= 0.0):
        raise _wrong(where)
    return Range(low, high, log)


def _wrong(where: str) -> ConfigurationError:
    return ConfigurationError(
        f"{where}: must be NAME=LOW:HIGH with LOW < HIGH, or NAME=LOW:HIGH:log with 0 < LOW < HIGH."
    )
