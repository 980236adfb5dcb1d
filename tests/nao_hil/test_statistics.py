"""Intervals and tests against printed values, closed forms and exact chances."""

import math

import numpy as np
import pytest
from scipy.stats import binom, multinomial, ttest_rel

from nao_hil.analysis.statistics import (
    Sprt,
    holm,
    mean_of,
    median_of,
    paired,
    paired_interval,
    score_bounds,
    wilson,
)


# Newcombe, Statistics in Medicine 17 (1998), table I, method 3
@pytest.mark.parametrize(
    ("successes", "n", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_wilson_is_the_printed_score_interval(successes: int, n: int, low: float, high: float) -> None:
    assert wilson(successes, n) == pytest.approx((low, high), abs=5e-5)


def test_pairs_are_counted_seed_by_seed() -> None:
    found = paired([True, True, True, False, False], [False, False, True, True, False])
    assert (found.both, found.only_with, found.only_without, found.neither) == (1, 2, 1, 1)
    assert found.difference == pytest.approx(0.2)
    # of three discordant pairs one or fewer on the rare side, either way: 2 (1 + 3) / 8
    assert found.p_value == pytest.approx(1.0)
    assert math.isclose(paired([True] * 5, [False] * 5).p_value, 2.0 * 0.5**5)


# both, only first, only second, n: Newcombe, Statistics in Medicine 17 (1998) 2635, method 10; Fagerland,
# Statistical Analysis of Contingency Tables (2017), chapter 8 (Cavo 2012; Bentur 2009)
@pytest.mark.parametrize(
    ("pairs", "low", "high"),
    [
        ((36, 12, 2, 50), 0.0569, 0.3404),
        ((59, 6, 16, 161), -0.1186, -0.0046),
        ((1, 1, 7, 21), -0.507, -0.026),
    ],
)
def test_the_interval_of_paired_shares_is_the_printed_one(
    pairs: tuple[int, int, int, int], low: float, high: float
) -> None:
    assert paired_interval(*pairs) == pytest.approx((low, high), abs=5e-4)


def test_the_interval_of_paired_shares_holds_the_true_difference() -> None:
    """Exact chances of all outcomes of 12 pairs, 20 sets of shares: 95 % in the mean, never under 90 %."""
    random, n, covered = np.random.default_rng(3), 12, []
    outcomes = [(a, b, c) for a in range(n + 1) for b in range(n + 1 - a) for c in range(n + 1 - a - b)]
    intervals = [paired_interval(*outcome, n) for outcome in outcomes]
    for p in random.dirichlet((2.0, 1.0, 1.0, 2.0), size=20):
        chances = multinomial.pmf([(*o, n - sum(o)) for o in outcomes], n, p)
        inside = [low <= p[1] - p[2] <= high for low, high in intervals]
        covered.append(float(np.sum(chances, where=inside)))
    assert np.mean(covered) > 0.94 and min(covered) > 0.90


def test_holms_correction_is_the_printed_one() -> None:
    """R's `p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")`."""
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([]) == []


def test_the_interval_of_a_mean_is_students() -> None:
    values = [1.0, 1.2, 0.9, 1.1, 1.3]
    found = mean_of(values)
    bounds = ttest_rel(values, [0.0] * 5).confidence_interval()
    assert found.interval == pytest.approx((bounds.low, bounds.high))
    assert (mean_of([1.0]).value, mean_of([1.0]).interval) == (1.0, (-math.inf, math.inf))
    assert math.isnan(mean_of([]).value)


def test_the_interval_of_a_median_is_of_order_statistics() -> None:
    """Of ten values the second and the ninth: 1 - 2 P(X <= 1) = 97.9 % with X binomial, of the third 89.1 %."""
    found = median_of([float(value) for value in range(1, 11)])
    assert 1.0 - 2.0 * binom.cdf(1, 10, 0.5) > 0.95 > 1.0 - 2.0 * binom.cdf(2, 10, 0.5)
    assert (found.value, found.interval) == (5.5, (2.0, 9.0))
    assert median_of([3.0, 4.0]).interval == (-math.inf, math.inf)


def test_the_sequential_test_keeps_its_errors() -> None:
    # exact: the chance of each count of successes among the undecided, trial by trial
    test = Sprt(most=200)
    for p, wrong in ((test.low, True), (test.high, False)):
        states, mistaken = {0: 1.0}, 0.0
        for n in range(1, 201):
            after: dict[int, float] = {}
            for k, mass in states.items():
                for success, q in ((1, p), (0, 1.0 - p)):
                    verdict = test.verdict(k + success, n)
                    if verdict is None:
                        after[k + success] = after.get(k + success, 0.0) + mass * q
                    elif verdict is wrong:
                        mistaken += mass * q
            states = after
        assert mistaken < test.error


def test_bounds_of_scores_are_wilsons_for_successes_and_cover_the_mean() -> None:
    for successes, n in ((0, 5), (3, 7), (20, 20)):
        assert score_bounds(successes, n) == pytest.approx(wilson(successes, n), abs=1e-9)
    # scores of 0.3 or 1, drawn with chance p: the lower bound is seldom above the mean
    n, p = 20, 0.5
    mean = 0.3 * (1.0 - p) + p
    above = sum(binom.pmf(k, n, p) for k in range(n + 1) if score_bounds(k + 0.3 * (n - k), n)[0] > mean)
    assert above < 0.025
