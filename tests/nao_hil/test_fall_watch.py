"""What counts as a fall."""

from __future__ import annotations

import pytest

from bridge.messages import Notice, WalkTelemetry
from nao_hil.runs.fall_watch import FallWatch


def says(state: str) -> WalkTelemetry:
    sole = (0.0,) * 6
    return WalkTelemetry(
        seq=1,
        state=state,
        phase="stand",
        step=0,
        steps=0,
        zmp=(0.0, 0.0),
        com=(0.0, 0.0),
        left=sole,
        right=sole,
    )


def test_a_robot_that_began_lying_falls_once_it_has_stood() -> None:
    watch = FallWatch()
    assert [watch.update(down=down) for down in (True, True, False, True, True)] == [False] * 3 + [True, False]
    watch.restart()
    assert not watch.update(down=True)


@pytest.mark.parametrize(
    ("state", "falls"), [("walk", True), ("stand", True), ("motion", False), ("rest", False)]
)
def test_going_down_in_a_motion_or_at_rest_is_no_fall(state: str, falls: bool) -> None:
    watch = FallWatch()
    watch.update(down=False)
    watch.telemetry(says(state))
    assert watch.update(down=True) == falls


def test_a_robot_that_its_guard_sits_down_has_not_fallen() -> None:
    watch = FallWatch()
    watch.update(down=False)
    watch.notice(Notice(seq=1, level="info", code="guard-sit", text=""))
    assert not watch.update(down=True)
    watch.update(down=False)
    watch.notice(Notice(seq=1, level="info", code="guard-active", text=""))
    assert watch.update(down=True)
