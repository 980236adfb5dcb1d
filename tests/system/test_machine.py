"""A failed real-time test is excused by the machine alone."""

from __future__ import annotations

from tests.system.machine import complaint

FAST = [0.001] * 300


def test_an_idle_machine_is_no_excuse() -> None:
    assert complaint([1e-4] * 1000, FAST) == ""
    assert complaint([1e-4] * 991 + [0.05] * 9, FAST) == ""  # nine outliers in a thousand


def test_a_machine_that_wakes_late_is_named() -> None:
    assert complaint([1e-4] * 980 + [0.006] * 20, FAST) == (
        "a bare loop beside it began 2.0 % of its cycles over 5 ms late"
    )
    assert "2.0 %" in complaint([1e-4] * 20_000 + [0.006] * 20 + [1e-4] * 10_000, FAST)  # for one moment
    assert "100.0 %" in complaint([0.006] * 9, FAST)
    assert complaint([], FAST) == ""
