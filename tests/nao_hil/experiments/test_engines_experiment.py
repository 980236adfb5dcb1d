"""The table of both engines: intervals and verdicts from numbers whose answer is known."""

import math

import pytest
from scipy.stats import ttest_rel

from nao_hil.experiments.arms import Arm
from nao_hil.experiments.engines import Mean, WalkPair, _frequency_claim, _walk_claims, mean_of


def an_arm(survived: int, interval: tuple[float, float]) -> Arm:
    return Arm(n=20, survived=survived, interval=interval, fall_times=(), tilt_max_deg=(1.0, 2.0), speed=0.1)


def test_the_interval_of_a_mean_is_students() -> None:
    values = [1.0, 1.2, 0.9, 1.1, 1.3]
    found = mean_of(values)
    bounds = ttest_rel(values, [0.0] * 5).confidence_interval()
    assert (found.low, found.high) == (pytest.approx(bounds.low), pytest.approx(bounds.high))
    assert math.isinf(mean_of([1.0]).high)


def test_a_verdict_stands_on_the_bound_of_its_interval() -> None:
    narrow = Mean(mean=1.02, low=0.95, high=1.09, n=20)
    arms = {"pybullet": an_arm(20, (0.84, 1.0)), "mujoco": an_arm(19, (0.76, 0.99))}
    pair = WalkPair(gait="static", arms=arms, speeds={}, ratio=narrow)
    assert [claim.holds for claim in _walk_claims(pair, 0.1)] == [True, True]
    wide = WalkPair(gait="static", arms=arms, speeds={}, ratio=Mean(mean=1.02, low=0.93, high=1.11, n=20))
    assert not _walk_claims(wide, 0.1)[0].holds
    apart = arms | {"mujoco": an_arm(5, (0.11, 0.47))}
    falls = WalkPair(gait="static", arms=apart, speeds={}, ratio=None)
    assert [claim.holds for claim in _walk_claims(falls, 0.1)] == [False, False]


def test_frequencies_agree_when_the_farthest_ends_of_their_intervals_do() -> None:
    one = Mean(mean=7.0, low=6.9, high=7.1, n=20)
    near = Mean(mean=7.1, low=7.0, high=7.2, n=20)
    assert _frequency_claim({"pybullet": one, "mujoco": near}, 0.05).holds
    far = Mean(mean=7.2, low=7.1, high=7.3, n=20)
    assert not _frequency_claim({"pybullet": one, "mujoco": far}, 0.05).holds
