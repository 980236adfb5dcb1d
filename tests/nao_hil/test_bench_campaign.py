"""The simulated scheduler of the campaign benchmark against closed forms."""

from __future__ import annotations

import pytest

from nao_hil.bench.campaign import busy_share, workers_kept_busy


def test_one_worker_waits_for_the_service_alone() -> None:
    assert busy_share(1, service=1.0, walk=3.0, rounds=3000) == pytest.approx(3.0 / 4.0, rel=0.01)


def test_far_too_many_workers_share_what_the_scheduler_hands_out() -> None:
    assert busy_share(1000, service=0.01, walk=1.0) == pytest.approx(1.0 / (1000 * 0.01), rel=0.1)


def test_the_workers_that_are_kept_busy_are_those_of_the_saturated_scheduler() -> None:
    """With hundreds of workers the scheduler is saturated at 95 %: n = walk / (0.95 service)."""
    assert workers_kept_busy(service=0.01, walk=3.0, share=0.95) == pytest.approx(3.0 / 0.0095, rel=0.03)
