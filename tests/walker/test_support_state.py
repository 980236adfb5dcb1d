"""Touch-down, contact, falls, attitude, swing-foot orientation control and damping: each by itself."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame
from bridge.types import Side, Vec2
from tests.frames import standing_frame
from walker.estimation.attitude import Attitude, AttitudeParameters
from walker.estimation.contact import (
    ContactEstimator,
    ContactParameters,
    Contacts,
    SupportState,
    SupportStateMachine,
    TouchDownParameters,
)
from walker.estimation.fall import FallDetector, FallParameters
from walker.gaits import Plan, SolePose
from walker.gaits.plan import Support
from walker.mechanisms.admittance import LegAdmittance, LegParameters
from walker.mechanisms.capture_step import LandedFootParameters
from walker.mechanisms.stance_ankle import DampingParameters, LeanFeedbackParameters, StanceAnkle, StridePattern
from walker.mechanisms.swing_foot import SwingFootOrientation, SwingFootOrientationParameters
from walker.parameters import controller_parameters

DT = 0.01
BOTH, LEFT, NO_FEEDBACK = Contacts(True, True), Contacts(True, False), Contacts(False, False)


def plan(support: Support, progress: float = 0.5) -> Plan:
    return Plan(
        phase="SSL" if support == "L" else "DSL",
        support=support,
        progress=progress,
        step=0,
        left=SolePose(0.0, 0.05),
        right=SolePose(0.06, -0.05),
        com=(0.0, 0.0),
        zmp=(0.0, 0.0),
        hip_height=0.215,
    )


def test_a_foot_that_has_landed_is_a_stance_foot_when_its_phase_ends() -> None:
    machine = SupportStateMachine(TouchDownParameters(max_wait=0.5))
    assert machine.update(plan("L"), LEFT, DT).role("R") == "swing"
    assert machine.update(plan("L", 0.95), BOTH, DT).role("R") == "swing"  # early: the phase goes on
    assert machine.update(plan("both"), BOTH, DT) == SupportState("both")


def test_a_late_foot_is_lowered_and_waited_for_within_bounds() -> None:
    machine = SupportStateMachine(TouchDownParameters(max_wait=0.2, search_depth=0.01, search_rate=0.04))
    machine.update(plan("L"), LEFT, DT)
    searches, waits = [], []
    for _ in range(60):
        support_state = machine.update(plan("both"), LEFT, DT)
        searches.append(support_state.search_depth)
        waits.append(support_state.wait)
    assert searches[:3] == pytest.approx([0.0004, 0.0008, 0.0012])  # rate x time
    assert max(searches) <= 0.01
    assert sum(waits) == pytest.approx(20, abs=1)
    assert support_state == SupportState(
        "both"
    )  # 0.01 m / 0.04 m/s = 0.25 s after the phase began it counts as landed


def test_a_late_foot_that_finds_ground_ends_the_wait() -> None:
    machine = SupportStateMachine(TouchDownParameters(max_wait=0.5))
    machine.update(plan("L"), LEFT, DT)
    assert machine.update(plan("both"), LEFT, DT).wait
    assert machine.update(plan("both"), BOTH, DT) == SupportState("both")
    assert machine.update(plan("both"), LEFT, DT) == SupportState("both")  # one landing per swing


def test_without_touch_down_parameters_the_plan_is_believed() -> None:
    machine = SupportStateMachine(None)
    machine.update(plan("L"), LEFT, DT)
    assert machine.update(plan("both"), NO_FEEDBACK, DT) == SupportState("both", 0.5)


def test_search_reaches_further_than_the_depression_the_plan_allows_for() -> None:
    p = LegParameters()
    leg = LegAdmittance(p)
    for k in range(150):
        leg.swing(0.0, DT, progress=min(1.0, k / 100))
    assert leg.swing(0.0, DT) == pytest.approx(-p.target_depth, abs=1e-3)
    for _ in range(50):
        lift = leg.swing(0.0, DT, search_depth=0.01)
    assert lift == pytest.approx(-p.target_depth - 0.01, abs=1e-3)


def test_a_shift_keeps_inside_the_pole() -> None:
    leg = LegAdmittance(LegParameters())
    leg.shift(-1.0)
    assert abs(leg.e) < LegParameters().pole


def test_contact_has_hysteresis() -> None:
    estimator = ContactEstimator(ContactParameters(on=3.0, off=1.5))
    seen = [estimator.update((f / 4,) * 4 + (0.0,) * 4).left for f in (0.0, 2.0, 2.9, 3.1, 2.0, 1.6, 1.4, 2.0)]
    assert seen == [False, False, False, True, True, True, False, False]


def test_contact_thresholds_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="off"):
        controller_parameters("static", {"contact": {"on": 1.0, "off": 2.0}})


def test_a_misspelt_controller_parameter_is_named_with_what_was_meant() -> None:
    with pytest.raises(ConfigurationError, match=r"swing_foot_orientation\.gai.*gain"):
        controller_parameters("static", {"swing_foot_orientation": {"gai": 0.0}})


def test_a_short_flight_is_no_fall() -> None:
    detector = FallDetector(FallParameters(no_support=0.5))
    for _ in range(45):
        assert not detector.update((0.0, 0.0), NO_FEEDBACK, DT, walking=True)
    assert not detector.update((0.0, 0.0), LEFT, DT, walking=True)
    for _ in range(45):
        assert not detector.update((0.0, 0.0), NO_FEEDBACK, DT, walking=True)


def test_a_capture_step_may_lean_farther_before_it_counts_as_a_fall() -> None:
    p = FallParameters()
    leans = 0.5 * (p.angle + p.capture_angle)
    assert FallDetector(p).update((0.0, -leans), LEFT, DT, walking=True)
    assert not FallDetector(p).update((0.0, -leans), LEFT, DT, walking=True, capturing=True)
    assert FallDetector(p).update((0.0, -p.capture_angle - 0.01), LEFT, DT, walking=True, capturing=True)


def test_after_a_capture_step_back_both_soles_lie_in_one_plane_until_the_torso_is_upright() -> None:
    """With the torso leaning back by 20 degrees both soles are turned by it about one axis, and end level."""
    p = SwingFootOrientationParameters(return_rate=2.0, max_rate=4.0)
    control, lean = SwingFootOrientation(p, LandedFootParameters()), math.radians(-20.0)
    swing = replace(plan("L"), capture="R", right=SolePose(-0.1, -0.1))
    for k in range(40):
        found = control.update((0.0, lean), swing, SupportState("L", progress=k / 40), LEFT, DT)
    assert found["R"].pitch == pytest.approx(-lean)
    assert found["R"].lift == pytest.approx(-0.1 * lean)  # 0.1 m behind, the ground is so much higher
    landed = replace(swing, phase="stop", support="both")
    turns = []
    for _ in range(60):
        found = control.update((0.0, lean), landed, SupportState("both"), LEFT, DT)
        turns.append((found["L"].pitch, found["R"].pitch))
        assert found["L"].lift == 0.0
    assert min(abs(left - right) for left, right in turns if right > 0.1) <= 2.0 * p.return_rate * DT
    assert turns[-1] == (0.0, 0.0)


def test_orientation_control_puts_the_swing_sole_level_at_its_planned_height() -> None:
    """Rotate the swing foot about the stance foot by the torso's tilt: level and at height, to first order."""
    p = SwingFootOrientationParameters()
    control = SwingFootOrientation(p, LandedFootParameters())
    roll, pitch = math.radians(5.0), math.radians(-3.0)
    for k in range(200):
        corrections = control.update(
            (roll, pitch), plan("L"), SupportState("L", progress=min(k / 100, 0.9)), LEFT, DT
        )
    right = corrections["R"]
    assert (right.roll, right.pitch) == pytest.approx((-roll, -pitch))
    # 0.1 m to the right a foot goes down with a roll about +x, 0.06 m ahead with a nose-down pitch.
    sunk = -math.sin(roll) * 0.1 - math.sin(pitch) * 0.06
    assert right.lift == pytest.approx(-sunk, rel=0.01)
    assert corrections["L"] == (0.0, 0.0, 0.0)


def test_orientation_control_holds_at_contact_and_returns_in_stance() -> None:
    control = SwingFootOrientation(SwingFootOrientationParameters(return_rate=0.2), LandedFootParameters())
    for _ in range(200):
        control.update((0.1, 0.0), plan("L"), SupportState("L", progress=0.9), LEFT, DT)
    held = control.update((0.2, 0.0), plan("L"), SupportState("L", progress=0.95), BOTH, DT)["R"]
    assert held.roll == pytest.approx(-0.1)
    after = control.update((0.2, 0.0), plan("both"), SupportState("both"), BOTH, DT)["R"]
    assert after.roll == pytest.approx(-0.1 + 0.2 * DT)
    for _ in range(100):
        after = control.update((0.2, 0.0), plan("both"), SupportState("both"), BOTH, DT)["R"]
    assert after.roll == 0.0


def test_damping_turns_the_stance_ankle_with_the_fall_and_never_jumps() -> None:
    """Nose going down: toe down pushes the body back, so AnklePitch rises (`stabilization.torso.sign`)."""
    p = DampingParameters(roll=0.08, pitch=0.08)
    damping = StanceAnkle(p, LeanFeedbackParameters(pitch=0.5), DT, on_rate=True, on_lean=False)
    for _ in range(20):
        offsets = damping.update((0.0, 0.5, 0.0), (0.2, 0.2), "L", 0.5)
    assert offsets.pitch == pytest.approx((0.04, 0.0))
    before = offsets
    for support in ("both", "R", "L", "R"):
        after = damping.update((3.0, -3.0, 0.0), (0.0, 0.0), support, 0.5)
        for axis in (0, 1):
            for leg in (0, 1):
                assert abs(after[axis][leg] - before[axis][leg]) <= p.max_rate * DT + 1e-12
        before = after


def test_lean_feedback_turns_the_stance_ankle_against_the_lean() -> None:
    """The offsets right the torso as those of damping do (`torso.sign`); the swing ankle has none."""
    ankle = StanceAnkle(
        DampingParameters(pitch=0.1),
        LeanFeedbackParameters(roll=0.2, pitch=0.3, pattern_gain=0.0),
        DT,
        on_rate=False,
        on_lean=True,
    )
    for _ in range(20):
        offsets = ankle.update((1.0, 1.0, 1.0), (0.05, -0.1), "R", 0.5)
    assert offsets.pitch == pytest.approx((0.0, -0.03))
    assert offsets.roll == pytest.approx((0.0, 0.01))
    for _ in range(20):
        offsets = ankle.update((0.0, 0.0, 0.0), (0.05, -0.1), "both", 0.5)
    assert offsets == ((0.0, 0.0), (0.0, 0.0))


def test_the_pattern_of_a_stride_is_what_alternates_between_the_feet() -> None:
    """A lean of a + b on the left foot and a - b on the right one has the common part a, by arithmetic."""
    pattern, common, alternating = StridePattern(0.1), np.array([0.02, 0.15]), np.array([-0.03, 0.04])
    sides: tuple[tuple[Side, float], ...] = (("L", 1.0), ("R", -1.0))
    left: dict[tuple[Side, float], Vec2] = {}
    for _ in range(100):
        for side, sign in sides:
            for progress in (0.1, 0.6, 1.0):
                lean = common + sign * alternating * progress
                left[side, progress] = pattern.without((lean[0], lean[1]), side, progress)
    for each in left.values():
        assert each == pytest.approx(common, abs=1e-4)


def imu(seq: int, fused: float, pitch: float, shock: float) -> SensorFrame:
    """A torso at `pitch` whose fused angle is wrong, shaken along x as a walk does: no net speed."""
    g = 9.81
    return standing_frame(
        seq,
        time=seq * DT,
        accelerometer=(-g * math.sin(pitch) + shock, 0.0, g * math.cos(pitch)),
        angle=(0.0, fused),
    )


def test_attitude_takes_the_drift_out_of_the_fused_angle() -> None:
    """The fused angle runs away by 0.3 deg/s; the torso stands at 2 deg and is shaken with 3 m/s^2 at 2 Hz."""
    attitude = Attitude(AttitudeParameters())
    true, drift = math.radians(2.0), math.radians(0.3)
    errors = []
    for k in range(6000):
        shock = 3.0 * math.sin(4.0 * math.pi * k * DT)
        _, pitch = attitude.update(imu(k, true + drift * k * DT, true, shock), DT)
        if k > 4000:
            errors.append(pitch - true)
    assert max(map(abs, errors)) < math.radians(1.0)
    assert abs(sum(errors) / len(errors)) < math.radians(0.2)


def test_attitude_at_gain_zero_is_the_fused_angle() -> None:
    attitude = Attitude(AttitudeParameters(proportional=0.0, integral=0.0))
    for k in range(10):
        assert attitude.update(imu(k, 0.1, -0.2, 1.0), DT) == (0.0, 0.1)
