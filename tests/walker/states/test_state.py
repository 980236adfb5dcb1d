"""Head and arms that somebody else commands while the walker has the robot."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, LEG_SLOTS
from bridge.errors import FrameError
from bridge.messages import decode, encode
from bridge.messages.walk import UpperBody
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from tests.frames import standing_frame
from walker.states.state import RETURN_RATE, UpperBodyOrders

HEAD, ARM = INDEX["HeadYaw"], INDEX["LShoulderPitch"]
LEGS = sorted({slot for slots in LEG_SLOTS.values() for slot in slots})


def order(**angles: float) -> UpperBody:
    return UpperBody(joints=tuple(angles), position=tuple(angles.values()), stiffness=(0.5,) * len(angles))


def test_the_head_is_the_sender_s_and_the_legs_are_the_walker_s() -> None:
    body = load_body("nao-v5")
    mine, alone = (controller_maker(RunConfig(gait="omni"))(body, body.cycle) for _ in range(2))
    mine.upper_body.take(order(HeadYaw=0.7, LShoulderPitch=0.2))
    for seq in range(300):
        frame = standing_frame(seq, time=seq * body.cycle)
        given, plain = mine.tick(frame), alone.tick(frame)
        assert (given.position[HEAD], given.position[ARM], given.stiffness[HEAD]) == (0.7, 0.2, 0.5)
        assert [given.position[i] for i in LEGS] == [plain.position[i] for i in LEGS]
        assert [given.stiffness[i] for i in LEGS] == [plain.stiffness[i] for i in LEGS]
    assert mine.state == "walk"


def test_a_joint_that_is_given_back_returns_at_a_bounded_speed() -> None:
    state: Any = SimpleNamespace(name="walk", position=(0.0,) * 25, stiffness=1.0)
    orders = UpperBodyOrders()
    orders.take(order(HeadYaw=0.1))
    assert orders.merged(state, 0.01)[0][HEAD] == 0.1
    orders.take(order())
    angles = [orders.merged(state, 0.01)[0][HEAD] for _ in range(6)]
    assert angles == pytest.approx([max(0.1 - RETURN_RATE * 0.01 * i, 0.0) for i in range(1, 7)])


def test_a_robot_that_fell_has_its_own_angles() -> None:
    state: Any = SimpleNamespace(name="fallen", position=(0.0,) * 25, stiffness=0.0)
    orders = UpperBodyOrders()
    orders.take(order(HeadYaw=0.1))
    assert orders.merged(state, 0.01) == ((0.0,) * 25, (0.0,) * 25)


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"joints": ["LKneePitch"]}, "`LKneePitch` is no joint of the head or the arms"),
        ({"position": []}, "each joint has one position and one stiffness"),
        ({"stiffness": [2.0]}, "stiffness"),
    ],
)
def test_a_wrong_order_is_refused(changes: dict[str, Any], fault: str) -> None:
    wrong = {"version": 3, "joints": ["HeadYaw"], "position": [0.0], "stiffness": [1.0]} | changes
    with pytest.raises(FrameError, match=fault):
        decode(encode(wrong), UpperBody)  # type: ignore[type-var]
