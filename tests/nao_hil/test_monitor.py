"""The state of a robot, as its listeners are shown it."""

from __future__ import annotations

import pytest

from bridge.messages.guard import GuardStatus, State
from nao_hil.runs.monitor import walk_in_force
from tests.frames import standing_frame, walk_telemetry


@pytest.mark.parametrize(
    ("state", "age", "counts"),
    [
        ("active", 0, True),
        ("approach", 2, True),
        ("active", 100, False),  # a second: the walker is gone
        ("active", -1, False),  # of an earlier start of the robot
        ("hold", 0, False),
        ("crouch", 0, False),
        ("rest", 0, False),
        ("fallen", 0, False),
    ],
)
def test_the_word_of_a_walker_counts_while_the_robot_follows_it_and_it_is_fresh(
    state: State, age: int, counts: bool
) -> None:
    status = GuardStatus(seq=0, state=state, armed=True, text="A test.")
    telemetry = walk_telemetry(500)
    assert walk_in_force(status, telemetry, standing_frame(500 + age)) == (telemetry if counts else None)
    assert walk_in_force(status, None, standing_frame(500)) is None
