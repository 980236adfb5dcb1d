"""Log files as the logger of B-Human writes them, from its published format (`LogPlayer`, `TypeInfo`)."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from pathlib import Path

import pyarrow

JOINTS = (
    *(
        "headYaw",
        "headPitch",
        "lShoulderPitch",
        "lShoulderRoll",
        "lElbowYaw",
        "lElbowRoll",
        "lWristYaw",
        "lHand",
    ),
    *("rShoulderPitch", "rShoulderRoll", "rElbowYaw", "rElbowRoll", "rWristYaw", "rHand", "lHipYawPitch"),
    *(
        "lHipRoll",
        "lHipPitch",
        "lKneePitch",
        "lAnklePitch",
        "lAnkleRoll",
        "rHipYawPitch",
        "rHipRoll",
        "rHipPitch",
    ),
    *("rKneePitch", "rAnklePitch", "rAnkleRoll"),
)
"""Order of B-Human's enumeration."""
IDS = ("undefined", "idFrameBegin", "idFrameFinished", "idJointRequest", "idJointSensorData", "idFrameInfo")
IDS = (*IDS, "idInertialSensorData", "idFsrSensorData", "idCameraImage")
PRIMITIVES = ("bool", "char", "float", "int", "unsigned int", "short", "unsigned char", "std::string", "Angle")
PER_JOINT = {
    f"EnumIndexedArray<{of},Joints::Joint,Joints::Joint_Info>": [(name, of) for name in JOINTS]
    for of in ("Angle", "short", "unsigned char", "int", "JointSensorData::TemperatureStatus")
}
ANGLES, SHORTS, BYTES, INTS, STATUS = PER_JOINT
VECTOR = "Eigen::Matrix<{0},{1},1,0,{1},1>"
NEW = {
    **PER_JOINT,
    "FsrCells": [(name, "float") for name in ("fl", "fr", "bl", "br")],
    "FsrFeet": [("left", "FsrCells"), ("right", "FsrCells")],
    "FrameInfo": [("time", "unsigned int")],
    "FsrSensorData": [("pressures", "FsrFeet"), ("totals", "float[2]")],
    "InertialSensorData": [
        ("gyro", VECTOR.format("Angle", 3)),
        ("acc", VECTOR.format("float", 3)),
        ("angle", VECTOR.format("Angle", 3)),
    ],
    **{
        VECTOR.format(kind, 3): [(axis, kind) for axis in "xyz"] for kind in ("Angle", "float")
    },
    "JointRequest": [("angles", ANGLES), ("timestamp", "unsigned int"), ("stiffnessData", "StiffnessData")],
    "StiffnessData": [("stiffnesses", INTS)],
    "JointSensorData": [
        *(("angles", ANGLES), ("timestamp", "unsigned int"), ("currents", SHORTS), ("temperatures", BYTES)),
        ("status", STATUS),
    ],
}  # fmt: skip
"""Types of a release of 2019 and later."""
OLD = {
    "FrameInfo": [("time", "unsigned int"), ("cycleTime", "float")],
    "JointRequest": [
        *(("angles", "Angle (*) [26ul]"), ("timestamp", "unsigned int")),
        ("stiffnessData", "StiffnessData"),
    ],
    "StiffnessData": [("stiffnesses", "std::array<int, 26ul>")],
    "JointSensorData": [("angles", "Angle (*) [26ul]"), ("timestamp", "unsigned int")],
}
"""The same of one of 2016, as the compiler names them."""
ENUMS = {
    "MessageID": IDS,
    "Joints::Joint": JOINTS,
    "FsrSensors::FsrSensor": ("fl", "fr", "bl", "br"),
    "JointSensorData::TemperatureStatus": ("regular", "hot", "veryHot", "criticallyHot"),
}


def text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def message(name: str, payload: bytes) -> bytes:
    """A byte for the id, three for the size."""
    return struct.pack("<I", IDS.index(name) | len(payload) << 8) + payload


def frame(messages: Mapping[str, bytes], thread: str = "Motion") -> bytes:
    inner = b"".join(message(name, payload) for name, payload in messages.items())
    return message("idFrameBegin", text(thread)) + inner + message("idFrameFinished", text(thread))


def specification(classes: Mapping[str, Sequence[tuple[str, str]]], unified: int) -> bytes:
    out = struct.pack("<I", len(PRIMITIVES) | unified) + b"".join(map(text, PRIMITIVES))
    out += struct.pack("<I", len(classes))
    for name, attributes in classes.items():
        out += text(name) + struct.pack("<I", len(attributes))
        out += b"".join(text(attribute) + text(kind) for attribute, kind in attributes)
    out += struct.pack("<I", len(ENUMS))
    for name, constants in ENUMS.items():
        out += text(name) + struct.pack("<I", len(constants)) + b"".join(map(text, constants))
    return out


def write_log(path: Path, frames: Sequence[bytes], *, old: bool = False, closed: bool = True) -> Path:
    """A log of a new release, uncompressed, or of an old one: no settings, compiler's names, snappy.

    Args:
        path: Of the file.
        frames: Of `frame`.
        old: As an old release.
        closed: The player has written its index behind the messages; else they are cut off.
    """
    settings = (
        struct.pack("<I", 1) + text("Head") + text("Body") + struct.pack("<i", 3) + text("Here") + text("x")
    )
    out = b"" if old else b"\x04" + settings
    out += b"\x02" + struct.pack("B", len(IDS)) + b"".join(map(text, IDS))
    out += b"\x03" + specification(OLD if old else NEW, 0 if old else 0x8000_0000)
    queue = b"".join(frames)
    if old:
        out += b"\x01"
        for each in frames:
            packed = bytes(
                pyarrow.compress(struct.pack("<II", len(each), 1) + each, codec="snappy", asbytes=True)
            )
            out += struct.pack("<I", len(packed)) + packed
    elif closed:
        out += b"\x00" + struct.pack("<II", len(queue), 0) + queue + b"\x05\x02" + bytes(range(256))
    else:
        out += b"\x00" + b"\xff" * 8 + queue[:-3]
    path.write_bytes(out)
    return path
