"""docs/protocol.md says what is so: its types, its signs, its bytes, and a controller written from it."""

from __future__ import annotations

import json
import math
import re
import types
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import msgspec
import pytest
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey

from bridge import guard, messages
from bridge.body import load_body
from bridge.link import ControllerLink
from bridge.link.seal import Seal
from bridge.messages import frames, walk
from emulator.robot import EmulatedRobot
from tests.loops import TIMEOUT
from tests.processes import module_of

REPOSITORY = Path(__file__).parents[2]
PAGE = (REPOSITORY / "docs" / "protocol.md").read_text()
SCRIPT = Path(__file__).with_name("protocol_controller.py")
MESSAGES = [
    "SensorFrame",
    "ActuatorFrame",
    "Info",
    "LeaseRequest",
    "LeaseReply",
    "GuardStatus",
    "StopRequest",
    "ArmRequest",
    "Notice",
    "TruthFrame",
    "WalkTelemetry",
    "UpperBody",
    "LedFrame",
    "WalkCommand",
    "WalkStatus",
]


def section(title: str) -> str:
    """Text below a heading, up to the next of the same level or above."""
    hashes, _, _ = title.partition(" ")
    end = rf"(?=^#{{1,{len(hashes)}}} |\Z)"
    found = re.search(rf"^{re.escape(title)}\n(.*?){end}", PAGE, re.DOTALL | re.MULTILINE)
    assert found, title
    return found[1]


def rows(text: str) -> list[list[str]]:
    """Cells of the first table, without its head."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines[2:]]


def documented(kind: str) -> dict[str, tuple[str, str]]:
    """Type and default of each field in the page's table, and of the field that every message has."""
    table = rows(section(f"### {kind}"))
    fields = {
        name: (kind, default)
        for row in table
        for kind, _, default in [row[1].partition(" = ")]
        for name in re.findall(r"`(\w+)`", row[0])
    }
    return fields | {"version": ("int", "3")}


def in_words(hint: Any) -> str:
    """A field's type in the words of the page."""
    if get_origin(hint) is Annotated:
        inner, meta = get_args(hint)[0], get_args(hint)[1]
        if hint == frames.Name:
            return "name"
        if inner is int and meta.ge == -1:
            return "int from -1"
        if meta.min_length is not None:
            assert meta.min_length == meta.max_length
            return f"{in_words(get_args(inner)[0])}[{meta.min_length}]"
        return in_words(inner)
    if get_origin(hint) in (Union, types.UnionType):
        return f"{in_words(get_args(hint)[0])} or nil"
    if get_origin(hint) is Literal:
        return "text"
    if get_origin(hint) is tuple:
        members = get_args(hint)
        return f"{in_words(members[0])}[{'' if members[-1] is Ellipsis else len(members)}]"
    return {int: "int", float: "float", str: "text", bool: "bool"}.get(hint) or str(hint.__name__)


def default_in_words(value: Any) -> str:
    if isinstance(value, tuple):
        return ", ".join(map(default_in_words, value))
    if isinstance(value, str):
        return value or "empty"
    if value is None or isinstance(value, bool):
        return {None: "nil", False: "false", True: "true"}[value]
    return "" if isinstance(value, msgspec.Struct) else f"{value:g}"


@pytest.mark.parametrize("kind", MESSAGES)
def test_the_tables_give_each_field_its_type_and_default(kind: str) -> None:
    struct = next(getattr(module, kind) for module in (messages, walk, guard) if hasattr(module, kind))
    fields = {
        f.name: (in_words(f.type), "" if f.required else default_in_words(f.default))
        for f in msgspec.structs.fields(struct)
    }
    assert fields == documented(kind)


@pytest.mark.parametrize("row", rows(section("## Signs")), ids=lambda row: row[0])
def test_the_signs_are_those_of_the_emulated_robot(row: list[str]) -> None:
    angle = math.radians(20.0) / 2.0
    turned = {
        "upright": (0.0, 0.0, 0.0, 1.0),
        "nose down by 20 deg": (0.0, math.sin(angle), 0.0, math.cos(angle)),
        "leaning right by 20 deg": (math.sin(angle), 0.0, 0.0, math.cos(angle)),
    }[row[0]]
    with EmulatedRobot(load_body("nao-v3"), seed=0, held=True, lift=0.5, orientation=turned) as robot:
        frame = robot.frame
    assert [*frame.angle, *frame.accelerometer] == pytest.approx([float(cell) for cell in row[1:]], abs=6e-3)


def stranger() -> Any:
    return module_of(SCRIPT)


def test_the_seal_printed_is_that_of_both_sides() -> None:
    (values,) = re.findall(r"```json\n(.*?)```", section("### Example seal"), re.DOTALL)
    example = {name: bytes.fromhex(value) for name, value in json.loads(values).items()}
    (request,) = re.findall(r"```hex\n(.*?)```", section("### Example LeaseRequest"), re.DOTALL)
    payload, key = bytes.fromhex(request), "nao/nao/lease"
    private = X25519PrivateKey.from_private_bytes(example["private"])
    secret = stranger().shared_secret(private, example["robot"].hex())
    assert secret == example["secret"]
    assert stranger().Sealer(secret)(key, payload) == example["attachment"]
    assert Seal("stranger", secret, count(1)).opens(key, payload, example["attachment"])
    assert Seal("robot", secret, count(1)).send(key, payload, bytes) == example["attachment"]
    own = private.public_key().public_bytes_raw().hex()
    assert msgspec.msgpack.decode(payload)["key"] == own


@pytest.mark.parametrize("kind", ["LeaseRequest", "LeaseReply", "ActuatorFrame", "SensorFrame"])
def test_the_bytes_printed_are_those_of_both_encoders(kind: str) -> None:
    text = section(f"### Example {kind}")
    (values,) = re.findall(r"```json\n(.*?)```", text, re.DOTALL)
    (dump,) = re.findall(r"```hex\n(.*?)```", text, re.DOTALL)
    payload = bytes.fromhex(dump)
    fields = json.loads(values)
    assert text.startswith(f"\n{len(payload)} bytes of")
    assert stranger().pack(fields) == payload
    assert stranger().unpack(payload) == fields
    message = messages.decode(payload, getattr(messages, kind))
    assert messages.encode(message) == payload
    assert json.loads(msgspec.json.encode(message)) == fields


@pytest.mark.parametrize("mode", ["lockstep", pytest.param("real-time", marks=pytest.mark.realtime)])
def test_a_controller_written_from_the_page_moves_the_head(
    start: Callable[..., Any], endpoint: str, tmp_path: Path, mode: str
) -> None:
    emulate = ["emulate", "--engine", "mujoco", "--listen", endpoint, "--mode", mode]
    robot = start(*emulate, "--out", str(tmp_path / "run"))
    with ControllerLink(connect=endpoint, name="test") as link:
        link.wait_robot(timeout=TIMEOUT)
    script = f"import runpy; runpy.run_path({str(SCRIPT)!r}, run_name='__main__')"
    controller = start(endpoint, "nao", "120", script=script)
    assert controller.wait() == 0, controller.stderr
    result = controller.result
    robot.interrupt()

    assert result["mode"] == mode
    assert result["absent"] == ["LWristYaw", "RWristYaw", "LHand", "RHand"]
    assert result["frames"] >= 2
    # One swing of 0.3 rad each way; the servo trails it by a few hundredths.
    assert result["head"] == pytest.approx([-0.3, 0.3], abs=0.08)
    assert math.hypot(*result["accelerometer"]) == pytest.approx(9.81, abs=0.2)
    if mode == "lockstep":
        assert (result["missed"], result["late"]) == (0, 0)
