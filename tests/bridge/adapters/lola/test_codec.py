"""Maps of LoLA in a stream of bytes, and the setpoints in them."""

from __future__ import annotations

import itertools
import math
import random
from pathlib import Path
from typing import Any

import msgpack
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bridge.adapters.lola import codec
from bridge.adapters.lola.client import Setpoints
from bridge.adapters.lola.codec import MAX_MESSAGE, MapStream

ACTUATORS = (Path(__file__).parent / "data" / "actuators.msgpack").read_bytes()


def packed(**values: Any) -> bytes:
    return bytes(msgpack.packb(values, use_single_float=True, use_bin_type=False))


MARK = packed(Stiffness=[0.25] * 25)


def is_mark(value: dict[str, Any]) -> bool:
    return value == msgpack.unpackb(MARK)


@given(st.lists(st.integers(0, 3 * len(ACTUATORS)), max_size=40))
@settings(max_examples=60)
def test_maps_come_out_however_the_stream_is_cut(cuts: list[int]) -> None:
    stream, data, found = MapStream(codec.ACTUATORS), ACTUATORS * 3, []
    edges = [0, *sorted(cuts), len(data)]
    for begin, end in itertools.pairwise(edges):
        found += stream.feed(data[begin:end])
    assert found == [msgpack.unpackb(ACTUATORS)] * 3
    assert stream.dropped == 0


@pytest.mark.parametrize(
    "values",
    [
        {"Sonar": [True, False]},
        {"Stiffness": [0.0] * 25, "Position": [1.0] * 25},
        {"Chest": [1, 0, 0], "Unheard": "of", "Other": [1, None, -5, 70000, "x"]},
        {},
        {"Position": [2**40] * 25, "x": -(2**40), "y": -100, "z": 300},
    ],
)
def test_any_keys_and_numbers_in_any_order(values: dict[str, Any]) -> None:
    assert MapStream(codec.ACTUATORS).feed(packed(**values)) == [values]


@pytest.mark.parametrize(
    "garbage",
    [
        b"GET / HTTP/1.1\r\n\r\n",
        b"\x00" * 896,
        b"\xff" * 50,
        b"\xdf\xff\xff\xff\xff",  # a map of four billion elements
        b"\x81\xa8Position\xdd\xff\xff\xff\xff",
        b"\x81\xa8Position\xdc\x00\x19" + b"\xca\x00\x00\x00\x00" * 10,  # 10 of 25 elements
        b"\x81\xa3abc\xda\x00\xff",  # a text that would swallow what follows
        b"\x81\xa4deep\x91\x91\x91\xc0",
        msgpack.packb({b"Position": [0.0] * 25}, use_bin_type=True),  # a newer msgpack's raw bytes
        b"\x8b" * 200,
        ACTUATORS[:400],
        ACTUATORS[400:],
        b"\xc1",
    ],
)
def test_the_map_behind_garbage_is_found(garbage: bytes) -> None:
    stream = MapStream(codec.ACTUATORS)
    stream.feed(garbage)
    found = stream.feed(MARK)
    assert found[-1:] and is_mark(found[-1])
    assert stream.dropped == len(garbage)
    assert stream.feed(MARK + MARK) == [msgpack.unpackb(MARK)] * 2


def test_a_map_without_end_is_given_up() -> None:
    stream = MapStream(codec.ACTUATORS)
    for _ in range(MAX_MESSAGE // 8):
        stream.feed(b"\xa3abc\xa3xyz")
    stream.feed(b"\x8f" + b"\xa3abc\x9f" + b"\xa1x" * 10)
    assert any(is_mark(m) for _ in range(3) for m in stream.feed(MARK))
    assert stream.dropped > MAX_MESSAGE // 2


def _damaged(message: bytes, random_: random.Random) -> bytes:
    """A message with some bytes changed, lost, doubled or put in."""
    data = bytearray(message)
    for _ in range(random_.randint(1, 4)):
        at = random_.randrange(len(data)) if data else 0
        kind = random_.randrange(5)
        if kind == 0 and data:
            data[at] = random_.randrange(256)
        elif kind == 1 and data:
            data[at] ^= 1 << random_.randrange(8)
        elif kind == 2:
            del data[at : at + random_.randint(1, 30)]
        elif kind == 3:
            data[at:at] = random_.randbytes(random_.randint(1, 30))
        else:
            data[at:at] = data[at : at + random_.randint(1, 60)]
    return bytes(data)


def test_100_000_damaged_replies_never_desynchronise_the_stream() -> None:
    """After any damage the second whole message is understood at once, nearly always the first."""
    random_ = random.Random(20260101)
    stream, late = MapStream(codec.ACTUATORS), 0
    small = packed(Sonar=[True, True], Chest=[0.0] * 3, Extra=5)
    kinds = [small, small, small, packed(Position=[1.0] * 25), ACTUATORS]
    for _ in range(100_000):
        stream.feed(_damaged(random_.choice(kinds), random_))
        found = stream.feed(MARK)
        if not found or not is_mark(found[-1]):
            late += 1
            found = stream.feed(MARK)
            assert found and is_mark(found[-1])
    assert late < 1000  # the rest of such a damaged message looks like a part of the next


@pytest.mark.parametrize("wrong", [True, False, "0.1", None, math.nan, math.inf, [0.1]])
def test_an_element_that_is_no_number_leaves_its_joint_as_it_was(wrong: object) -> None:
    """LoLA's arrays are float 32; msgpack's booleans are another type."""
    setpoints = Setpoints([0.0] * 25)
    errors = setpoints.update({"Position": [wrong, *[0.1] * 24]})
    assert setpoints.position([0.5] * 25) == (0.5, *[0.1] * 24)
    assert [error.kind for error in errors] == ["Position, number"]
    assert "HeadYaw" in errors[0].text


@pytest.mark.parametrize(
    ("values", "position", "stiffness"),
    [
        ({"Stiffness": [7.0, -7.0, *[0.5] * 23]}, 0.0, (1.0, -1.0, *[0.5] * 23)),
        ({"Position": [1.0] * 24, "Stiffness": [0.0] * 25}, 0.0, (0.0,) * 25),
        ({"Position": [30.0] * 25}, 30.0, (0.2,) * 25),  # degrees? the robot's own ranges clip it
    ],
)
def test_a_wrong_map_is_one_error_and_the_rest_of_it_counts(
    values: dict[str, Any], position: float, stiffness: tuple[float, ...]
) -> None:
    setpoints = Setpoints([0.2] * 25)
    assert len(setpoints.update(values)) == 1
    assert setpoints.position([0.0] * 25)[0] == position
    assert setpoints.stiffness == stiffness
