"""Values of the qi protocol against messages that libqi 3.1.5 sent."""

from __future__ import annotations

import random
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridge.adapters.naoqi.qi_values import QiError, decode, encode

CAPABILITIES = (
    b"\x03\0\0\0" + b"\x12\0\0\0ClientServerSocket\x01\0\0\0b\x01" + b"\x0f\0\0\0MetaObjectCache\x01\0\0\0b\0"
    b"\x0f\0\0\0__qi_auth_state\x01\0\0\0I\x03\0\0\0"
)
"""Entries of libqi's answer to the call that authenticates."""
SERVICE = b"\x01\0\0\0S\x02\0\0\0\x03\0\0\0abc\x07\x03\0\0\x01\0\0\0\x15\0\0\0tcp://127.0.0.1:19771\x01\0\0\x000\0\0\0\0"
INFO = "(sIsI[s]ss)<ServiceInfo,name,serviceId,machineId,processId,endpoints,sessionId,objectUid>"


def test_messages_of_libqi_are_read_and_written() -> None:
    told = {"ClientServerSocket": True, "MetaObjectCache": False, "__qi_auth_state": 3}
    assert decode("{sm}", CAPABILITIES) == told
    info = ["S", 2, "abc", 775, ["tcp://127.0.0.1:19771"], "0", ""]
    assert decode(INFO, SERVICE) == info
    assert encode(INFO, info) == SERVICE


def test_a_picture_is_a_raw_value_and_its_angles_have_32_bits() -> None:
    """naoqi_driver2 drops a picture whose buffer is not raw, or whose angles are no `float`."""
    sent = encode("m", [320, b"\xff\x00", 0.5, None, "a", True])
    parts = [
        b"i" + struct.pack("<i", 320),
        b"r\2\0\0\0\xff\0",
        b"f" + struct.pack("<f", 0.5),
        b"v",
        b"s\1\0\0\0a",
        b"b\1",
    ]
    assert sent == b"\3\0\0\0[m]\6\0\0\0" + b"".join(b"\1\0\0\0" + part for part in parts)


plain = st.none() | st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.text(max_size=9) | st.floats(width=32)
values = st.recursive(
    plain, lambda v: st.lists(v, max_size=4) | st.dictionaries(st.text(max_size=3), v, max_size=3)
)


@given(values)
def test_a_value_comes_back(value: Any) -> None:
    assert repr(decode("m", encode("m", value))) == repr(value)


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        b"\1\0\0\0s\xff\xff\xff\xffa",
        b"\3\0\0\0[v]\xff\xff\xff\xff",
        b"\1\0\0\0z",
        b"\1\0\0\0ii\0\0\0i",
        b"\1\0\0\0m" * 1000,
        b"\x40\0\0\0" + b"[" * 64,
    ],
)
def test_bytes_that_are_no_value_are_refused(payload: bytes) -> None:
    with pytest.raises(QiError):
        decode("m", payload)


def test_random_bytes_are_refused_or_read() -> None:
    draw = random.Random(45)
    begins = [b"\3\0\0\0[m]", b"\4\0\0\0{sm}", b"\1\0\0\0s", b"\5\0\0\0(isf)", b""]
    refused = 0
    for _ in range(20_000):
        try:
            decode("m", draw.choice(begins) + draw.randbytes(draw.randrange(40)))
        except QiError:
            refused += 1
    assert refused > 15_000


@pytest.mark.parametrize(("signature", "value"), [("m", object()), ("m", 1 << 70), ("(si)", ["a"]), ("i", "a")])
def test_a_value_without_such_a_type_is_refused(signature: str, value: object) -> None:
    with pytest.raises(QiError):
        encode(signature, value)
