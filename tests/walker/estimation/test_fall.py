"""Falls: detected by angle and contact, predicted by the capture point of a rigid robot in the stand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from bridge.body import load_body
from bridge.body.quantities import GRAVITY
from bridge.body.sole import foot_centre
from tests.frames import standing_frame
from tests.states import rigid_state
from walker.estimation.contact import Contacts
from walker.estimation.fall import FallDetector, FallParameters, FallPredictor, FallPredictorParameters
from walker.gaits import gait_parameters, make_gait, standing_plan
from walker.gaits.pose import PoseMaker

BODY = load_body("nao-v6")
GAIT = gait_parameters("omni")
STAND = standing_plan(make_gait("omni", GAIT, BODY))
ANGLES = PoseMaker(BODY, STAND).unlimited_angles(STAND)
P = FallPredictorParameters()
DT = 0.01
OMEGA = math.sqrt(GRAVITY / 0.25)
AHEAD = GAIT.zmp_x - foot_centre(BODY, "L")[0]
"""Of the mass from the middle of the soles, m: the gait puts it there."""
INSIDE = GAIT.l_FA / 2.0 + foot_centre(BODY, "L")[1]
"""Of the mass from the middle of either sole, m."""


def foreseen(ways, support="both", phase="stand", capture=None, plan=STAND):
    """Cycle in which a fall is foreseen; `ways` gives lean, rate and acceleration (rad, rad/s, m/s^2)."""
    foresight, plan = (
        FallPredictor(P),
        replace(plan, support=support, phase=phase, capture=capture),
    )
    for k in range(200):
        lean, rate, (x, y) = ways(k)
        frame = standing_frame(
            k, position=ANGLES, gyroscope=(*rate, 0.0), accelerometer=(x, y, GRAVITY), angle=lean
        )
        if foresight.update(frame, rigid_state(BODY, ANGLES, lean, frame.gyroscope), plan, DT):
            return k
    return None


def pushed(x, y):
    """Accelerated by a push; the torso does not turn yet."""
    return lambda k: ((0.0, 0.0), (0.0, 0.0), (x, y) if k else (0.0, 0.0))


@pytest.mark.parametrize(
    ("acceleration", "support", "way"),
    [
        ((9.0, 0.0), "both", P.capture_ahead - AHEAD),
        ((-9.0, 0.0), "both", P.capture_behind + AHEAD),
        ((0.0, 20.0), "L", P.outside_stance + INSIDE),
        ((0.0, 20.0), "R", P.outside_swing + INSIDE),
        ((0.0, -20.0), "R", P.outside_stance + INSIDE),
        ((0.0, -20.0), "both", P.outside_stance + INSIDE),
    ],
)
def test_a_push_is_seen_by_the_accelerometer_before_the_body_turns(acceleration, support, way):
    """Velocity a T (1 - e^(-t / T)): the time in which the capture point comes by `way` to the bound."""
    a = math.hypot(*acceleration)
    time = -P.acceleration_time * math.log(1.0 - OMEGA * way / (a * P.acceleration_time))
    assert foreseen(pushed(*acceleration), support) == pytest.approx(time / DT, abs=1.6)
    weak = 0.9 * OMEGA * way / P.acceleration_time / a
    assert foreseen(pushed(weak * acceleration[0], weak * acceleration[1]), support) is None


@pytest.mark.parametrize(("acceleration", "way"), [(9.0, P.ahead - AHEAD), (-9.0, P.behind + AHEAD)])
def test_a_stand_of_a_gait_without_capture_steps_has_the_bounds_of_a_walk(acceleration, way):
    time = -P.acceleration_time * math.log(1.0 - OMEGA * way / (abs(acceleration) * P.acceleration_time))
    plan = replace(STAND, pendulum=None)
    assert foreseen(pushed(acceleration, 0.0), plan=plan) == pytest.approx(time / DT, abs=1.6)


def test_a_walk_that_is_pushed_too_hard_is_seen_before_the_capture_point_shows_it():
    """Sum a T (1 - e^(-t / T)) of the accelerometer. In a stand and a step out of one only the bounds count."""
    a = 3.0 * P.push / P.push_time
    time = -P.push_time * math.log(1.0 - 1.0 / 3.0)
    bounds = -P.acceleration_time * math.log(
        1.0 - OMEGA * (P.outside_stance + INSIDE) / (a * P.acceleration_time)
    )
    assert foreseen(pushed(0.0, a), "L", "SSL") == pytest.approx(time / DT, abs=1.6)
    assert foreseen(pushed(0.0, a), "L") == pytest.approx(bounds / DT, abs=1.6)
    assert foreseen(pushed(0.0, a), "L", "SSL", "R") == pytest.approx(bounds / DT, abs=1.6)


def test_a_push_that_the_walk_survives_is_not_taken_for_a_fall():
    a = 0.9 * P.push / P.push_time

    def blow(k):
        return (0.0, 0.0), (0.0, 0.0), (0.0, a if 0 < k * DT <= 0.1 else 0.0)

    assert foreseen(blow, "L", "SSL") is None


def test_a_pendulum_that_falls_from_rest_is_foreseen_before_20_degrees():
    """Exact solution c e^(w t); nothing but its rod bears the mass, so it feels no force across."""
    angle = [0.02 * math.exp(OMEGA * DT * k) for k in range(200)]

    def falls(k):
        return (0.0, angle[k]), (0.0, OMEGA * angle[k]), (0.0, 0.0)

    seen = foreseen(falls)
    down = next(k for k, a in enumerate(angle) if a > math.radians(45.0))
    assert angle[seen] < math.radians(20.0)
    assert (down - seen) * DT > 0.2


def test_a_robot_that_sways_over_its_soles_is_not_taken_for_falling():
    def sways(k):
        a, w = 0.04 * math.sin(6.0 * DT * k), 0.24 * math.cos(6.0 * DT * k)
        return (0.0, a), (0.0, w), (-GRAVITY * math.sin(a), 0.0)

    assert foreseen(sways) is None


BOTH, LEFT, NEITHER = Contacts(True, True), Contacts(True, False), Contacts(False, False)


def test_a_short_flight_is_no_fall() -> None:
    detector = FallDetector(FallParameters(no_support=0.5))
    for _ in range(45):
        assert not detector.update((0.0, 0.0), NEITHER, DT, walking=True)
    assert not detector.update((0.0, 0.0), LEFT, DT, walking=True)
    for _ in range(45):
        assert not detector.update((0.0, 0.0), NEITHER, DT, walking=True)
    causes = [detector.update((0.0, 0.0), NEITHER, DT, walking=True) for _ in range(10)]
    assert "no foot" in causes[-1] and "fall.no_support, 0.5 s" in causes[-1]


def test_a_capture_step_may_lean_farther_before_it_counts_as_a_fall() -> None:
    p = FallParameters()
    leans = 0.5 * (p.angle + p.capture_angle)
    assert "pitched beyond fall.angle, 30 deg" in FallDetector(p).update((0.0, -leans), LEFT, DT, walking=True)
    assert not FallDetector(p).update((0.0, -leans), LEFT, DT, walking=True, capturing=True)
    assert FallDetector(p).update((0.0, -p.capture_angle - 0.01), LEFT, DT, walking=True, capturing=True)
