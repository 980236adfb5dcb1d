"""Lateness and drift of frames whose sending times are known."""

from __future__ import annotations

import numpy as np
import pytest

from nao_hil.experiments.soak import lateness, punctuality

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


def test_punctuality_is_the_ordinary_windows_and_not_a_bursts() -> None:
    late = np.full(N, 1e-4)
    late[N // 2 :] = 3e-4
    assert punctuality(late, CYCLE) == pytest.approx((1e-4, 3e-4))
    late[100:400] = late[-1000:-500] = 0.1  # other work on the machine for some seconds
    assert punctuality(late, CYCLE) == pytest.approx((1e-4, 3e-4))


def test_punctuality_sees_one_cycle_in_fifty() -> None:
    late = np.full(N, 1e-4)
    late[N // 2 :: 50] = 0.02
    first, last = punctuality(late, CYCLE)
    assert first == pytest.approx(1e-4)
    assert last > 0.01


def test_punctuality_of_a_short_walk_has_a_first_and_a_last_third_too() -> None:
    assert punctuality(np.array([1e-4] * 30 + [5e-4] * 30), CYCLE) == pytest.approx((1e-4, 5e-4))
