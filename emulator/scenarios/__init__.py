"""Scenarios: the shipped ones by name, anyone's own from a TOML file."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import msgspec

from bridge.config import load_toml
from bridge.errors import ConfigurationError
from bridge.files import read_table
from bridge.validation import unknown_name
from emulator.scenarios.ground import START_NAMES, Heightfield, PlacedBox
from emulator.scenarios.model import Scenario

_FOLDER: Final = Path(__file__).parent
SCENARIOS: Final = tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))
"""Names of the scenarios in the package."""
__all__ = ["FLAT", "SCENARIOS", "START_NAMES", "PlacedBox", "Scenario", "load_scenario"]
MAX_CSV: Final = 1 << 23
"""bytes of a file of heights."""
FLAT: Final = Scenario(title="A flat floor")


def load_scenario(name_or_path: str) -> Scenario:
    """A shipped scenario by name, or one from a TOML file.

    Raises:
        ConfigurationError: no such scenario, unknown key, an impossible value, or a bad CSV file.
    """
    if name_or_path in SCENARIOS:
        path = _FOLDER / f"{name_or_path}.toml"
    elif name_or_path.endswith(".toml"):
        path = Path(name_or_path)
    else:
        raise ConfigurationError(
            f"{unknown_name('scenario', name_or_path, SCENARIOS)}, or the path of a .toml file"
        )
    scenario = load_toml(path, Scenario)
    field = scenario.heightfield
    if field is not None and field.file:
        field = _with_heights(field, path.parent / field.file)
        scenario = msgspec.structs.replace(scenario, heightfield=field)
    return scenario


def _with_heights(field: Heightfield, path: Path) -> Heightfield:
    """The heights of a CSV file in place of its name."""
    right = f"give a CSV file of heights in m of at most {MAX_CSV} bytes"
    try:
        rows = [[float(cell) for cell in row.cells] for row in read_table(path, right, MAX_CSV)]
        table = {"spacing": field.spacing, "centre": field.centre, "heights": rows}
        return msgspec.convert(table, Heightfield)
    except (ValueError, msgspec.ValidationError) as error:
        raise ConfigurationError(
            f"{path}: is not a table of heights ({error}); numbers of m, separated by commas, are right"
        ) from None
