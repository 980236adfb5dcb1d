"""The fate of packets against the closed forms of what was asked for."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.measure.site import QUEUE_SIZE, Channel
from tests.measure.site import NetworkConditions as Conditions

N = 20_000


def arrivals(conditions: Conditions, gap: float = 0.001, size: int = 500) -> list[tuple[float, float | None]]:
    channel = Channel(conditions, np.random.default_rng(3))
    return [(gap * i, channel.arrival(gap * i, size)) for i in range(N)]


def test_ideal_conditions_do_nothing() -> None:
    assert all(sent == came for sent, came in arrivals(Conditions()))


def test_delay_is_the_delay_and_jitter_is_uniform_about_it() -> None:
    # Sent far apart, so that the order cannot bind: mean d, standard deviation j / sqrt 3.
    late = np.array([came - sent for sent, came in arrivals(Conditions(delay=0.02, jitter=0.01), 0.1) if came])
    assert late.mean() == pytest.approx(0.02, abs=3 * 0.01 / math.sqrt(3 * N))
    assert late.std() == pytest.approx(0.01 / math.sqrt(3), rel=0.02)
    assert late.min() >= 0.01 - 1e-12 and late.max() <= 0.03 + 1e-12


def test_jitter_alone_keeps_the_order_and_reordering_does_not() -> None:
    kept = [came for _, came in arrivals(Conditions(delay=0.02, jitter=0.02)) if came is not None]
    assert kept == sorted(kept)
    mixed = [came - sent for sent, came in arrivals(Conditions(delay=0.02, reorder=0.25)) if came is not None]
    early = sum(late == 0.0 for late in mixed)
    assert early == pytest.approx(0.25 * N, abs=4 * math.sqrt(0.25 * 0.75 * N))


def test_loss_is_a_fraction_and_an_outage_is_all() -> None:
    lost = sum(came is None for _, came in arrivals(Conditions(loss=0.05)))
    assert lost == pytest.approx(0.05 * N, abs=4 * math.sqrt(0.05 * 0.95 * N))
    assert all(came is None for _, came in arrivals(Conditions(outage=True)))


def test_a_narrow_line_carries_its_rate_and_drops_what_does_not_fit_its_queue() -> None:
    # 500 bytes each ms are 4 Mbit/s, four times what the link carries: 1000 packets wait, 4 ms each.
    came = [at for _, at in arrivals(Conditions(rate=1e6)) if at is not None]
    gaps = np.diff(came)
    assert gaps == pytest.approx(np.full(len(gaps), 0.004), rel=1e-6)
    assert len(came) == pytest.approx(N / 4 + QUEUE_SIZE, abs=3)
