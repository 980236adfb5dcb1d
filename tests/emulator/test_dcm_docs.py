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


def test_every_row_has_a_source_and_a_test() -> None:
    assert len(ROWS) > 40
    for behaviour, source, test in ROWS:
        assert re.match(r"(.* )?(confirmed|assumed|project|contradiction)", source), behaviour
        assert test.strip("`") in TESTS, behaviour


def test_every_test_of_the_semantics_is_a_row() -> None:
    text = (ROOT / "tests" / "bridge" / "test_dcm_semantics.py").read_text()
    named = {test.strip("`") for _, _, test in ROWS}
    assert set(re.findall(r"^def (test_\w+)\(", text, re.MULTILINE)) <= named
