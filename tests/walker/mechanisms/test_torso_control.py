"""Torso control: linear where it should be, bounded everywhere; the sign between AnklePitch and AngleY."""

from __future__ import annotations

import math

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from nao_hil.design.torso.robust import robust_design
from nao_hil.design.torso.thesis import DYNAMIC_GAIT, STATIC_GAIT, thesis_design
from nao_hil.design.torso.transfer import thesis_plant
from walker.mechanisms.torso_control import TorsoControl, TorsoLimits, ankle_pitch_from_lean

WIDE = TorsoLimits(offset=1e3, rate=1e6, bleed_rate=1.0)
CYCLE = 0.01

DESIGNS = {
    "static": thesis_design(thesis_plant(), STATIC_GAIT),
    "dynamic": thesis_design(thesis_plant(), DYNAMIC_GAIT),
    "robust": robust_design(thesis_plant()),
}


@pytest.fixture(params=sorted(DESIGNS))
def design(request):
    return DESIGNS[request.param]


def pitches(seed: int, count: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, 0.05, count)


def test_unlimited_it_is_the_transfer_function(design) -> None:
    """Lean = G_R e with e = -AngleY, and AnklePitch = -lean: so AnklePitch = G_R AngleY."""
    pitch = pitches(1, 500)
    for leg, index in (("L", 0), ("R", 1)):
        torso = TorsoControl(design.controller, WIDE)
        offsets = np.array([torso.update(p, leg) for p in pitch])
        expected = lfilter(design.numerator_z, design.denominator_z, pitch)
        assert offsets[:, index] == pytest.approx(expected, abs=1e-9)
        assert np.all(offsets[:, 1 - index] == 0.0)
    expected = control.forced_response(design.controller_z, T=np.arange(len(pitch)) * CYCLE, U=pitch).outputs
    assert offsets[:, 1] == pytest.approx(np.ravel(expected), abs=1e-9)


def test_the_feedback_is_negative(design) -> None:
    """Around the thesis' plant in NAO's axes (gain -1 from AnklePitch) an error dies as the design says.

    The error starts at an instant, so the torso is 1 minus the design's step response times it.
    """
    sampled = control.ss(design.plant_z)
    state = np.zeros(sampled.nstates)
    torso = TorsoControl(design.controller, WIDE)
    initial = math.radians(4.0)
    course = []
    for _ in range(400):
        pitch = initial + float(np.ravel(sampled.C @ state)[0])
        course.append(pitch)
        left, _ = torso.update(pitch, "L")
        state = sampled.A @ state + np.ravel(sampled.B) * -left
    assert np.array(course) == pytest.approx(initial * (1.0 - design.step.output[:400]), abs=1e-9)


def test_the_error_dies_inside_the_default_limits(design) -> None:
    sampled = control.ss(design.plant_z)
    state = np.zeros(sampled.nstates)
    torso = TorsoControl(design.controller)
    pitch = math.inf
    for _ in range(1000):
        pitch = math.radians(5.0) + float(np.ravel(sampled.C @ state)[0])
        state = sampled.A @ state + np.ravel(sampled.B) * -torso.update(pitch, "R")[1]
    assert abs(pitch) < math.radians(0.1)


phases = st.lists(
    st.tuples(st.sampled_from(["L", "R", "both"]), st.integers(1, 60), st.floats(), st.floats(-0.5, 0.5)),
    min_size=1,
    max_size=12,
)


@settings(max_examples=200)
@given(st.sampled_from(sorted(DESIGNS)), phases)
def test_continuous_and_bounded_under_anything(name: str, course) -> None:
    """Each phase: who stands, for how many cycles, one wild first sample (any float), then a likely one."""
    limits = TorsoLimits()
    torso = TorsoControl(DESIGNS[name].controller, limits)
    before = (0.0, 0.0)
    for support, cycles, wild, pitch in course:
        for cycle in range(cycles):
            after = torso.update(wild if cycle == 0 else pitch, support)
            for old, new in zip(before, after, strict=True):
                assert math.isfinite(new)
                assert abs(new) <= limits.offset
                assert abs(new - old) <= limits.rate * CYCLE * (1.0 + 1e-9)
            before = after


def test_double_support_holds_both(design) -> None:
    torso = TorsoControl(design.controller)
    for _ in range(60):
        held = torso.update(0.05, "L")
    assert held[0] > 0.0
    for pitch in pitches(2, 50):
        assert torso.update(pitch, "both") == held


def test_the_new_stance_leg_starts_from_what_it_has_and_the_swing_leg_is_bled_off(design) -> None:
    limits = TorsoLimits()
    torso = TorsoControl(design.controller, limits)
    for _ in range(100):
        last = torso.update(0.05, "L")
    left, right = torso.update(0.05, "R")
    assert left == pytest.approx(last[0] - limits.bleed_rate * CYCLE)
    assert abs(right - last[1]) <= limits.rate * CYCLE * (1.0 + 1e-9)
    for _ in range(40):
        left, right = torso.update(0.05, "R")
    assert left == 0.0
    assert right > 0.0


def test_nothing_of_the_last_stance_comes_back_in_the_next(design) -> None:
    torso = TorsoControl(design.controller)
    for _ in range(100):
        torso.update(0.05, "L")
    for _ in range(300):
        torso.update(0.0, "R")
    for _ in range(20):
        left, _ = torso.update(0.0, "L")
    assert left == pytest.approx(0.0, abs=1e-4)


def test_a_chattering_contact_changes_nothing_much(design) -> None:
    """In and out of double support every cycle: half the integration, and the proportional part only once."""
    steady, chatter = TorsoControl(design.controller, WIDE), TorsoControl(design.controller, WIDE)
    for _ in range(200):
        steady.update(0.02, "L")
        chatter.update(0.02, "L")
    start, _ = steady.update(0.02, "both")
    chatter.update(0.02, "both")
    for k in range(200):
        a, _ = steady.update(0.02, "L")
        b, _ = chatter.update(0.02, "L" if k % 2 else "both")
    assert start < b < a


def test_no_wind_up(design) -> None:
    """A torso held askew for a minute drives the ankle to its limit; it leaves it as soon as it should.

    Without anti-windup the integrator would hold V_i 0.3 rad/s for 60 s, some 30 rad, and need as long to
    return. With it, the correction has changed sign once the reversed error, as large as the first, has had the
    time to integrate twice the limit, and the notch to settle.
    """
    limits = TorsoLimits()
    torso = TorsoControl(design.controller, limits)
    for _ in range(6000):
        left, _ = torso.update(0.3, "L")
    assert left == pytest.approx(limits.offset)
    seconds = 2.0 * limits.offset / (0.3 * design.pi.V_i) + 0.5
    for _ in range(round(seconds / CYCLE)):
        left, _ = torso.update(-0.3, "L")
    assert left < 0.0


def test_lost_samples_hold(design) -> None:
    torso = TorsoControl(design.controller)
    for _ in range(20):
        held = torso.update(0.05, "L")
    assert torso.update(math.nan, "L") == held
    assert torso.update(math.inf, "R") == held


def rotation_y(angle: float) -> np.ndarray:
    """Right-handed rotation about y (pitch of the thesis' (2.4)): turns x towards -z."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def torso_pitch_on_flat_sole(hip: float, knee: float, ankle: float) -> float:
    """AngleY when the sole lies flat: R_torso R_y(hip) R_y(knee) R_y(ankle) = 1."""
    torso = (rotation_y(hip) @ rotation_y(knee) @ rotation_y(ankle)).T
    nose = torso @ np.array([1.0, 0.0, 0.0])
    return math.asin(-nose[2])  # nose down is positive


def test_positive_ankle_pitch_is_toe_down_when_the_foot_is_free() -> None:
    toe = rotation_y(0.2) @ np.array([0.1, 0.0, 0.0])
    assert toe[2] < 0.0


@pytest.mark.parametrize(("hip", "knee", "ankle"), [(0.0, 0.0, 0.0), (-0.5, 1.0, -0.5), (-0.4, 0.7, -0.2)])
def test_a_lean_tips_the_torso_forwards_by_as_much(hip: float, knee: float, ankle: float) -> None:
    before = torso_pitch_on_flat_sole(hip, knee, ankle)
    after = torso_pitch_on_flat_sole(hip, knee, ankle + ankle_pitch_from_lean(0.1))
    assert after - before == pytest.approx(0.1, abs=1e-12)
    assert torso_pitch_on_flat_sole(hip, knee, ankle + 0.1) < before
