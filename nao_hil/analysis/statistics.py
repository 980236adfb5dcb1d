"""Statistics of few runs: Wilson's interval, and McNemar's test for pairs of the same seed."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
from scipy.stats import binomtest


def wilson(successes: int, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Score interval of a proportion (Wilson 1927), without continuity correction.

    Args:
        successes: Out of `n`.
        n: Trials; for none the interval is (0, 1).
        confidence: Of the two-sided interval.

    Returns:
        Lower and upper bound, within 0..1.

    Raises:
        ValueError: more successes than trials, or a negative number of them.
    """
    if n == successes == 0:
        return 0.0, 1.0
    interval = binomtest(successes, n).proportion_ci(confidence, method="wilson")
    return float(interval.low), float(interval.high)


class Paired(msgspec.Struct, frozen=True, kw_only=True):
    """The same seeds with and without."""

    n: int
    """Seeds that ran in both arms."""
    both: int
    """Survived in both."""
    only_with: int
    only_without: int
    neither: int
    difference: float
    """Ratio that survived with, less that without."""
    p_value: float
    """Exact McNemar test, two-sided: how likely so lopsided a split of the discordant pairs is by chance."""


def paired(with_: Sequence[bool], without: Sequence[bool]) -> Paired:
    """Compare two arms seed by seed.

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
        p_value=mcnemar(only_with, only_without),
    )


def mcnemar(only_first: int, only_second: int) -> float:
    """Two-sided exact p-value of McNemar's test.

    Args:
        only_first: Pairs that succeeded in the first arm only.
        only_second: Pairs that succeeded in the second arm only.
    """
    n = only_first + only_second
    return float(binomtest(only_first, n, 0.5).pvalue) if n else 1.0
