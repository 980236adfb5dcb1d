"""Frames from a real robot's ALMemory, whose values may be None or NaN."""

from __future__ import annotations

import math
from typing import Any

import pytest

pytest.importorskip("qi")

from bridge.adapters.naoqi.real_robot import FrameReader
from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.errors import LinkError

BODY = load_body("nao-v5")


def reading(reader: FrameReader, **changes: Any) -> list[Any]:
    """A value for each key; those of keys that contain a name (`__` for `/`) are others."""
    values: list[Any] = [0.5] * len(reader.keys)
    for part, value in changes.items():
        places = [i for i, key in enumerate(reader.keys) if part.replace("__", "/") in key]
        assert places, part
        for i in places:
            values[i] = value
    return values


@pytest.mark.parametrize("unread", [None, math.nan, "?", []])
def test_a_value_that_ends_is_nan_and_one_that_never_was_is_zero(unread: Any) -> None:
    reader = FrameReader(BODY)
    assert reader.fields(reading(reader, US__Left=None, US__Right=None))["sonar"] == (
        0.0,
        0.0,
    )  # the robot lacks it
    fields = reader.fields(
        reading(reader, US__Left=None, US__Right=None, LKneePitch__Position=unread, AngleX=unread)
    )
    assert fields["sonar"] == (0.0, 0.0)
    assert [i for i, value in enumerate(fields["position"]) if math.isnan(value)] == [INDEX["LKneePitch"]]
    assert [math.isnan(value) for value in fields["angle"]] == [True, False]


def test_another_body_is_refused_at_its_first_reading() -> None:
    reader = FrameReader(BODY)
    with pytest.raises(LinkError, match="LKneePitch"):
        reader.fields(reading(reader, LKneePitch__Position=None))


@pytest.mark.parametrize("clock", [None, math.nan])
def test_a_clock_that_cannot_be_read_ends_the_connection(clock: Any) -> None:
    reader = FrameReader(BODY)
    for values in (reading(reader, DCM__Time=clock), reading(reader)[:-1]):
        with pytest.raises(LinkError):
            reader.time(values)
