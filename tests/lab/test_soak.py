"""Lateness and drift of frames whose sending times are known."""

from __future__ import annotations

import numpy as np
import pytest

from lab.experiments.soak import lateness

CYCLE = 0.01
N = 6000


def frames(late: np.ndarray, first: int = 17) -> list[tuple[int, int]]:
    """Frames sent `late` s after their time on the grid."""
    return [(first + i, 10**18 + round((CYCLE * i + extra) * 1e9)) for i, extra in enumerate(late)]


def test_lateness_is_what_it_was_made_to_be() -> None:
    made = np.abs(np.random.default_rng(1).normal(0.0, 1e-3, N))
    made[::1000] = made[-1] = 0.0  # each ten seconds hold a frame on time
    late, drift = lateness(frames(made), CYCLE)
    assert late == pytest.approx(made, abs=1e-8)
    assert drift == pytest.approx(0.0, abs=1e-8)


def test_a_clock_that_runs_slow_is_drift() -> None:
    # 50 ppm over a minute, seen between the first and the sixth ten seconds.
    _, drift = lateness(frames(50e-6 * CYCLE * np.arange(N)), CYCLE)
    assert drift == pytest.approx(50e-6 * 50.0, rel=1e-3)


def test_skipped_cycles_are_no_drift() -> None:
    made = np.zeros(N)
    made[2500:] += 3 * CYCLE
    late, drift = lateness(frames(made), CYCLE)
    assert drift == pytest.approx(0.0, abs=1e-8)
    assert late.max() == pytest.approx(0.0, abs=1e-8)
