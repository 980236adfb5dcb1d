from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS
from bridge.errors import FrameError
from bridge.messages import (
    MAX_PAYLOAD,
    SCHEMA_VERSION,
    ActuatorFrame,
    Contact,
    LeaseReply,
    LeaseRequest,
    Notice,
    SensorFrame,
    decode,
    decode_command,
    encode,
)
from bridge.messages.columns import COLUMNS
from bridge.messages.faults import JointWeak, SensorDead
from bridge.messages.frames import ELEMENTS, sensor_slots
from bridge.messages.world import PlateUnderFoot, Push, StartFault, WorldCommand
from bridge.messages.world_state import WorldObject
from bridge.recording.canonical import LEFT_OUT, RECORDED
from tests.frames import info_of_robot, standing_frame, truth_frame, walk_telemetry

FINITE = st.floats(allow_nan=False, allow_infinity=False)
COUNT = st.integers(0, 2**63 - 1)


def floats(n: int) -> st.SearchStrategy[tuple[float, ...]]:
    return st.lists(FINITE, min_size=n, max_size=n).map(tuple)


SENSOR_FRAME = st.builds(
    SensorFrame,
    seq=COUNT,
    time=FINITE,
    **{name: floats(len(elements)) for name, elements in ELEMENTS.items()},
    command=st.integers(-1, 2**63 - 1),
    missed=COUNT,
    wall=COUNT,
)
ACTUATOR_FRAME = st.builds(
    ActuatorFrame, reply_to=COUNT, lease=COUNT, position=floats(25), stiffness=floats(25), wall=COUNT
)
ZEROS = (0.0,) * 25
COMMAND = ActuatorFrame(reply_to=7, lease=3, position=ZEROS, stiffness=ZEROS)
MESSAGES = (
    *(standing_frame(3), COMMAND, info_of_robot(absent=("LHand",)), walk_telemetry(3, tick=0.001)),
    truth_frame(3, zmp=(0.1, -0.2), left=Contact(force=(1.0, 2.0, 3.0), cop=(0.01, 0.02)), fell=True),
    LeaseRequest(op="acquire", controller="anna", key="0a" * 32),
    LeaseReply(granted=True, lease=3, holder="anna", message="ä"),
    Notice(seq=1, level="info", code="clipped", text="LKneePitch"),
)


def fields(**changes: Any) -> dict[str, Any]:
    """The fields of a good actuator frame, some of them changed."""
    return msgspec.to_builtins(COMMAND) | changes


def refusal(fields: Any) -> str:
    with pytest.raises(FrameError) as error:
        decode(msgspec.msgpack.encode(fields), ActuatorFrame)
    return str(error.value)


@given(SENSOR_FRAME | ACTUATOR_FRAME)
def test_a_frame_comes_out_as_it_went_in(message: Any) -> None:
    assert decode(encode(message), type(message)) == message


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_a_message_comes_out_as_it_went_in(message: Any) -> None:
    assert decode(encode(message), type(message)) == message


@pytest.mark.parametrize("kind", [type(message) for message in MESSAGES])
@given(payload=st.binary(max_size=300))
def test_random_bytes_are_refused_and_nothing_else_happens(kind: type[Any], payload: bytes) -> None:
    with pytest.raises(FrameError):
        decode(payload, kind)


@given(SENSOR_FRAME | ACTUATOR_FRAME, st.data())
def test_a_truncated_frame_is_refused(frame: Any, data: st.DataObject) -> None:
    payload = encode(frame)
    end = data.draw(st.integers(0, len(payload) - 1))
    with pytest.raises(FrameError):
        decode(payload[:end], type(frame))


@given(SENSOR_FRAME | ACTUATOR_FRAME, st.data())
def test_a_mutated_frame_is_refused_or_still_a_valid_frame(frame: Any, data: st.DataObject) -> None:
    payload = bytearray(encode(frame))
    for _ in range(data.draw(st.integers(1, 4))):
        payload[data.draw(st.integers(0, len(payload) - 1))] = data.draw(st.integers(0, 255))
    try:
        decoded = decode(bytes(payload), type(frame))
    except FrameError:
        return
    assert len(decoded.position) == len(decoded.stiffness) == 25
    assert all(math.isfinite(v) for v in (*decoded.position, *decoded.stiffness))


@pytest.mark.parametrize("field", ["position", "stiffness"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("slot", [0, 8, 24])
def test_a_number_that_is_none_is_refused_by_field_index_and_joint(field: str, value: float, slot: int) -> None:
    values = [0.0] * 25
    values[slot] = value
    sentence = refusal(fields(**{field: values}))
    assert f"{field}[{slot}]" in sentence
    assert JOINTS[slot] in sentence
    assert "finite" in sentence


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_sensor_frame_has_finite_numbers_only(value: float) -> None:
    frame = standing_frame(accelerometer=(0.0, value, 0.0))
    with pytest.raises(FrameError, match=r"accelerometer\[1\]"):
        decode(encode(frame), SensorFrame)


@pytest.mark.parametrize("n", [0, 24, 26])
def test_a_wrong_length_is_refused_by_field_and_right_length(n: int) -> None:
    sentence = refusal(fields(position=[0.0] * n))
    assert "position" in sentence
    assert "25" in sentence


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("position", ["0.5"] + [0.0] * 24),
        ("position", [True] + [0.0] * 24),
        ("position", [None] + [0.0] * 24),
        ("position", 0.0),
        ("reply_to", "7"),
        ("reply_to", 7.0),
        ("reply_to", -1),
        ("reply_to", 2**64 - 1),
        ("lease", -1),
        ("lease", None),
    ],
)
def test_an_ill_typed_field_is_refused_by_name(field: str, value: Any) -> None:
    assert field in refusal(fields(**{field: value}))


def test_integers_are_taken_for_floats_and_unknown_fields_ignored() -> None:
    raw = fields(position=[1] * 25, colour="red")
    assert decode(msgspec.msgpack.encode(raw), ActuatorFrame).position == (1.0,) * 25


def test_another_version_is_blamed_rather_than_a_field_it_changed() -> None:
    sentence = refusal({"version": 1, "angles": [0.0] * 25})
    assert "version 1" in sentence
    assert str(SCHEMA_VERSION) in sentence
    assert "version 9" in refusal(fields(version=9))


def test_a_payload_that_is_too_long_is_refused_unread() -> None:
    padded = msgspec.msgpack.encode(fields(padding="x" * MAX_PAYLOAD))
    with pytest.raises(FrameError, match=str(MAX_PAYLOAD)):
        decode(padded, ActuatorFrame)


@pytest.mark.parametrize("name", ["", "a/b", "a*", "a b", "ä", "a\n", "x" * 65])
def test_a_name_that_cannot_be_part_of_a_key_is_refused(name: str) -> None:
    request = msgspec.msgpack.encode({"op": "acquire", "controller": name})
    with pytest.raises(FrameError, match="controller"):
        decode(request, LeaseRequest)


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


def test_the_foot_sensors_are_where_the_data_sheet_has_them() -> None:
    fsr = load_body("nao-v3").fsr
    places = [(float(row[2]), float(row[3])) for row in rows(section("Foot sensors"))]
    assert places == [(x, y) for x, y, _ in (*fsr.L, *fsr.R)]


def decoded(payload: bytes) -> WorldCommand:
    command: WorldCommand = decode_command(payload, WorldCommand, "World command")
    return command


def packed(**fields: object) -> bytes:
    return msgspec.msgpack.encode(fields)


def test_a_command_from_any_language_is_a_map_with_an_op() -> None:
    assert decoded(packed(op="push", impulse=[1, 0, 0.5])) == Push(impulse=(1.0, 0.0, 0.5))
    assert decoded(packed(op="plate-under-foot", foot="left")) == PlateUnderFoot(foot="left")
    fault = {"kind": "joint-weak", "joint": "RHipRoll", "fraction": 0.3}
    command = StartFault(fault=JointWeak(joint="RHipRoll", fraction=0.3), duration=2.0)
    assert decoded(packed(op="fault-on", fault=fault, duration=2.0)) == command
    assert decoded(encode(command)) == command


@pytest.mark.parametrize(
    ("payload", "says"),
    [
        (b"", "not one whole msgpack map"),
        (packed(op="psh"), r"`op`: unknown value 'psh' \(did you mean 'push'\?\).*known: .*status, step"),
        (packed(), "missing key 'op'; one of .*status, step"),
        (packed(op="tilt", pich=0.1), r"unknown key 'pich' \(did you mean 'pitch'\?\)\.$"),
        (
            packed(op="fault-on", fault={"kind": "joint-weak", "joint": "LKneePitch", "frction": 0.1}),
            "'fraction'",
        ),
        (packed(op="push"), "impulse"),
        (packed(op="push", impulse=[1.0, float("nan"), 0.0]), r"impulse\[1\]"),
        (packed(op="push", impulse=[1.0, 0.0, 0.0], version=9), "schema version 9"),
        (packed(op="push", impulse=[0.0, -100.1, 0.0]), r"impulse\[1\]`: expected a number >= -100"),
        (packed(op="push", impulse=[1e9, 0.0, 0.0]), r"impulse\[0\]`: expected a number <= 100"),
        (packed(op="tilt", pitch=2.0), "`pitch`: expected a number <= 0.6"),
        (packed(op="friction", friction=-1.0), "`friction`: expected a number >= 0.0"),
        (packed(op="place", name="a/b", size=[1, 1, 1], at=[0, 0]), "`name`: expected 1 to 64 letters"),
        (packed(op="step", cycles=0), "`cycles`: expected a whole number >= 1"),
        (packed(op="fault-on", fault={"kind": "sensor-dead", "sensor": "gyro"}), "did you mean 'gyroscope'"),
        (packed(op="fault-on", fault={"kind": "joint-stuck", "joint": "LKnee"}), "did you mean 'LKneePitch'"),
    ],
)
def test_a_wrong_command_is_refused_with_the_field_or_the_ops(payload: bytes, says: str) -> None:
    with pytest.raises(FrameError, match=says):
        decoded(payload)


def test_sensors_are_selected_whole_or_by_element() -> None:
    assert sensor_slots("gyroscope") == ("gyroscope", (0, 1, 2))
    assert sensor_slots("position.LKneePitch") == ("position", (INDEX["LKneePitch"],))
    assert sensor_slots("fsr.RRR") == ("fsr", (7,))
    assert SensorDead(sensor="fsr.RRR").name == "sensor-dead:fsr.RRR"
    with pytest.raises(ValueError, match="did you mean 'LFL'"):
        sensor_slots("fsr.LFLL")


@pytest.mark.parametrize("kind", [*RECORDED, WorldObject])
def test_every_recorded_quantity_is_a_declared_column(kind: type[msgspec.Struct]) -> None:
    fields = []
    for field in msgspec.structs.fields(kind):
        parts = getattr(field.type, "__struct_fields__", None)
        fields += [f"{field.name}.{part}" for part in parts] if parts else [field.name]
    assert list(COLUMNS[kind]) == [name for name in fields if name not in {*LEFT_OUT, "version", "objects"}]
