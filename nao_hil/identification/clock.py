"""Commands on a clock of their own: its offset to the measurements' clock, from how the joints follow."""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.signal import correlate

from bridge.body import Body
from bridge.errors import ConfigurationError
from bridge.types import Array
from nao_hil.identification.measures import vertex
from nao_hil.runs.run import Run

_LAG: Final = {12: 0.036, 10: 0.040}
"""Time by which joints follow their commands by the body's cycle in ms, s: teams' configurations of real
robots. It cannot be separated from the clocks' offset, so it is assumed."""
_MATCH: Final = 0.5
"""Least correlation of commanded and measured speeds."""
_AMBIGUOUS: Final = 0.9
"""Fraction of the highest correlation from which on another one is reported."""
_NEAR: Final = 0.25
"""Offsets that belong to one peak, s to either side."""


def follow_lag(body: Body) -> float:
    """Time by which this body's joints are taken to follow their commands, s."""
    return _LAG.get(round(1e3 * body.cycle), 4.0 * body.cycle)


def clock_offset(run: Run, body: Body, path: object) -> tuple[float, tuple[str, ...]]:
    """Offset that puts the commands' times on the measurements' clock, s, and sentences about it.

    It is where commanded and measured speeds of all joints correlate best, less a real robot's lag.

    Args:
        run: With commands and joint angles.
        body: Gives cycle and lag.
        path: File, for the error.

    Raises:
        ConfigurationError: the joints follow the commands at no offset.
    """
    cycle, lag = body.cycle, follow_lag(body)
    time, asked_time = run["sensors"]["time"], run["actuators"]["time"]
    moved = _speeds(time - time[0], run["sensors"]["position"], cycle)
    asked = _speeds(asked_time - asked_time[0], run["actuators"]["position"], cycle)
    lags, match = _correlation(moved, asked)
    best = int(np.argmax(match))
    if match[best] < _MATCH:
        raise ConfigurationError(
            f"{path}: the commands have a clock of their own, and the joints follow them at no offset of it "
            f"(largest correlation of the speeds {max(match[best], 0.0):.2f}); give commands and angles of the "
            "same motion."
        )
    shift = (lags[0] + vertex(match, best)) * cycle
    offset = float(time[0] - asked_time[0] + shift - lag)
    notes = [
        f"The commands have a clock of their own: {offset:+.3f} s were added to their times, so that the "
        f"joints follow by {1e3 * lag:.0f} ms as real robots do (correlation of the speeds {match[best]:.2f}). "
        "This delay is assumed, not measured."
    ]
    far = np.abs(lags - lags[best]) * cycle > _NEAR
    if far.any() and match[far].max() > _AMBIGUOUS * match[best]:
        other = (lags[far][np.argmax(match[far])] - lags[best]) * cycle
        notes.append(
            f"The motion repeats: {other:+.2f} s more fit nearly as well; record one that begins at rest."
        )
    drift = _drift(moved, asked, int(lags[best]), cycle)
    if abs(drift) > cycle:
        notes.append(f"The clocks drift by {1e3 * drift:+.0f} ms between both halves; this is not corrected.")
    return offset, tuple(notes)


def _speeds(time: Array, angles: Array, cycle: float) -> Array:
    """Changes per cycle on an even grid, (rows, joints); 0 where nothing is known."""
    grid = np.arange(int(time[-1] / cycle) + 1) * cycle
    columns = []
    for column in angles.T:
        known = np.isfinite(column)
        columns.append(np.interp(grid, time[known], column[known]) if known.any() else np.zeros(len(grid)))
    return np.diff(np.stack(columns, axis=1), axis=0)


def _correlation(moved: Array, asked: Array) -> tuple[Array, Array]:
    """Lags in rows, and the correlation at each, over the part that both share."""
    product = sum(correlate(a, b, method="fft") for a, b in zip(moved.T, asked.T, strict=True))
    ones = [np.ones(len(moved)), np.ones(len(asked))]
    energy = [np.square(moved).sum(axis=1), np.square(asked).sum(axis=1)]
    shared = correlate(energy[0], ones[1], method="fft") * correlate(ones[0], energy[1], method="fft")
    least = 0.05 * energy[0].sum() * energy[1].sum()
    match = np.asarray(product) / np.sqrt(np.maximum(shared, max(least, 1e-12)))
    return np.arange(len(match), dtype=np.float64) - (len(asked) - 1), np.asarray(match)


def _drift(moved: Array, asked: Array, lag: int, cycle: float) -> float:
    """Lag of the second half less that of the first, s; 0 if a half does not move."""
    begin, end = max(lag, 0), min(lag + len(asked), len(moved))
    middle, near = (begin + end) // 2, round(_NEAR / cycle)
    best_lags = []
    for first, last in ((begin, middle), (middle, end)):
        lags, match = _correlation(moved[first:last], asked[first - lag : last - lag])
        match = np.where(np.abs(lags) <= near, match, -1.0)
        best = int(np.argmax(match))
        if match[best] < _MATCH:
            return 0.0
        best_lags.append(lags[0] + vertex(match, best))
    return float(best_lags[1] - best_lags[0]) * cycle
