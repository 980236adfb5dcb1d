"""The pages on DCM, world and scenarios name all there is."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import pytest

from bridge.messages import faults
from bridge.messages.world import WorldCommand
from bridge.messages.world_state import WorldReply
from emulator.scenarios import SCENARIOS
from emulator.scenarios.model import Scenario

ROOT = Path(__file__).parents[2]
ROWS = [
    [cell.strip() for cell in line.strip("|\n ").split("|")]
    for line in (ROOT / "docs" / "dcm.md").read_text().split("## The queries")[0].splitlines()
    if line.startswith("| ") and not line.startswith("| Behaviour")
]
TESTS = {
    name
    for path in (ROOT / "tests").rglob("test_dcm*.py")
    for name in re.findall(r"^def (test_\w+)\(", path.read_text(), re.MULTILINE)
}
DOCS = Path(__file__).parents[2] / "docs"
COMMANDS, REPLY = (DOCS / "world.md").read_text().split("## WorldReply")
SCENARIO_PAGE = (DOCS / "scenarios.md").read_text()


def test_every_row_has_a_source_and_tests() -> None:
    assert len(ROWS) > 30
    for behaviour, source, tests in ROWS:
        assert re.match(r"(.* )?(2\.x|2010|confirmed|assumed|project|contradiction)", source), behaviour
        named = set(re.findall(r"`(\w+)`", tests))
        assert named and named <= TESTS, behaviour


def test_every_test_of_the_semantics_is_in_a_row() -> None:
    text = (ROOT / "tests" / "bridge" / "test_dcm_semantics.py").read_text()
    named = {name for _, _, tests in ROWS for name in re.findall(r"`(\w+)`", tests)}
    assert set(re.findall(r"^def (test_\w+)\(", text, re.MULTILINE)) <= named


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
