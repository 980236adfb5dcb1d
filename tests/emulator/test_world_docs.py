"""The pages on world and scenarios name what there is, with its keys."""

from pathlib import Path
from typing import get_args

import pytest

from bridge.messages import faults
from bridge.messages.world import WorldCommand
from bridge.messages.world_state import WorldReply
from emulator.scenarios import SCENARIOS
from emulator.scenarios.model import Scenario

DOCS = Path(__file__).parents[2] / "docs"
COMMANDS, REPLY = (DOCS / "world.md").read_text().split("## WorldReply")
SCENARIO_PAGE = (DOCS / "scenarios.md").read_text()


def row(page: str, name: str) -> str:
    """The row of a table whose first cell names it."""
    rows = [line for line in page.splitlines() if line.startswith("|") and f"`{name}`" in line.split("|")[1]]
    assert len(rows) == 1, name
    return rows[0]


@pytest.mark.parametrize("command", get_args(WorldCommand), ids=lambda c: c.__name__)
def test_every_op_has_a_row_with_its_fields(command: type) -> None:
    line = row(COMMANDS, command.__struct_config__.tag)
    assert all(f"`{field}`" in line for field in command.__struct_fields__ if field != "version")


@pytest.mark.parametrize("fault", get_args(faults.Fault), ids=lambda f: f.__name__)
def test_every_fault_has_a_row_with_its_keys(fault: type) -> None:
    line = row(SCENARIO_PAGE, fault.__struct_config__.tag)
    assert all(f"`{field}`" in line for field in fault.__struct_fields__)


def test_every_scenario_and_every_table_of_one_is_named() -> None:
    for name in SCENARIOS:
        row(SCENARIO_PAGE, name)
    for table in Scenario.__struct_fields__:
        assert f"[{table}]" in SCENARIO_PAGE or f"`{table}`" in SCENARIO_PAGE
    for field in WorldReply.__struct_fields__:
        row(REPLY, field)
