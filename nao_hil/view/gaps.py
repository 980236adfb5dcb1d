"""Curves with gaps: where no value is known, and where the recording has a break."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from nao_hil.view.looks import Floats

BREAK: Final = 5.0
"""Multiple of the usual time between two rows from which on there is a break between them."""


def with_breaks(rows: Floats, phases: Sequence[str]) -> tuple[Floats, list[str]]:
    """A row without values, and without a phase, in the middle of each break.

    Args:
        rows: Shape (n, columns), the first column increasing times, s.
        phases: Of each row.
    """
    steps = np.diff(rows[:, 0])
    if not len(steps):
        return rows, list(phases)
    (at,) = np.nonzero(steps > BREAK * np.median(steps))
    empty = np.full((len(at), rows.shape[1]), np.nan)
    empty[:, 0] = rows[at, 0] + 0.5 * steps[at]
    return np.insert(rows, at + 1, empty, axis=0), np.insert(np.array(phases, object), at + 1, "").tolist()


def with_gaps(curves: Sequence[Floats]) -> Any:
    """Data of a plot of viser whose curves end where a value is NaN.

    uPlot draws across NaN in an array of numbers, but not across null in a list. viser sends None in lists
    within a list as null, and makes arrays of what is in a tuple.
    """
    return [
        [None if math.isnan(value) else value for value in curve.tolist()]
        if np.isnan(curve).any()
        else curve.copy()
        for curve in curves
    ]
