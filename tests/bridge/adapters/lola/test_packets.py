from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple
from pathlib import Path
from typing import Any

import msgpack
import pytest

from bridge.adapters.lola import codec
from bridge.adapters.lola.codec import MapStream, pack_map
from bridge.adapters.lola.packets import (
    ACCELEROMETER_STEP,
    GYROSCOPE_STEP,
    RESIDUE_SIGNS,
    HeatStatus,
    Identity,
    actuator_map,
    identity_of,
    lola_values,
    quantized,
    sensor_frame,
    sensor_packet,
)
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame
from bridge.messages.frames import ELEMENTS

DATA = Path(__file__).parent / "data"
# Values that BerlinUnited/NaoTH print of a V6 that sits, packed again in LoLA's form.
SENSORS = (DATA / "sensors.msgpack").read_bytes()
# All keys a client may send, every value 0.
ACTUATORS = (DATA / "actuators.msgpack").read_bytes()
# Of another V6: those values of the nao_lola project's test that look as they were captured.
SECOND = {
    "Accelerometer": (-3.0656251907348633, -0.3927832245826721, -9.321416854858398),
    "Angles": (0.03758257254958153, -0.35991066694259644),
    "Gyroscope": (-0.0002663161139935255, -0.001065264455974102, 0.001065264455974102),
    "Position": (
        *(0.5936160087585449, 0.4954400062561035, 1.213352084159851, 0.3328361511230469, 0.7684919834136963),
        *(-0.16869807243347168, -0.39427995681762695, -0.5061781406402588, 0.297637939453125),
        *(-0.34050607681274414, 2.1506261825561523, -1.1137261390686035, -0.06285214424133301),
        *(-0.10733795166015625, -0.23014187812805176, 2.13997220993042, -1.2056820392608643),
        *(-0.10120201110839844, 1.0600361824035645, 0.2039799690246582, -0.467911958694458),
        *(0.06600403785705566, 0.47089600563049316, 0.010400056838989258, 0.011199951171875),
    ),
}

SENSOR_MAP: dict[str, Any] = msgpack.unpackb(SENSORS)


def frame(**fields: Any) -> SensorFrame:
    zero: dict[str, Any] = {name: (0.0,) * 25 for name in ("position", "stiffness", "current", "temperature")}
    zero |= {"fsr": (0.0,) * 8, "accelerometer": (0.0,) * 3, "gyroscope": (0.0,) * 3, "angle": (0.0, 0.0)}
    zero |= {"touch": (0.0,) * 14, "battery": (0.0,) * 4, "sonar": (0.0, 0.0)}
    return SensorFrame(**({"seq": 0, "time": 0.0} | zero | fields))


def test_the_captured_packet_survives_the_contract_byte_for_byte() -> None:
    """Only what the contract does not carry is put back: `RobotConfig` and `Status`."""
    (values,) = MapStream(codec.SENSORS).feed(SENSORS)
    carried = lola_values(sensor_frame(values, seq=0))
    back = {"RobotConfig": astuple(identity_of(values)), **{k: list(v) for k, v in carried.items()}}
    assert pack_map(back | {"Status": [0] * 25}) == SENSORS
    assert (len(SENSORS), list(values)) == (codec.SENSOR_BYTES, list(codec.SENSORS))


def test_a_full_actuator_map_comes_out_byte_for_byte() -> None:
    (values,) = MapStream(codec.ACTUATORS).feed(ACTUATORS)
    assert {key: len(array) for key, array in values.items()} == codec.ACTUATORS  # type: ignore[arg-type]
    assert pack_map(values) == ACTUATORS  # type: ignore[arg-type]
    assert len(ACTUATORS) == 786


def test_a_command_is_the_276_bytes_that_a_team_s_packer_writes() -> None:
    position, stiffness = [0.1 * i for i in range(25)], [1.0, -1.0, *[0.6] * 23]
    packer = msgpack.Packer(use_single_float=True, use_bin_type=False)
    expected = packer.pack({"Position": position, "Stiffness": stiffness})
    assert actuator_map(position, stiffness) == expected
    assert len(expected) == 276


def test_keys_stay_where_they_are_whatever_the_values() -> None:
    extremes = [
        frame(),
        frame(position=(-3.0,) * 25, gyroscope=(9.0, -9.0, 1e-9), sonar=(2.55, 0.25), angle=(-1.0, 1.0)),
        frame(temperature=(101.0,) * 25, battery=(1.0, -30.0, -32552.0, 36.0), fsr=(25.0,) * 8),
        frame(current=(1e300,) * 25, touch=(1.0,) * 14),  # more than a float 32 holds
    ]
    packets = [sensor_packet(f, Identity()) for f in extremes] + [SENSORS]
    places = [[p.index(bytes([0xA0 | len(key)]) + key.encode()) for key in codec.SENSORS] for p in packets]
    assert all(len(p) == 896 for p in packets)
    assert all(place == places[-1] for place in places)
    assert places[0] == sorted(places[0])


def test_signs_units_and_orders_of_a_robot_that_leans() -> None:
    """Nose down by 20 degrees: protocol.md has the contract's values, LoLA's accelerometer shows gravity."""
    leaning = frame(
        accelerometer=(-3.3552, 0.0, 9.2184),
        gyroscope=(0.1, 0.2, 0.3),
        angle=(0.0, 0.349),
        fsr=(9.81, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 19.62),
        battery=(0.5, -1.25, 128.0, 30.0),
    )
    values = msgpack.unpackb(sensor_packet(leaning, Identity()))
    step = ACCELEROMETER_STEP
    assert values["Accelerometer"] == pytest.approx([3.3552, 0.0, -9.2184], abs=step / 2)
    assert values["Gyroscope"] == pytest.approx([0.1, 0.2, 0.3], abs=GYROSCOPE_STEP / 2)
    assert values["Angles"] == pytest.approx([0.0, 0.349])
    assert values["FSR"] == pytest.approx([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0])
    assert values["Battery"] == pytest.approx([0.5, 128.0, -1.25, 30.0])  # as captured: the status second


def test_the_captured_robot_s_accelerometer_agrees_with_its_angles_in_the_contract() -> None:
    """At rest, specific force of a torso that is pitched by p and rolled by r about it: (-sin p, ...) g."""
    (values,) = MapStream(codec.SENSORS).feed(SENSORS)
    got = sensor_frame(values, seq=7)
    roll, pitch = got.angle
    expected = (-math.sin(pitch), math.cos(pitch) * math.sin(roll), math.cos(pitch) * math.cos(roll))
    assert got.accelerometer == pytest.approx([9.81 * e for e in expected], abs=0.5)
    assert got.time == pytest.approx(7 * 0.012)
    assert got.battery == pytest.approx((0.99, 0.016, -32552.0, 3.6), rel=1e-6)
    assert int(got.battery[2]) & 0x80  # it was being charged


def test_values_on_a_real_robot_s_grid_stay_as_they_are() -> None:
    # the first packet was printed with six digits, the second has float 32 arithmetic in its last bits
    for packet in (SENSOR_MAP, SECOND):
        assert quantized("Position", packet["Position"]) == pytest.approx(packet["Position"], abs=6e-6)
        for key, tolerance in (("Gyroscope", 2e-8), ("Accelerometer", 6e-6)):
            assert list(quantized(key, packet[key])) == pytest.approx(packet[key], abs=tolerance)


def test_joint_angles_come_in_steps_of_the_encoder() -> None:
    packets = [
        msgpack.unpackb(sensor_packet(frame(position=(a,) * 25), Identity())) for a in (0.1, 0.10149, 0.7)
    ]
    positions = [p["Position"][:23] for p in packets]
    for joint in range(23):
        steps = [(p[joint] - RESIDUE_SIGNS[joint] * 4.2e-5) / 0.001534 for p in positions]
        assert steps == pytest.approx([round(s) for s in steps], abs=1e-3)
    assert all(
        p == pytest.approx([a] * 23, abs=0.0008) for p, a in zip(positions, (0.1, 0.10149, 0.7), strict=True)
    )


def test_motor_temperature_becomes_status() -> None:
    """High from 76 degrees Celsius on, and until it is below 70."""
    heat, cold = HeatStatus(), [25.0] * 21
    status = heat.update((75.9, 76.0, 93.0, 104.0, *cold))
    assert status == [0, 1, 2, 3, *[0] * 21]
    assert heat.update((75.9, 70.0, 69.9, 75.0, *cold)) == [0, 1, 0, 1, *[0] * 21]
    assert heat.update((75.9, 69.9, 75.9, 69.0, *cold)) == [0] * 25
    assert msgpack.unpackb(sensor_packet(frame(), Identity(), status))["Status"] == status


def test_a_packet_names_the_robot() -> None:
    identity = Identity("P0000073A03S83I00011", "6.0.0", "P0000074A03S84F00006", "6.0.0")
    assert msgpack.unpackb(sensor_packet(frame(), identity))["RobotConfig"] == SENSOR_MAP["RobotConfig"]
    with pytest.raises(ConfigurationError, match="Body id 'NAO' must have 20"):
        Identity(body_id="NAO").check()


@pytest.mark.parametrize(
    ("change", "field", "unread"),
    [
        ({"Position": [0.0] * 24}, "position", range(25)),
        ({"FSR": 3.0}, "fsr", range(8)),
        ({"Angles": [0.0, float("nan")]}, "angle", [1]),
        ({"Touch": ["x", *[0.0] * 13]}, "touch", [0]),
        ({"Sonar": None}, "sonar", range(2)),
    ],
)
def test_what_a_packet_does_not_tell_is_nan_and_all_else_is_read(
    change: dict[str, Any], field: str, unread: Sequence[int]
) -> None:
    values = {key: value for key, value in (SENSOR_MAP | change).items() if value is not None}
    whole, read = sensor_frame(SENSOR_MAP, seq=0), sensor_frame(values, seq=0)
    for name in ELEMENTS:
        bad = [i for i, value in enumerate(getattr(read, name)) if math.isnan(value)]
        assert bad == (list(unread) if name == field else []), name
        if name != field:
            assert getattr(read, name) == getattr(whole, name)
