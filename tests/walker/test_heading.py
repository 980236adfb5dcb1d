"""Heading by the gyroscope: a turn of a tilted torso, and the bias at rest."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.rotations import rotation
from tests.walker.test_controller import frame
from walker.estimation.heading import GyroscopeHeading

BODY = load_body("nao-v6")
DT = 0.01


def turned(rates, *, angle=(0.0, 0.0), moving=True):
    """Heading after frames with these rates of the torso, rad/s."""
    heading, found = GyroscopeHeading(BODY), 0.0
    for seq, rate in enumerate(rates):
        still = frame(seq)
        position = tuple(p + 0.01 * (seq % 2) for p in still.position) if moving else still.position
        told = msgspec.structs.replace(
            still, time=seq * DT, gyroscope=tuple(rate), angle=angle, position=position
        )
        found = heading.update(told)
    return found


@pytest.mark.parametrize("angle", [(0.0, 0.0), (0.1, 0.0), (0.0, -0.2), (0.1, 0.2)])
def test_a_turn_about_the_vertical_is_seen_whatever_the_tilt(angle):
    rate = rotation(*angle, 0.0).T @ np.array([0.0, 0.0, 0.5])
    assert turned([rate] * 201, angle=angle) == pytest.approx(1.0, rel=1e-9)


def test_the_bias_at_rest_is_not_a_turn():
    bias = (0.0, 0.0, 0.01)
    assert abs(turned([bias] * 1001, moving=False)) < 0.015  # of 0.1 rad: what came before it was known
    assert turned([bias] * 1001) == pytest.approx(0.1)


def test_only_three_axes_tell_a_heading():
    assert GyroscopeHeading.of(load_body("nao-v3")) is None
    assert math.isfinite(turned([(0.0, 0.0, 1.0)] * 3))
