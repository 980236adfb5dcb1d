from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS, N_JOINTS
from bridge.errors import FrameError
from bridge.guard import Guard
from bridge.messages import ActuatorFrame

V6 = load_body("nao-v6")
H21 = load_body("nao-v3")
WRISTS_AND_HANDS = ("LWristYaw", "RWristYaw", "LHand", "RHand")


def command(reply_to: int = 0, stiffness: float = 1.0, **angles: float) -> ActuatorFrame:
    """All joints at 0, which every range but some of the arms' contains, except the named ones."""
    arms = {"LElbowRoll": -0.5, "RElbowRoll": 0.5, "LShoulderRoll": 0.3, "RShoulderRoll": -0.3}
    wanted = arms | angles
    return ActuatorFrame(
        reply_to=reply_to, position=tuple(wanted.get(j, 0.0) for j in JOINTS), stiffness=(stiffness,) * N_JOINTS
    )


def test_a_frame_inside_all_ranges_passes_unchanged() -> None:
    guard = Guard(V6)
    frame = command(LHipPitch=-0.4, LKneePitch=0.8, LAnklePitch=-0.4, LHand=1.0)
    assert guard.check(frame, 0) == frame
    assert guard.clipped == ""


# Ranges of the vendor's joint page for V4 to V6, rad.
@pytest.mark.parametrize(
    ("joint", "wanted", "limit"),
    [
        ("LKneePitch", 3.0, 2.112528),
        ("LKneePitch", -1.0, -0.092346),
        ("RHipRoll", 0.7, 0.379472),
        ("LHipYawPitch", 2.0, 0.740810),
        ("LHand", 1.2, 1.0),
    ],
)
def test_an_angle_outside_the_range_is_clipped_with_one_sentence(
    joint: str, wanted: float, limit: float
) -> None:
    guard = Guard(V6)
    checked = guard.check(command(**{joint: wanted}), 0)
    assert checked.position[INDEX[joint]] == pytest.approx(limit, abs=1e-4)
    assert joint in guard.clipped
    assert f"{wanted:.3f} rad" in guard.clipped
    assert guard.clipped.count(". ") == 0
    guard.check(command(), 0)
    assert guard.clipped == ""


# Rows of the vendor's anti-collision table: at this pitch the roll may be so large.
@pytest.mark.parametrize(
    ("pitch_joint", "pitch", "roll_joint", "lower", "upper"),
    [
        ("LAnklePitch", -0.840027, "LAnkleRoll", -0.179943, 0.169995),
        ("LAnklePitch", 0.349938, "LAnkleRoll", -0.397935, 0.550477),
        ("RAnklePitch", -0.700051, "RAnkleRoll", -0.220086, 0.397935),
        ("HeadYaw", 0.903033, "HeadPitch", -0.479965, 0.330041),
        ("HeadYaw", -0.903033, "HeadPitch", -0.479965, 0.330041),
    ],
)
def test_a_coupled_angle_is_clipped_to_the_row_of_the_table(
    pitch_joint: str, pitch: float, roll_joint: str, lower: float, upper: float
) -> None:
    guard = Guard(V6)
    for wanted, limit in ((-1.0, lower), (1.0, upper)):
        checked = guard.check(command(**{pitch_joint: pitch, roll_joint: wanted}), 0)
        assert checked.position[INDEX[roll_joint]] == pytest.approx(limit, abs=1e-4)
        assert roll_joint in guard.clipped


def test_a_coupled_range_follows_the_clipped_angle_not_the_wanted_one() -> None:
    """AnklePitch beyond its upper end is clipped there, where AnkleRoll has almost no room."""
    checked = Guard(V6).check(command(LAnklePitch=9.0, LAnkleRoll=0.3), 0)
    assert checked.position[INDEX["LAnklePitch"]] == pytest.approx(0.922747, abs=1e-4)
    assert checked.position[INDEX["LAnkleRoll"]] == pytest.approx(0.049916, abs=1e-3)


@given(st.lists(st.floats(-1e6, 1e6), min_size=N_JOINTS, max_size=N_JOINTS))
def test_what_passes_once_passes_again_unchanged(angles: list[float]) -> None:
    guard = Guard(V6)
    frame = ActuatorFrame(reply_to=0, position=tuple(angles), stiffness=(0.5,) * N_JOINTS)
    once = guard.check(frame, 0)
    assert guard.check(once, 0) == once
    assert guard.clipped == ""


def test_joints_that_the_body_lacks_are_ignored() -> None:
    guard = Guard(H21)
    checked = guard.check(command(**dict.fromkeys(WRISTS_AND_HANDS, 99.0)), 0)
    assert [checked.position[INDEX[j]] for j in WRISTS_AND_HANDS] == [0.0] * 4
    assert guard.clipped == ""


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_none_is_refused_by_slot_and_value(value: float) -> None:
    with pytest.raises(FrameError, match=str(value)) as error:
        Guard(V6).check(command(LKneePitch=value), 0)
    assert "LKneePitch" in str(error.value) or f"position[{INDEX['LKneePitch']}]" in str(error.value)


@pytest.mark.parametrize("value", [1.01, -1.01, 100.0])
def test_a_stiffness_outside_its_range_is_refused_by_joint_and_value(value: float) -> None:
    with pytest.raises(FrameError, match="HeadYaw") as error:
        Guard(V6).check(command(stiffness=value), 0)
    assert str(value) in str(error.value)


@pytest.mark.parametrize("value", [-1.0, 0.0, 1.0])
def test_both_ends_of_the_stiffness_pass(value: float) -> None:
    assert Guard(V6).check(command(stiffness=value), 0).stiffness == (value,) * N_JOINTS


def test_an_answer_to_a_frame_not_sent_yet_is_refused() -> None:
    guard = Guard(V6)
    assert guard.check(command(reply_to=5), 5).reply_to == 5
    assert guard.check(command(reply_to=4), 5).reply_to == 4
    with pytest.raises(FrameError, match="reply_to"):
        guard.check(command(reply_to=6), 5)
