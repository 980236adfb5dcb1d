"""What `docs/protocol.md` says of joints, foot sensors and limits, against the code.

Its tables of fields and its examples are held in `tests/system/test_protocol_controller.py`.
"""

from __future__ import annotations

import re
from pathlib import Path

from bridge.body import load_body
from bridge.body.joints import JOINTS
from bridge.messages import MAX_PAYLOAD, SCHEMA_VERSION

PAGE = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text(encoding="utf-8")


def section(title: str) -> str:
    """The text below a heading, up to the next one."""
    found = re.search(rf"^#+ {re.escape(title)}\n(.*?)(?=^#+ |\Z)", PAGE, re.MULTILINE | re.DOTALL)
    assert found is not None, title
    return found[1]


def rows(text: str) -> list[list[str]]:
    """Cells of the tables in a text, without headings and rules."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def test_the_joints_have_their_slots() -> None:
    pairs = [
        (int(row[i]), row[i + 1]) for row in rows(section("Joints")) for i in (0, 2, 4) if row[i].isdigit()
    ]
    assert sorted(pairs) == list(enumerate(JOINTS))


def test_the_foot_sensors_are_where_the_data_sheet_has_them() -> None:
    fsr = load_body("nao-v3").fsr
    places = [(float(row[2]), float(row[3])) for row in rows(section("Foot sensors"))]
    assert places == [(x, y) for x, y, _ in (*fsr.L, *fsr.R)]


def test_version_and_largest_payload_are_those_in_force() -> None:
    assert f"Schema version **{SCHEMA_VERSION}**" in PAGE
    assert f"more than {MAX_PAYLOAD} bytes" in PAGE
