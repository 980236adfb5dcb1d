"""docs/dcm.md is the table of the DCM's semantics: every row names tests that are there."""

from __future__ import annotations

import re
from pathlib import Path

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
