from __future__ import annotations

from bridge.link.rate import RateLimit


def test_a_burst_passes_and_a_flood_is_cut_to_the_rate() -> None:
    limit = RateLimit(rate=100.0, burst=10)
    assert [limit.admits(1.0) for _ in range(12)] == [True] * 10 + [False] * 2
    # A flood of 10 kHz for a second: a hundred pass.
    assert sum(limit.admits(1.0 + i * 1e-4) for i in range(1, 10_001)) == 100


def test_after_a_pause_no_more_than_a_burst_has_gathered() -> None:
    limit = RateLimit(rate=100.0, burst=10)
    for _ in range(10):
        limit.admits(0.0)
    assert sum(limit.admits(3600.0) for _ in range(50)) == 10
