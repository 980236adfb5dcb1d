"""A controller from docs/protocol.md alone: Zenoh, X25519, a msgpack of its own, nothing of this project.

    python protocol_controller.py ENDPOINT ROBOT_ID CYCLES

Holds the robot in its stand and swings its head for that many cycles, then prints one JSON object.
"""

from __future__ import annotations

import hashlib
import hmac
import json
import math
import queue
import struct
import sys
import time
from typing import Any

import zenoh
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey, X25519PublicKey


def pack(value: Any) -> bytes:
    """Msgpack of None, bool, int, float (64 bit), str, list and dict."""
    if value is None:
        return b"\xc0"
    if isinstance(value, bool):
        return b"\xc3" if value else b"\xc2"
    if isinstance(value, int):
        if 0 <= value < 128:
            return struct.pack(">B", value)
        if -32 <= value < 0:
            return struct.pack(">b", value)
        for code, form, low, high in (
            (0xCC, "B", 0, 2**8),
            (0xCD, "H", 0, 2**16),
            (0xCE, "I", 0, 2**32),
            (0xCF, "Q", 0, 2**64),
            (0xD0, "b", -(2**7), 0),
            (0xD1, "h", -(2**15), 0),
            (0xD2, "i", -(2**31), 0),
            (0xD3, "q", -(2**63), 0),
        ):
            if low <= value < high:
                return struct.pack(f">B{form}", code, value)
    if isinstance(value, float):
        return struct.pack(">Bd", 0xCB, value)
    if isinstance(value, str):
        text = value.encode()
        return _head(len(text), 0xA0, 32, 0xD9) + text
    if isinstance(value, list):
        return _head(len(value), 0x90, 16, 0xDB) + b"".join(map(pack, value))
    if isinstance(value, dict):
        return _head(len(value), 0x80, 16, 0xDD) + b"".join(pack(k) + pack(v) for k, v in value.items())
    raise TypeError(value)


def _head(count: int, small: int, below: int, code: int) -> bytes:
    if count < below:
        return struct.pack(">B", small | count)
    if code == 0xD9:
        return struct.pack(">BB", code, count) if count < 256 else struct.pack(">BH", 0xDA, count)
    return struct.pack(">BH", code + 1 if code == 0xDB else 0xDE, count)


NUMBERS = dict(zip(range(0xCA, 0xD4), "fdBHIQbhiq", strict=True))
LENGTHS = {0xD9: "B", 0xDA: "H", 0xDB: "I", 0xDC: "H", 0xDD: "I", 0xDE: "H", 0xDF: "I"}


def unpack(data: bytes) -> Any:
    """The value in msgpack."""
    return _take(data, 0)[0]


def _take(data: bytes, at: int) -> tuple[Any, int]:
    code, at = data[at], at + 1
    if code < 0x80 or code >= 0xE0:
        return (code if code < 0x80 else code - 256), at
    if code in (0xC0, 0xC2, 0xC3):
        return {0xC0: None, 0xC2: False, 0xC3: True}[code], at
    if code in NUMBERS:
        form = ">" + NUMBERS[code]
        return struct.unpack_from(form, data, at)[0], at + struct.calcsize(form)
    if code < 0xC0:
        kind, count = (code >> 4, code & 0x0F) if code < 0xA0 else (0xA, code & 0x1F)
    else:
        form = ">" + LENGTHS[code]
        (count,) = struct.unpack_from(form, data, at)
        at += struct.calcsize(form)
        kind = 0xA if code <= 0xDB else 0x9 if code <= 0xDD else 0x8
    if kind == 0xA:
        return data[at : at + count].decode(), at + count
    items = []
    for _ in range(count if kind == 0x9 else 2 * count):
        item, at = _take(data, at)
        items.append(item)
    return (items if kind == 0x9 else dict(zip(items[::2], items[1::2], strict=True))), at


def connect(endpoint: str) -> zenoh.Session:
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)


def shared_secret(private: X25519PrivateKey, other: str) -> bytes:
    """Secret shared with the owner of a public key in hexadecimal."""
    return hashlib.sha256(private.exchange(X25519PublicKey.from_public_bytes(bytes.fromhex(other)))).digest()


class Sealer:
    """Attachments of sealed messages."""

    def __init__(self, secret: bytes) -> None:
        self.secret, self.count = secret, 0

    def __call__(self, key: str, payload: bytes) -> bytes:
        self.count += 1
        count = struct.pack(">Q", self.count)
        return count + hmac.new(self.secret, count + key.encode() + payload, hashlib.sha256).digest()


def ask(session: zenoh.Session, key: str, payload: bytes = b"", attachment: bytes | None = None) -> Any:
    for reply in session.get(key, payload=payload, attachment=attachment, timeout=60.0):
        if reply.ok is not None:
            return unpack(reply.ok.payload.to_bytes())
        raise SystemExit(f"{key}: {reply.err.payload.to_bytes().decode()}")
    raise SystemExit(f"{key}: no answer")


def main(endpoint: str, robot: str, cycles: int) -> None:
    session = connect(endpoint)
    try:
        print(json.dumps(swing(session, f"nao/{robot}", cycles)))
    finally:
        session.close()


def swing(session: zenoh.Session, root: str, cycles: int) -> dict[str, Any]:
    frames: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    sensors = session.declare_subscriber(
        f"{root}/sensors", lambda sample: frames.put(sample.payload.to_bytes())
    )
    actuators = session.declare_publisher(f"{root}/actuators")
    info = ask(session, f"{root}/info")
    private = X25519PrivateKey.generate()
    request = {"version": 3, "controller": "stranger", "key": private.public_key().public_bytes_raw().hex()}
    token = session.liveliness().declare_token(f"{root}/alive/controller/stranger.{request['key']}")
    robot = ask(session, f"{root}/lease", pack(request | {"op": "status"}))["key"]
    seal = Sealer(shared_secret(private, robot))

    def sealed_request(op: str) -> Any:
        payload = pack(request | {"op": op})
        return ask(session, f"{root}/lease", payload, seal(f"{root}/lease", payload))

    lease = sealed_request("acquire")
    if not lease["granted"]:
        raise SystemExit(lease["message"])

    first: dict[str, Any] | None = None
    seen, heads, late = -1, [], 0
    for _ in range(100 * cycles):
        if first is not None and seen >= first["seq"] + cycles:
            break
        payload = frames.get(timeout=60.0)
        for _ in range(frames.qsize() if info["mode"] == "real-time" else 0):
            payload = frames.get()
        frame = unpack(payload)
        if first is None:
            first = frame
        # The very first answer of a boot may be lost; a robot in lockstep then sends its frame again.
        seen = frame["seq"]
        late += frame["command"] >= 0 and frame["command"] != seen - 1
        heads.append(frame["position"][0])
        wanted = list(info["stand"])
        wanted[0] = 0.3 * math.sin(2.0 * math.pi * (seen - first["seq"]) * info["cycle"])
        answer = pack(
            {
                "version": 3,
                "reply_to": seen,
                "lease": lease["lease"],
                "position": wanted,
                "stiffness": [1.0] * 25,
                "wall": time.time_ns(),
            }
        )
        actuators.put(answer, attachment=seal(f"{root}/actuators", answer))
    sealed_request("release")
    token.undeclare()
    sensors.undeclare()
    return {
        "mode": info["mode"],
        "absent": info["absent"],
        "frames": len(heads),
        "late": late,
        "head": [min(heads), max(heads)],
        "accelerometer": first["accelerometer"],
        "missed": frame["missed"] - first["missed"],
    }


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
