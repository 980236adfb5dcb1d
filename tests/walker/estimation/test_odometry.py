"""Heading by the gyroscope: a turn of a tilted torso, and the bias at rest."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.rotations import rotation
from tests.walker.test_controller import frame
from walker.estimation.odometry import GyroscopeHeading

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


@pytest.mark.parametrize("bias", [0.01, -0.04, 0.09])  # 0.09: three deviations of the ensemble's largest
def test_the_bias_at_rest_is_not_a_turn(bias):
    """Also on a V6, whose data sheet gives a spread of 1.8e-4 rad/s only."""
    rates = [(0.0, 0.0, bias)] * 1001
    assert abs(turned(rates, moving=False)) < 0.15 * abs(10.0 * bias)  # what came before it was known
    assert turned(rates) == pytest.approx(10.0 * bias)


@pytest.mark.parametrize("turn", [0.002, -0.002])
def test_the_settling_of_a_short_rest_is_no_bias(turn):
    """A turn of 0.1 degrees in a rest of 1.5 s; ten minutes later it has made less than 10 degrees."""
    settles, walks = [(0.0, 0.0, turn / 1.5)] * 150, [(0.0, 0.0, 0.0)] * 10000
    before = turned(settles, moving=False)
    heading = GyroscopeHeading(BODY)
    for seq, rate in enumerate([*settles, *walks]):
        still = frame(seq)
        position = tuple(p + 0.01 * (seq % 2 if seq >= 150 else 0) for p in still.position)
        found = heading.update(msgspec.structs.replace(still, time=seq * DT, gyroscope=rate, position=position))
    assert abs(found - before) * 6 < math.radians(10.0)


def test_the_bias_is_known_after_a_crouch_on_both_feet():
    """The torso shakes forward and back and the knees bend; nothing turns it but the bias of 0.01 rad/s.

    Less than the settling of a rest, 0.1 degrees, is left in nine seconds.
    """
    heading, found = GyroscopeHeading(BODY), []
    for seq in range(1001):
        still = frame(seq)
        position = list(still.position)
        position[INDEX["LHipYawPitch"]] = 0.0
        position[INDEX["LKneePitch"]] += 0.01 * seq if seq < 100 else 1.0 + 0.01 * (seq % 2)
        told = msgspec.structs.replace(
            still,
            time=seq * DT,
            gyroscope=(-0.02, 0.3 * math.sin(0.1 * seq), 0.01),
            angle=(0.0, 0.0),
            position=tuple(position),
            fsr=(6.0,) * 8,
        )
        found.append(heading.update(told))
    assert found[-1] - found[100] == pytest.approx(0.0, abs=0.002)
