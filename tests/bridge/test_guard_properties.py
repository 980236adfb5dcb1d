"""Whatever is sent to a guard, in whatever order, whatever is measured: what comes out keeps the bounds."""

from __future__ import annotations

import math
from typing import Literal

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS, N_JOINTS
from bridge.body.quantities import HANDS, coupled_limits
from bridge.errors import FrameError
from bridge.guard import Guard, GuardSettings
from bridge.messages import ActuatorFrame, SensorFrame
from tests.frames import STANDING, standing_frame

BODIES = {name: load_body(name) for name in ("nao-v3", "nao-v6")}
ROUNDING = 1e-9
# The vendor's motor pages of the V3.2 and the V6: motor's no-load speed in rpm, gear ratio, joints behind it.
MOTORS = {
    "nao-v3": (
        (8000.0, 201.3, "HipYawPitch HipRoll AnkleRoll"),
        (8000.0, 130.85, "HipPitch KneePitch AnklePitch"),
        (11900.0, 150.27, "HeadYaw ShoulderPitch ElbowYaw"),
        (11900.0, 173.22, "HeadPitch ShoulderRoll ElbowRoll"),
    ),
    "nao-v6": (
        (8700.0, 201.3, "HipYawPitch HipRoll AnkleRoll"),
        (8700.0, 130.85, "HipPitch KneePitch AnklePitch"),
        (10700.0, 150.27, "HeadYaw ElbowYaw"),
        (11400.0, 150.27, "ShoulderPitch"),
        (10700.0, 173.22, "HeadPitch ShoulderRoll ElbowRoll"),
        (8400.0, 50.61, "WristYaw"),
    ),
}
SPEED_RATIO = 2.0
"""Speed of a joint over its no-load speed at most (docs/guard.md)."""


def no_load_speed(name: str, joint: str) -> float:
    """rad/s of a joint, by its robot's motor page."""
    (speed,) = [
        rpm / 60.0 * 2.0 * math.pi / ratio
        for rpm, ratio, joints in MOTORS[name]
        if joint.removeprefix("L").removeprefix("R") in joints.split()
    ]
    return speed


def sensors(
    seq: int,
    position: tuple[float, ...],
    angle: tuple[float, float] = (0.0, 0.0),
    heat: float = 30.0,
    charge: float = 1.0,
) -> SensorFrame:
    return standing_frame(
        seq, position=position, temperature=(heat,) * N_JOINTS, angle=angle, battery=(charge, 0.0, 0.0, 25.0)
    )


angles = st.lists(st.floats(-4.0, 4.0), min_size=N_JOINTS, max_size=N_JOINTS).map(tuple)
stiffnesses = st.one_of(
    st.floats(-1.0, 1.0).map(lambda s: (s,) * N_JOINTS),
    st.lists(st.floats(-1.0, 1.0), min_size=N_JOINTS, max_size=N_JOINTS).map(tuple),
)
commands = st.tuples(angles, stiffnesses, st.integers(0, 2))
"""Positions, stiffnesses, number of the lease."""
JUMP = [
    (((-4.0,) * N_JOINTS, (1.0,) * N_JOINTS, 1), 2, "", None, (0.0, 0.0), 30.0, 1.0, True),
    (((4.0,) * N_JOINTS, (1.0,) * N_JOINTS, 1), 40, "", None, (0.0, 0.0), 30.0, 1.0, True),
]
"""A robot that is where its command is gets another one, at the other end of all ranges."""
requests: st.SearchStrategy[Literal["crouch", "limp", "arm", ""]] = st.sampled_from(
    ["", "", "", "", "arm", "crouch", "limp"]
)
unread = st.sampled_from([math.nan, math.inf, -math.inf])
readings = st.one_of(
    angles,
    st.lists(st.one_of(st.floats(-4.0, 4.0), unread), min_size=N_JOINTS, max_size=N_JOINTS).map(tuple),
)
leans = st.one_of(st.floats(-1.0, 1.0), unread)
stretches = st.lists(
    st.tuples(
        st.one_of(st.none(), commands),
        st.integers(1, 40),
        requests,
        st.one_of(st.none(), readings),
        st.one_of(st.just((0.0, 0.0)), st.tuples(leans, leans)),
        st.sampled_from([30.0, 30.0, 90.0, 99.0, math.nan]),
        st.sampled_from([1.0, 1.0, 0.1, 0.01, math.nan]),
        st.booleans(),
    ),
    min_size=1,
    max_size=12,
)
"""Command or silence, for so many cycles, a request, measured positions (None: the last commanded ones), angle,
heat and charge, and supervision."""


@pytest.mark.parametrize("name", BODIES)
@settings(max_examples=60)
@given(history=stretches)
@example(history=JUMP)
def test_no_history_makes_an_output_leave_the_ranges_or_outrun_the_motors(name: str, history: list) -> None:  # type: ignore[type-arg]
    body = BODIES[name]
    guard = Guard(body)
    steps = {
        joint: SPEED_RATIO * no_load_speed(name, joint) * body.cycle
        for joint in body.joints
        if joint in INDEX and joint not in HANDS
    }
    seq, last, asked = 0, None, STANDING.position
    for wish, cycles, request, measured, angle, heat, charge, supervised in history:
        asked = wish[0] if wish is not None else asked
        if request == "arm":
            guard.arm()
        elif request:
            guard.stop(request)
        for _ in range(cycles):
            frame = sensors(seq, asked if measured is None else measured, angle, heat, charge)
            command = None
            if wish is not None:
                sent = ActuatorFrame(reply_to=seq, position=wish[0], stiffness=wish[1], lease=wish[2])
                try:
                    command = guard.check(sent, seq)
                except FrameError:
                    assert not guard.armed
            given = guard.cycle(frame, command, supervised=supervised)
            seq += 1
            if given is None:
                continue
            assert all(-1.0 <= value <= 1.0 for value in given.stiffness)
            for i, joint in enumerate(JOINTS):
                if joint in HANDS or joint not in body.joints:
                    continue
                position = given.position[i]
                other = {"LAnkleRoll": "LAnklePitch", "RAnkleRoll": "RAnklePitch", "HeadPitch": "HeadYaw"}
                at = given.position[JOINTS.index(other.get(joint, joint))]
                lower, upper = coupled_limits(body, joint, at)
                assert lower - ROUNDING <= position <= upper + ROUNDING, joint
                # a joint that was limp is where it is measured, and one whose range hangs on it goes with it;
                # one that is stiff moves from its last request
                pair = (i, JOINTS.index(other.get(joint, joint)))
                if last is not None and min(f.stiffness[k] for f in (last, given) for k in pair) > 0.2:
                    assert abs(position - last.position[i]) <= steps[joint] + ROUNDING, joint
            last = given


@settings(max_examples=30)
@given(measured=angles, wish=angles)
def test_a_first_command_far_away_is_approached_slowly_from_where_the_robot_is(
    measured: tuple[float, ...], wish: tuple[float, ...]
) -> None:
    body, bounds = BODIES["nao-v6"], GuardSettings()
    guard = Guard(body, bounds)
    command = ActuatorFrame(reply_to=0, position=wish, stiffness=(1.0,) * N_JOINTS)
    inside = guard.check(ActuatorFrame(reply_to=0, position=measured, stiffness=(1.0,) * N_JOINTS), 0).position
    last, arrived = inside, False
    for seq in range(2000):
        given = guard.cycle(sensors(seq, measured), guard.check(command, seq))
        assert given is not None
        if guard.state == "approach":
            for i, joint in enumerate(JOINTS):
                if joint not in HANDS:
                    assert abs(given.position[i] - last[i]) <= bounds.approach.speed * body.cycle + ROUNDING
        last = given.position
        arrived = given.position == guard.check(command, seq).position
        if arrived:
            break
    assert arrived


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


def test_an_answer_to_a_frame_not_sent_yet_is_refused() -> None:
    guard = Guard(V6)
    assert guard.check(command(reply_to=5), 5).reply_to == 5
    assert guard.check(command(reply_to=4), 5).reply_to == 4
    with pytest.raises(FrameError, match="reply_to"):
        guard.check(command(reply_to=6), 5)
