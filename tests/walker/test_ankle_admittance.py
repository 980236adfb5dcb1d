"""The ankle admittance against (4.6)-(4.11), statics, and its promises."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from bridge.body import load_body
from walker.mechanisms.admittance import (
    AnkleAdmittance,
    AnkleLimits,
    AnkleParameters,
    sole_moment,
    zero_order_hold,
)

DT = 0.01
BODY = load_body("nao-v3")
FREE = AnkleLimits(-3.0, 3.0, -3.0, 3.0)
EXACT = AnkleParameters(relative_force_tolerance=0.0, force_tolerance=0.0, max_rate=100.0)
FORCES = st.lists(st.floats(-10.0, 1e6), min_size=4, max_size=4)


@pytest.mark.parametrize(
    ("cell", "roll", "pitch"),
    [(0, 0.299, -0.7025), (1, -0.231, -0.7025), (2, 0.299, 0.3025), (3, -0.191, 0.2965)],
)
def test_one_loaded_cell_of_the_left_foot_gives_the_moment_of_table_4_1(
    cell: int, roll: float, pitch: float
) -> None:
    """10 N at (x, y) of table 4.1: tau_roll = 10 y, and tau_pitch = -10 x (sign of 4.6b put right)."""
    forces = [0.0] * 4
    forces[cell] = 10.0
    assert sole_moment(forces, BODY.fsr.L) == pytest.approx((roll, pitch))
    r = np.array([*BODY.fsr.L[cell][:2], 0.0])
    assert sole_moment(forces, BODY.fsr.L) == pytest.approx(np.cross(r, [0.0, 0.0, 10.0])[:2])


def test_ground_under_the_toe_lifts_the_toe_and_under_the_left_edge_lifts_that_edge() -> None:
    """Pitch positive is toe down, roll positive is left edge up."""
    for side in ("L", "R"):
        toe, edge = (AnkleAdmittance(AnkleParameters(), BODY, side) for _ in range(2))
        for _ in range(20):
            toe_roll, toe_pitch = toe.update((3.0, 3.0, 0.0, 0.0), "swing", DT, FREE)
            edge_roll, _ = edge.update((3.0, 0.0, 3.0, 0.0), "swing", DT, FREE)
        assert toe_pitch < -0.1
        assert abs(toe_roll) < 0.1 * abs(toe_pitch)
        assert edge_roll > 0.01


def test_euler_poles_of_the_printed_parameters_are_the_checked_ones() -> None:
    """(4.11): 1 - D T_s / M = -0.129 in roll, 0.435 in pitch; (4.11) itself is not what runs here."""
    p = AnkleParameters()
    for M, D, K, printed in (
        (p.M_roll, p.D_roll, p.K_roll, -0.129),
        (p.M_pitch, p.D_pitch, p.K_pitch, 0.435),
    ):
        euler = np.array([[1.0, DT], [-K / M * DT, 1.0 - D / M * DT]])
        assert euler[1, 1] == pytest.approx(printed, abs=5e-4)
        assert np.abs(np.linalg.eigvals(euler)).max() < 1.0
        # The exact step has the poles exp(lambda T_s) of (4.9), never negative.
        (aa, av, _), (va, vv, _) = zero_order_hold(M, D, K, DT)
        exact = np.exp(np.roots([M, D, K]) * DT)
        assert sorted(np.linalg.eigvals([[aa, av], [va, vv]])) == pytest.approx(sorted(exact), rel=1e-9)


def test_the_angle_follows_the_differential_equation_for_any_cycle_time() -> None:
    """(4.9) integrated by another solver, for 2 N on the front left cell."""
    p = EXACT
    forces = (2.0, 0.0, 0.0, 0.0)
    tau = (2.0 * 0.0299, -2.0 * 0.07025)
    for axis, (M, D, K) in enumerate(((p.M_roll, p.D_roll, p.K_roll), (p.M_pitch, p.D_pitch, p.K_pitch))):
        way = solve_ivp(
            lambda _, s, M=M, D=D, K=K, t=tau[axis]: [s[1], (t - D * s[1] - K * s[0]) / M],
            (0.0, 0.6),
            [0.0, 0.0],
            rtol=1e-10,
            atol=1e-12,
        )
        for dt in (0.01, 0.02, 0.1):
            ankle = AnkleAdmittance(p, BODY, "L")
            for _ in range(round(0.6 / dt)):
                offsets = ankle.update(forces, "swing", dt, FREE)
            assert offsets[axis] == pytest.approx(way.y[0][-1], rel=1e-6)


def test_small_differences_between_the_cells_do_not_tilt_the_foot() -> None:
    """Every reading up to 20 % off a load that has no moment about the ankle."""
    places = np.array(BODY.fsr.L)[:, :2]
    level = np.array([1.0, 1.0, 0.0, 0.0])
    rear = np.linalg.solve(-places[2:].T, places[:2].sum(axis=0))  # makes both moments zero
    level[2:] = rear
    assert np.all(level > 0.0)
    assert sole_moment(level, BODY.fsr.L) == pytest.approx((0.0, 0.0), abs=1e-12)
    for corner in range(16):
        # A cell that reads r shows between 0.8 r and 1.2 r of the truth, so the band is laid about r.
        signs = np.array([1.0 if corner >> i & 1 else -1.0 for i in range(4)])
        ankle = AnkleAdmittance(AnkleParameters(), BODY, "L")
        reading = 3.0 * level / (1.0 - 0.199 * signs)
        for _ in range(50):
            assert ankle.update(reading, "swing", DT, FREE) == (0.0, 0.0)


def test_a_real_tilt_is_heard() -> None:
    ankle = AnkleAdmittance(AnkleParameters(), BODY, "L")
    roll, pitch = ankle.moment((0.0, 0.0, 2.0, 2.0))
    true_roll, true_pitch = sole_moment((0.0, 0.0, 2.0, 2.0), BODY.fsr.L)
    assert 0.5 * true_pitch < pitch < true_pitch
    assert 0.0 <= roll <= true_roll


@settings(max_examples=150)
@given(
    cycles=st.lists(
        st.tuples(
            FORCES,
            st.sampled_from(["swing", "stance"]),
            st.floats(0.0, 1.0),
            st.tuples(st.floats(-0.5, 0.5), st.floats(0.0, 0.5), st.floats(-1.0, 1.0), st.floats(0.0, 1.0)),
        ),
        min_size=1,
        max_size=50,
    )
)
def test_the_offsets_stay_inside_the_limits_whatever_they_are(
    cycles: list[tuple[list[float], str, float, tuple[float, float, float, float]]],
) -> None:
    ankle = AnkleAdmittance(AnkleParameters(), BODY, "R")
    for forces, role, progress, (r, dr, q, dq) in cycles:
        limits = AnkleLimits(r, r + dr, q, q + dq)
        roll, pitch = ankle.update(forces, role, DT, limits, progress=progress)  # type: ignore[arg-type]
        assert limits.roll_lower <= roll <= limits.roll_upper
        assert limits.pitch_lower <= pitch <= limits.pitch_upper


@settings(max_examples=150)
@given(
    cycles=st.lists(
        st.tuples(FORCES, st.sampled_from(["swing", "stance"]), st.floats(0.0, 1.0)), min_size=1, max_size=60
    )
)
def test_the_offsets_change_at_a_bounded_rate_whatever_role_and_progress_do(
    cycles: list[tuple[list[float], str, float]],
) -> None:
    limits = AnkleLimits(-0.3, 0.3, -0.6, 0.6)
    ankle = AnkleAdmittance(AnkleParameters(), BODY, "L")
    before = (0.0, 0.0)
    for forces, role, progress in cycles:
        offsets = ankle.update(forces, role, DT, limits, progress=progress)  # type: ignore[arg-type]
        for old, new in zip(before, offsets, strict=True):
            assert abs(new - old) <= AnkleParameters().max_rate * DT * (1.0 + 1e-9)
        if role == "stance":
            assert offsets == before
        before = offsets


def test_a_tilt_is_held_through_stance_and_decays_in_swing_with_its_own_spring() -> None:
    """Thesis 4.1.2 names no release: a free foot without load returns with D / K, 2.5 s in pitch."""
    p = AnkleParameters()
    ankle = AnkleAdmittance(p, BODY, "L")
    for _ in range(10):
        tilted = ankle.update((4.0, 4.0, 0.0, 0.0), "swing", DT, FREE)
    for _ in range(100):
        assert ankle.update((10.0, 1.0, 8.0, 0.0), "stance", DT, FREE) == tilted
    for _ in range(60):
        left = ankle.update((0.0,) * 4, "swing", DT, FREE)
    assert left[1] == pytest.approx(tilted[1] * math.exp(-0.6 * p.K_pitch / p.D_pitch), rel=0.03)


def test_before_its_start_in_the_swing_the_admittance_holds() -> None:
    ankle = AnkleAdmittance(AnkleParameters(start=0.5), BODY, "L")
    for k in range(50):
        assert ankle.update((5.0, 0.0, 0.0, 0.0), "swing", DT, FREE, progress=k / 100) == (0.0, 0.0)
    assert ankle.update((5.0, 0.0, 0.0, 0.0), "swing", DT, FREE, progress=0.5) != (0.0, 0.0)


def test_a_foot_that_meets_a_slope_turns_until_it_lies_on_it() -> None:
    """A pad under each cell on a plane that rises 5 degrees forwards; the foot sinks until 2 N rest on it, and
    the readings come four cycles late. At rest the moment is inside the dead band."""
    slope, stiffness = math.radians(5.0), 200.0
    ankle = AnkleAdmittance(AnkleParameters(), BODY, "L")
    places = np.array(BODY.fsr.L)
    pitches = [0.0] * 5
    for k in range(200):
        depth = 0.0002 * min(k, 30) - 0.0035
        pitch = pitches[-5]
        heights = -places[:, 0] * math.sin(pitch) - depth
        forces = stiffness * np.maximum(places[:, 0] * math.tan(slope) - heights, 0.0)
        pitches.append(ankle.update(tuple(forces), "swing", DT, FREE)[1])
    assert pitches[-1] == pytest.approx(-slope, abs=math.radians(1.0))
