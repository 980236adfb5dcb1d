"""Intervals and tests of shares against printed values and independent implementations."""

import math

import pytest
from scipy.stats import binomtest

from nao_hil.analysis.statistics import mcnemar, paired, wilson


# Newcombe, Statistics in Medicine 17 (1998), table I, method 3
@pytest.mark.parametrize(
    ("successes", "n", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_wilson_is_the_printed_score_interval(successes: int, n: int, low: float, high: float) -> None:
    assert wilson(successes, n) == pytest.approx((low, high), abs=5e-5)


@pytest.mark.parametrize("confidence", [0.8, 0.95, 0.99])
@pytest.mark.parametrize(("successes", "n"), [(0, 1), (3, 20), (19, 20), (20, 20), (50, 100)])
def test_wilson_agrees_with_scipy(successes: int, n: int, confidence: float) -> None:
    expected = binomtest(successes, n).proportion_ci(confidence, method="wilson")
    assert wilson(successes, n, confidence) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_of_no_trials_nothing_is_known() -> None:
    assert wilson(0, 0) == (0.0, 1.0)


def test_more_successes_than_trials_are_refused() -> None:
    with pytest.raises(ValueError, match="greater"):
        wilson(3, 2)


@pytest.mark.parametrize(("first", "second"), [(0, 20), (12, 2), (5, 5), (1, 0), (0, 0)])
def test_mcnemar_is_a_fair_coin_on_the_discordant_pairs(first: int, second: int) -> None:
    expected = binomtest(first, first + second, 0.5).pvalue if first + second else 1.0
    assert mcnemar(first, second) == pytest.approx(expected, rel=1e-12)


def test_pairs_are_counted_seed_by_seed() -> None:
    found = paired([True, True, True, False, False], [False, False, True, True, False])
    assert (found.both, found.only_with, found.only_without, found.neither) == (1, 2, 1, 1)
    assert found.difference == pytest.approx(0.2)
    # of three discordant pairs one or fewer on the rare side, either way: 2 (1 + 3) / 8
    assert found.p_value == pytest.approx(1.0)
    assert math.isclose(paired([True] * 5, [False] * 5).p_value, 2.0 * 0.5**5)
