"""How sure a share of a few runs is: Wilson's interval, and McNemar's test for pairs of the same seed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist

import msgspec


def wilson(successes: int, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Score interval of a share (Wilson 1927), without continuity correction.

    Args:
        successes: Out of `n`.
        n: Trials; of none nothing is known: (0, 1).
        confidence: Of the two-sided interval.

    Returns:
        Lower and upper bound, within 0..1.

    Raises:
        ValueError: more successes than trials, or a negative number of them.
    """
    if not 0 <= successes <= n:
        raise ValueError(f"{successes} successes of {n} trials")
    if n == 0:
        return 0.0, 1.0
    z = NormalDist().inv_cdf(0.5 + 0.5 * confidence)
    share, spread = successes / n, z * z / n
    middle = (share + 0.5 * spread) / (1.0 + spread)
    half = z / (1.0 + spread) * math.sqrt(share * (1.0 - share) / n + spread / (4.0 * n))
    # at 0 and n the bounds are 0 and 1 but for rounding
    return (
        0.0 if successes == 0 else max(0.0, middle - half),
        1.0 if successes == n else min(1.0, middle + half),
    )


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
    """Share that survived with, less that without."""
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
    """Two-sided exact p-value: discordant pairs are a fair coin's under the hypothesis of no difference."""
    n, fewer = only_first + only_second, min(only_first, only_second)
    tail = float(sum(math.comb(n, k) for k in range(fewer + 1))) / 2.0**n
    return min(1.0, 2.0 * tail)
