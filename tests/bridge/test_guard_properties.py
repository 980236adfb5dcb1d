"""Whatever is sent to a guard, in whatever order, whatever is measured: what comes out keeps the bounds."""

from __future__ import annotations

import math
from typing import Literal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bridge.body import load_body
from bridge.body.joints import JOINTS, N_JOINTS
from bridge.body.quantities import HANDS, coupled_limits
from bridge.errors import FrameError
from bridge.guard import Guard, GuardSettings
from bridge.messages import ActuatorFrame, SensorFrame
from tests.frames import standing_frame

BODIES = {name: load_body(name) for name in ("nao-v3", "nao-v6")}
ROUNDING = 1e-9


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
requests: st.SearchStrategy[Literal["crouch", "limp", "arm", ""]] = st.sampled_from(
    ["", "", "", "", "arm", "crouch", "limp"]
)
stretches = st.lists(
    st.tuples(
        st.one_of(st.none(), commands),
        st.integers(1, 40),
        requests,
        angles,
        st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
        st.sampled_from([30.0, 30.0, 90.0, 99.0]),
        st.sampled_from([1.0, 1.0, 0.1, 0.01]),
        st.booleans(),
    ),
    min_size=1,
    max_size=12,
)
"""Command or silence, for so many cycles, a request, what is measured meanwhile, and supervision."""


@pytest.mark.parametrize("name", BODIES)
@settings(max_examples=60)
@given(history=stretches)
def test_no_history_makes_an_output_leave_the_ranges_or_outrun_the_motors(name: str, history: list) -> None:  # type: ignore[type-arg]
    body, bounds = BODIES[name], GuardSettings()
    guard = Guard(body, bounds)
    # the data sheet's motors, figured here anew
    steps = {
        joint: bounds.speed_ratio
        * (body.motors[sheet.motor].no_load_speed_rpm / 60.0 * 2.0 * math.pi / sheet.gear_ratio)
        * body.cycle
        for joint, sheet in body.joints.items()
    }
    seq, last = 0, None
    for wish, cycles, request, measured, angle, heat, charge, supervised in history:
        if request == "arm":
            guard.arm()
        elif request:
            guard.stop(request)
        for _ in range(cycles):
            frame = sensors(seq, measured, angle, heat, charge)
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
