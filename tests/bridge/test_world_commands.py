"""World commands on the wire: what is right comes through, what is wrong is named."""

from typing import get_args

import msgspec
import pytest

from bridge.body.joints import INDEX
from bridge.errors import FrameError
from bridge.messages import decode_command, encode
from bridge.messages.faults import JointWeak, SensorDead
from bridge.messages.frames import sensor_slots
from bridge.messages.world import PlateUnderFoot, Push, StartFault, WorldCommand


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


def test_the_ops_are_told_apart() -> None:
    ops = [command.__struct_config__.tag for command in get_args(WorldCommand)]
    assert len(ops) == len(set(ops)) == 18


def test_sensors_are_selected_whole_or_by_element() -> None:
    assert sensor_slots("gyroscope") == ("gyroscope", (0, 1, 2))
    assert sensor_slots("position.LKneePitch") == ("position", (INDEX["LKneePitch"],))
    assert sensor_slots("fsr.RRR") == ("fsr", (7,))
    assert SensorDead(sensor="fsr.RRR").name == "sensor-dead:fsr.RRR"
    with pytest.raises(ValueError, match="did you mean 'LFL'"):
        sensor_slots("fsr.LFLL")
