"""Three minutes of the rough test (`tests/chaos`), from one seed."""

from __future__ import annotations

import pytest

from tests.chaos.__main__ import rough


@pytest.mark.realtime
def test_three_rough_minutes_break_no_promise() -> None:
    report = rough(180.0, 1, "mujoco")
    assert not report.violations
    assert sum(report.events.values()) > 5 and report.recordings >= 3
