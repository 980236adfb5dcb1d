"""Recordings: byte identity, the plain MCAP reader as witness, cut files, and the hash over frames."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import msgspec
import pytest
from mcap.reader import make_reader

from bridge.body.joints import N_JOINTS
from bridge.errors import ConfigurationError
from bridge.messages import ActuatorFrame, Contact, Notice, SensorFrame, TruthFrame, WalkTelemetry
from bridge.messages.topics import Message
from bridge.recording.canonical import FrameHash
from bridge.recording.playback import read_recording, recorded_config
from bridge.recording.recorder import Recorder
from nao_hil.analysis.inspection import inspect
from nao_hil.runs.run import load
from tests.frames import standing_frame, truth_frame, walk_telemetry

CONFIG = {"robot": "nao-v3", "seed": 7, "parameters": {"step": 0.04}}


def sensor(k: int, wall: int = 0) -> SensorFrame:
    return standing_frame(
        k,
        position=tuple(0.1 * j + 1e-3 * k for j in range(N_JOINTS)),
        gyroscope=(0.0, 1e-17 * k, -0.0),
        angle=(0.01, -0.02),
        command=k - 1,
        wall=wall,
    )


def actuator(k: int, wall: int = 0, lease: int = 0) -> ActuatorFrame:
    position = tuple(0.1 * j for j in range(N_JOINTS))
    return ActuatorFrame(reply_to=k, position=position, stiffness=(1.0,) * N_JOINTS, wall=wall, lease=lease)


def truth(k: int) -> TruthFrame:
    left = Contact(force=(0.0, 0.0, 26.0), cop=(0.01, 0.0))
    place = {
        "torso_position": (0.001 * k, 0.0, 0.31),
        "torso_velocity": (0.1, 0.0, 0.0),
        "com": (0.0, 0.0, 0.25),
    }
    return truth_frame(k, zmp=(0.01, 0.0) if k % 2 else None, left=left, **place)


def telemetry(k: int, tick: float = 0.0) -> WalkTelemetry:
    return walk_telemetry(k, step=1, steps=10, tick=tick)


def run(cycles: int, noise: int = 0) -> list[Message]:
    """What a run writes; `noise` changes nothing but wall-clock fields and the lease."""
    messages: list[Message] = []
    for k in range(cycles):
        messages += [sensor(k, wall=noise * k), truth(k), telemetry(k, tick=noise * 1e-5)]
        messages.append(actuator(k, wall=noise * k, lease=noise))
        if k % 50 == 3:
            messages.append(Notice(seq=k, level="warning", code="clipped", text="LKneePitch was clipped"))
    return messages


def write(recorder: Recorder, messages: list[Message]) -> None:
    for message in messages:
        recorder.write(message)


def record(path: Path, messages: list[Message]) -> Path:
    with Recorder(path, CONFIG) as recorder:
        write(recorder, messages)
    return path


def digest(messages: list[Message]) -> str:
    frames = FrameHash()
    for message in messages:
        if isinstance(message, (SensorFrame, ActuatorFrame)):
            frames.add(message)
    return frames.hexdigest()


def test_two_recordings_of_the_same_run_are_the_same_bytes(tmp_path: Path) -> None:
    one = record(tmp_path / "one.mcap", run(300))
    two = record(tmp_path / "another-name.mcap", run(300, noise=12345))
    assert one.read_bytes() == two.read_bytes()


def test_what_was_written_comes_back_in_order(tmp_path: Path) -> None:
    messages = run(120)
    path = record(tmp_path / "run.mcap", messages)
    assert [r.message for r in read_recording(path)] == messages
    assert recorded_config(path) == CONFIG


def test_the_plain_mcap_reader_finds_topics_schemas_and_robot_time(tmp_path: Path) -> None:
    path = record(tmp_path / "run.mcap", run(250))
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        channels = {c.topic: c for c in summary.channels.values()}
        counts = {t: summary.statistics.channel_message_counts[c.id] for t, c in channels.items()}
        assert counts == {
            "sensors": 250,
            "actuators": 250,
            "world/truth": 250,
            "walk/telemetry": 250,
            "notices": 5,
        }
        assert all(c.message_encoding == "json" for c in channels.values())
        assert all(s.encoding == "jsonschema" for s in summary.schemas.values())
        for schema, _, message in reader.iter_messages():
            assert schema is not None
            data = json.loads(message.data)
            assert list(json.loads(schema.data)["properties"]) == list(data)
            assert not {"wall", "tick", "lease"} & set(data)
            assert message.log_time == message.publish_time
            assert message.log_time == data.get("seq", data.get("reply_to")) * 10_000_000
        assert next(iter(reader.iter_metadata())).metadata == {
            "config": json.dumps(CONFIG, separators=(",", ":"), sort_keys=True)
        }


def test_schemas_are_plain_objects_without_references_or_unions(tmp_path: Path) -> None:
    path = record(tmp_path / "run.mcap", run(1))
    plain = {"object", "array", "number", "integer", "string", "boolean"}

    def check(schema: dict[str, Any]) -> None:
        assert schema["type"] in plain
        assert not {"$ref", "anyOf", "oneOf", "prefixItems", "$defs"} & set(schema)
        for inner in schema.get("properties", {}).values():
            check(inner)
        if "items" in schema:
            check(schema["items"])

    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    schemas = {s.name: json.loads(s.data) for s in summary.schemas.values()}
    for schema in schemas.values():
        assert schema["type"] == "object"
        check(schema)
    sensors = schemas["nao.SensorFrame"]["properties"]
    numbers = {"type": "array", "items": {"type": "number"}}
    assert sensors["position"] == numbers | {"minItems": 25, "maxItems": 25}
    assert sensors["gyroscope"] == numbers | {"minItems": 3, "maxItems": 3}
    assert sensors["seq"] == {"type": "integer"}


def test_a_file_cut_anywhere_reads_to_the_last_whole_chunk(tmp_path: Path) -> None:
    messages = run(600)
    whole = record(tmp_path / "run.mcap", messages).read_bytes()
    cut = tmp_path / "cut.mcap"
    lengths = []
    for size in [8, 9, 20, *range(50, len(whole), len(whole) // 31), len(whole) - 1]:
        cut.write_bytes(whole[:size])
        got = [r.message for r in read_recording(cut)]
        assert got == messages[: len(got)]
        lengths.append(len(got))
    assert lengths == sorted(lengths)
    assert lengths[0] == 0
    assert lengths[-1] == len(messages)
    assert len(set(lengths)) > 5  # cuts inside the data lose the tail, not everything


def test_an_unclosed_recording_is_on_disk_up_to_the_last_second(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recorder = Recorder(path, CONFIG)
    try:
        for k in range(500):
            recorder.write(sensor(k))
            recorder.write(actuator(k))
            if k >= 100 and k % 9 == 0:
                *_, last = read_recording(path)
                assert last.time > k * 0.01 - 1.0
    finally:
        recorder.close()


def test_the_hash_is_that_of_the_recorded_lines(tmp_path: Path) -> None:
    path = record(tmp_path / "run.mcap", run(60))
    by_hand = hashlib.sha256()
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
            if channel.topic in ("sensors", "actuators"):
                by_hand.update(message.data + b"\n")
    assert digest(run(60)) == by_hand.hexdigest() == inspect(path).frames_sha256


@pytest.mark.parametrize("kind", [SensorFrame, ActuatorFrame])
def test_any_change_of_a_frame_changes_the_hash(kind: type[SensorFrame | ActuatorFrame]) -> None:
    frame = sensor(5) if kind is SensorFrame else actuator(5)
    plain, seen = digest([frame]), set()
    for name in kind.__struct_fields__:
        value = getattr(frame, name)
        variants = []
        if isinstance(value, tuple):
            for i in range(len(value)):
                variants.append((*value[:i], value[i] + 1e-12, *value[i + 1 :]))
        else:
            variants.append(value + 1)
        for variant in variants:
            changed = digest([msgspec.structs.replace(frame, **{name: variant})])
            assert (changed == plain) == (name in ("wall", "lease"))
            seen.add(changed)
    expected = {SensorFrame: 5 + 4 * 25 + 8 + 3 + 3 + 2 + 14 + 4 + 2, ActuatorFrame: 2 + 2 * 25}
    assert len(seen - {plain}) == expected[kind]


def test_missing_and_foreign_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"none\.mcap: cannot be read"):
        read_recording(tmp_path / "none.mcap")
    for content in (b"", b"\x89MCA", b"PK\x03\x04 something else"):
        (tmp_path / "other.mcap").write_bytes(content)
        with pytest.raises(ConfigurationError, match=r"other\.mcap: is not an MCAP file"):
            read_recording(tmp_path / "other.mcap")
    with pytest.raises(ConfigurationError, match="cannot be written"):
        Recorder(tmp_path / "no" / "such" / "folder.mcap", CONFIG)


@pytest.mark.parametrize("begin", [9, 20, 100, -400, -100])
def test_a_damaged_recording_is_not_called_whole(begin: int, tmp_path: Path) -> None:
    path = record(tmp_path / "run.mcap", run(60))
    data = bytearray(path.read_bytes())
    for i in range(begin % len(data), begin % len(data) + 40):
        data[i] ^= 0x5A
    path.write_bytes(data)
    for read in (inspect, lambda path: load(path)["sensors"]):
        with pytest.raises(ConfigurationError, match=r"run\.mcap: is damaged"):
            read(path)


@pytest.mark.parametrize("rest", [None, b"x" * 500])
def test_what_is_joined_to_a_recording_is_told_and_not_read(rest: bytes | None, tmp_path: Path) -> None:
    path = record(tmp_path / "run.mcap", run(60))
    alone, data = inspect(path), path.read_bytes()
    assert (alone.complete, alone.after) == (True, 0)
    path.write_bytes(data + (rest or data))
    assert msgspec.structs.replace(inspect(path), after=0) == alone
    assert inspect(path).after == len(rest or data)


def test_a_disk_without_room_leaves_no_half_begun_recording(tmp_path: Path) -> None:
    (tmp_path / "full.mcap").symlink_to("/dev/full")
    with pytest.raises(ConfigurationError, match=r"cannot be begun there .*; give a place with room"):
        Recorder(tmp_path / "full.mcap", CONFIG)
    assert Path("/dev/full").exists()
