"""The one table of both engines: its rows, and the rule by which the engines agree."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import msgspec
import numpy as np
from scipy.stats import quantile_test
from scipy.stats import t as student

from nao_hil.analysis.report.page import Claim, ReportTable
from nao_hil.analysis.statistics import wilson


class Value(msgspec.Struct, frozen=True, kw_only=True):
    """A number over some runs with the bounds of its 95 % interval."""

    value: float | None = None
    """None: there is no run to take it from."""
    low: float | None = None
    """None: too few runs for an interval."""
    high: float | None = None
    n: int
    """Runs; of a drive on the bench, 1."""

    def words(self) -> str:
        """As text for the report."""
        if self.value is None:
            return "none"
        if self.low is None or self.high is None:
            return f"{self.value:.3g}"
        return f"{self.value:.3g} ({self.low:.3g} to {self.high:.3g})"


class Count(msgspec.Struct, frozen=True, kw_only=True):
    """Successful runs, with Wilson's 95 % interval of the share."""

    count: int
    low: float
    high: float
    n: int

    def words(self) -> str:
        """As text for the report."""
        return f"{self.count} of {self.n} ({100.0 * self.low:.0f} to {100.0 * self.high:.0f} %)"


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """A figure on both engines."""

    figure: str
    """In words, with its unit."""
    pybullet: Value | Count
    mujoco: Value | Count
    ratio: Value | None = None
    """Of MuJoCo's to PyBullet's, seed by seed; None: not compared so, or no seed has both."""
    goal: str = ""
    """Required agreement; empty: none."""
    agree: bool | None = None
    """Verdict; None: nothing is required."""


def mean_of(values: Sequence[float]) -> Value:
    """Mean and Student's interval."""
    n = len(values)
    if not n:
        return Value(n=0)
    mean = float(np.mean(values))
    if n == 1:
        return Value(value=mean, n=1)
    half = float(student.ppf(0.975, n - 1) * np.std(values, ddof=1) / math.sqrt(n))
    return Value(value=mean, low=mean - half, high=mean + half, n=n)


def median_of(values: Sequence[float]) -> Value:
    """Median and its interval by order statistics, which six values or more have."""
    n = len(values)
    if not n:
        return Value(n=0)
    bounds = quantile_test(values, p=0.5).confidence_interval()
    low, high = (float(bound) if math.isfinite(bound) else None for bound in bounds)
    return Value(value=float(np.median(values)), low=low, high=high, n=n)


def count_of(through: Sequence[bool]) -> Count:
    """Successful runs of some."""
    low, high = wilson(sum(through), len(through))
    return Count(count=sum(through), low=low, high=high, n=len(through))


def paired_row(
    figure: str, pybullet: Mapping[int, float], mujoco: Mapping[int, float], within: float | None = None
) -> Row:
    """Means over the seeds that have the figure on both engines.

    Args:
        figure: In words.
        pybullet: By seed.
        mujoco: Likewise.
        within: Fraction by which the ratio of the engines may differ from 1, by the bounds of its interval;
            None: nothing is asked.
    """
    both = [seed for seed in pybullet if seed in mujoco]
    ratio = mean_of([mujoco[seed] / pybullet[seed] for seed in both])
    agree = None
    if within is not None:
        low, high = ratio.low, ratio.high
        agree = low is not None and high is not None and 1.0 - within <= low and high <= 1.0 + within
    return Row(
        figure=figure,
        pybullet=mean_of([pybullet[seed] for seed in both]),
        mujoco=mean_of([mujoco[seed] for seed in both]),
        ratio=ratio if both else None,
        goal="" if within is None else f"within {100.0 * within:g} %",
        agree=agree,
    )


def count_row(figure: str, pybullet: Sequence[bool], mujoco: Sequence[bool]) -> Row:
    """Successful runs on each engine; the intervals of both shares are to overlap."""
    one, other = count_of(pybullet), count_of(mujoco)
    return Row(
        figure=figure,
        pybullet=one,
        mujoco=other,
        goal="intervals overlap",
        agree=one.low <= other.high and other.low <= one.high,
    )


def row_claims(rows: Sequence[Row]) -> tuple[Claim, ...]:
    """A claim for each row of which something is asked."""
    return tuple(
        Claim(f"{row.figure} ({row.goal})", _measured(row), bool(row.agree)) for row in rows if row.goal
    )


def rows_table(rows: Sequence[Row]) -> ReportTable:
    """All rows for people."""
    verdicts = {True: "yes", False: "no", None: ""}
    return ReportTable(
        "Both engines; 95 % intervals in brackets",
        ("figure", "PyBullet", "MuJoCo", "MuJoCo / PyBullet", "goal", "agree"),
        tuple(
            (
                row.figure,
                row.pybullet.words(),
                row.mujoco.words(),
                "" if row.ratio is None else row.ratio.words(),
                row.goal,
                verdicts[row.agree],
            )
            for row in rows
        ),
    )


def _measured(row: Row) -> str:
    words = f"{row.pybullet.words()} on PyBullet, {row.mujoco.words()} on MuJoCo"
    return words if row.ratio is None else f"{words}, ratio {row.ratio.words()}"
