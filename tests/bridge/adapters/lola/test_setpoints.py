"""Joint setpoints of a client's maps."""

from __future__ import annotations

import math

import pytest

from bridge.adapters.lola.client import Setpoints


@pytest.mark.parametrize("wrong", [True, False, "0.1", None, math.nan, [0.1]])
def test_an_element_that_is_no_number_leaves_its_joint_as_it_was(wrong: object) -> None:
    """LoLA's arrays are float 32; msgpack's booleans are another type."""
    setpoints = Setpoints([0.5] * 25, [0.0] * 25)
    errors = setpoints.update({"Position": [wrong, *[0.1] * 24]})
    assert setpoints.position == (0.5, *[0.1] * 24)
    assert [error.kind for error in errors] == ["Position, number"]
    assert "HeadYaw" in errors[0].text
