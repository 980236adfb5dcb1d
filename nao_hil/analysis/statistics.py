"""Statistics of few runs: intervals of shares and scores, a sequential test, and McNemar's test for pairs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import msgspec
import numpy as np
from scipy.stats import binomtest, norm, quantile_test
from scipy.stats import t as student

ENOUGH: Final = 20
"""Runs of a condition; the title of a report of fewer names the number."""


def wilson(successes: int, n: int) -> tuple[float, float]:
    """Two-sided 95 % score interval of a proportion (Wilson 1927), without continuity correction.

    Args:
        successes: Out of `n`.
        n: Trials; for none the interval is (0, 1).

    Returns:
        Lower and upper bound, within 0..1.

    Raises:
        ValueError: more successes than trials, or a negative number of them.
    """
    if n == successes == 0:
        return 0.0, 1.0
    interval = binomtest(successes, n).proportion_ci(0.95, method="wilson")
    return float(interval.low), float(interval.high)


def score_bounds(total: float, n: int) -> tuple[float, float]:
    """95 % bounds of a mean of scores from 0 to 1: Wilson's interval with the total in place of successes.

    A score in 0..1 of mean p has at most the variance p (1 - p) of a success with that chance, so the bounds
    hold at least as surely as Wilson's.

    Args:
        total: Sum of the scores.
        n: How many; for none the bounds are 0 and 1.
    """
    if n == 0:
        return 0.0, 1.0
    z2, p = float(norm.ppf(0.975)) ** 2, total / n
    half = math.sqrt(z2 * p * (1.0 - p) / n + z2 * z2 / (4.0 * n * n))
    middle, scale = p + z2 / (2.0 * n), 1.0 + z2 / n
    return max(0.0, (middle - half) / scale), min(1.0, (middle + half) / scale)


class Share(msgspec.Struct, frozen=True, kw_only=True):
    """Runs that succeeded, out of some, with Wilson's 95 % interval of the share."""

    n: int
    survived: int
    """Or met the condition that the share is of."""
    interval: tuple[float, float] = (0.0, 1.0)
    """Computed from the two numbers."""

    def __post_init__(self) -> None:
        """Compute the interval."""
        msgspec.structs.force_setattr(self, "interval", wilson(self.survived, self.n))

    @property
    def survival_ratio(self) -> float:
        """Survivors over runs."""
        return self.survived / self.n

    def words(self) -> str:
        """As text for the report: `18 of 20 (70 to 97 %)`."""
        return f"{self.survived} of {self.n} ({percent(self.interval)})"


def share_of(successes: Sequence[bool]) -> Share:
    """The share of runs that succeeded."""
    return Share(n=len(successes), survived=sum(successes))


class Sprt(msgspec.Struct, frozen=True, kw_only=True):
    """Wald's sequential test of a proportion: stop as soon as one of two shares is sure enough.

    Source: Wald, Sequential Tests of Statistical Hypotheses, 1945. Both errors have the same bound.
    """

    low: float = 0.25
    """Share of one hypothesis."""
    high: float = 0.75
    """Share of the other."""
    error: float = 0.02
    """Chance of a wrong verdict, for either."""
    most: int = 20
    """Trials after which the majority decides."""

    def verdict(self, successes: int, n: int) -> bool | None:
        """Whether the share is the high one; None: not sure yet.

        Args:
            successes: Out of `n`.
            n: Trials so far.
        """
        ratio = successes * math.log(self.high / self.low)
        ratio += (n - successes) * math.log((1.0 - self.high) / (1.0 - self.low))
        bound = math.log((1.0 - self.error) / self.error)
        if abs(ratio) >= bound:
            return ratio > 0.0
        return 2 * successes >= n if n >= self.most else None


def few_words(n: int) -> str:
    """For the title of a report of fewer than 20 seeds; empty otherwise."""
    return f" (only {n} of {ENOUGH} seeds)" if n < ENOUGH else ""


def percent(interval: tuple[float, float]) -> str:
    """An interval of a share in words: `84 to 100 %`."""
    low, high = (100.0 * bound for bound in interval)
    return f"{low:.0f} to {high:.0f} %"


class Paired(msgspec.Struct, frozen=True, kw_only=True):
    """The same seeds with and without."""

    n: int
    """Seeds that ran in both conditions."""
    both: int
    """Survived in both."""
    only_with: int
    only_without: int
    neither: int
    difference: float
    """Ratio that survived with, less that without."""
    interval: tuple[float, float]
    """95 % interval of the difference."""
    p_value: float
    """Exact McNemar test, two-sided: how likely so lopsided a split of the discordant pairs is by chance."""


def paired(with_: Sequence[bool], without: Sequence[bool]) -> Paired:
    """Compare two conditions seed by seed.

    Args:
        with_: Survived, one element per seed.
        without: The same seeds in the same order.

    Raises:
        ValueError: not as many in one as in the other.
    """
    pairs = list(zip(with_, without, strict=True))
    only_with, only_without = pairs.count((True, False)), pairs.count((False, True))
    n = len(pairs)
    return Paired(
        n=n,
        both=pairs.count((True, True)),
        only_with=only_with,
        only_without=only_without,
        neither=pairs.count((False, False)),
        difference=(only_with - only_without) / n if n else 0.0,
        interval=paired_interval(pairs.count((True, True)), only_with, only_without, n),
        p_value=mcnemar(only_with, only_without),
    )


def paired_interval(both: int, only_first: int, only_second: int, n: int) -> tuple[float, float]:
    """95 % interval of the difference of two shares of the same units, the first less the second.

    Source: Newcombe, Improved confidence intervals for the difference between binomial proportions based on
    paired data, Statistics in Medicine 17 (1998) 2635, method 10: Wilson's intervals of both shares and the
    correlation of the pairs.

    Args:
        both: Pairs that succeeded in both conditions.
        only_first: In the first only.
        only_second: In the second only.
        n: Pairs; for none the interval is (-1, 1).
    """
    if not n:
        return -1.0, 1.0
    first, second, neither = both + only_first, both + only_second, n - both - only_first - only_second
    p, q = first / n, second / n
    (p_low, p_high), (q_low, q_high) = wilson(first, n), wilson(second, n)
    product, excess = first * (n - first) * second * (n - second), both * neither - only_first * only_second
    lessened = max(excess - 0.5 * n, 0.0) if excess > 0 else excess
    correlation = lessened / math.sqrt(product) if product else 0.0

    def half(a: float, b: float) -> float:
        """Half of the width, given the halves of the shares' own intervals."""
        return math.sqrt(max(a * a - 2.0 * correlation * a * b + b * b, 0.0))

    return p - q - half(p - p_low, q_high - q), p - q + half(p_high - p, q - q_low)


def mcnemar(only_first: int, only_second: int) -> float:
    """Two-sided exact p-value of McNemar's test.

    Args:
        only_first: Pairs that succeeded in the first condition only.
        only_second: Pairs that succeeded in the second condition only.
    """
    n = only_first + only_second
    return float(binomtest(only_first, n, 0.5).pvalue) if n else 1.0


def holm(p_values: Sequence[float]) -> list[float]:
    """p-values of several tests, corrected so that the chance of any false finding stays below the level.

    Source: Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of Statistics 6
    (1979) 65.
    """
    corrected, largest = [1.0] * len(p_values), 0.0
    for rank, i in enumerate(sorted(range(len(p_values)), key=p_values.__getitem__)):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[i]))
        corrected[i] = largest
    return corrected


class Estimate(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A value and its 95 % interval; in JSON a number that is not finite is null."""

    value: float
    """NaN: no run has it."""
    interval: tuple[float, float]
    """Infinite: too few runs for one."""
    n: int | None = None
    """Runs; of a drive on the bench, 1; None: not estimated from runs."""

    def within(self, low: float, high: float) -> bool:
        """Whether the whole interval lies between `low` and `high`."""
        return self.interval[0] >= low and self.interval[1] <= high

    def words(self, scale: float = 1.0, digits: int | None = None) -> str:
        """As text for the report: multiplied by `scale`, with `digits` after the point or three in all."""
        if math.isnan(self.value):
            return "none"
        form = ".3g" if digits is None else f".{digits}f"
        value, low, high = (format(scale * number, form) for number in (self.value, *self.interval))
        return f"{value} ({low} to {high})" if math.isfinite(sum(self.interval)) else value


def mean_of(values: Sequence[float]) -> Estimate:
    """Mean and Student's interval, which two values or more have."""
    n = len(values)
    mean = float(np.mean(values)) if n else math.nan
    if n < 2:
        return Estimate(value=mean, interval=(-math.inf, math.inf), n=n)
    half = float(student.ppf(0.975, n - 1) * np.std(values, ddof=1) / math.sqrt(n))
    return Estimate(value=mean, interval=(mean - half, mean + half), n=n)


def median_of(values: Sequence[float]) -> Estimate:
    """Median and its interval by order statistics, which six values or more have."""
    if not values:
        return mean_of(values)
    bounds = quantile_test(values, p=0.5).confidence_interval()
    low, high = np.nan_to_num(bounds[0], nan=-math.inf), np.nan_to_num(bounds[1], nan=math.inf)
    return Estimate(value=float(np.median(values)), interval=(float(low), float(high)), n=len(values))
