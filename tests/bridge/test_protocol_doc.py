"""`docs/protocol.md` against the code: examples, tables of fields, joints, foot sensors."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import msgspec
import pytest

from bridge import messages
from bridge.datasheet import load_body
from bridge.joints import JOINTS
from bridge.messages import MAX_PAYLOAD, SCHEMA_VERSION, decode, encode

PAGE = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text(encoding="utf-8")
FRAMES = ["SensorFrame", "ActuatorFrame", "LeaseRequest", "LeaseReply"]
MESSAGES = [*FRAMES, "Info", "Notice", "TruthFrame", "WalkTelemetry"]


def section(title: str) -> str:
    """The text below a heading, up to the next one."""
    found = re.search(rf"^#+ {re.escape(title)}\n(.*?)(?=^#+ |\Z)", PAGE, re.MULTILINE | re.DOTALL)
    assert found is not None, title
    return found[1]


def rows(text: str) -> list[list[str]]:
    """Cells of the tables in a text, without headings and rules."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def example(name: str) -> tuple[dict[str, Any], bytes]:
    """The values and the bytes of a worked example."""
    text = section(f"Example {name}")
    values = json.loads(text.split("```json\n")[1].split("```")[0])
    dump = text.split("```hexdump\n")[1].split("```")[0]
    octets = "".join(line[6:].split("  |")[0] for line in dump.splitlines())
    return values, bytes.fromhex(octets)


@pytest.mark.parametrize("name", FRAMES)
def test_the_bytes_of_an_example_are_its_values(name: str) -> None:
    values, payload = example(name)
    kind = getattr(messages, name)
    assert encode(msgspec.convert(values, kind)) == payload
    assert json.loads(msgspec.json.encode(decode(payload, kind))) == values
    assert f"{len(payload)} bytes" in section(f"Example {name}")


@pytest.mark.parametrize("name", MESSAGES)
def test_the_table_of_a_message_has_its_fields_in_order(name: str) -> None:
    documented = [field for row in rows(section(name)) for field in re.findall(r"`(\w+)`", row[0])]
    assert documented == list(getattr(messages, name).__struct_fields__)


@pytest.mark.parametrize("name", MESSAGES)
def test_a_field_may_be_left_out_exactly_if_the_table_gives_a_default(name: str) -> None:
    optional = {field: row[2] != "" for row in rows(section(name)) for field in re.findall(r"`(\w+)`", row[0])}
    fields = msgspec.structs.fields(getattr(messages, name))
    assert optional == {field.name: not field.required for field in fields}


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
