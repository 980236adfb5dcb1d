"""Admittance of legs and ankles against (4.1) to (4.11), statics, and what it promises for every force."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from bridge.body import load_body
from tests.plans import supported_plan
from walker.estimation.contact import SupportState
from walker.gaits.plan import Support
from walker.mechanisms.admittance import (
    AnkleAdmittance,
    AnkleLimits,
    AnkleParameters,
    LegAdmittance,
    LegAdmittances,
    LegParameters,
    sole_moment,
)

DT = 0.01
POLE = math.pi**2 / 300.0
ANY = st.floats(-1e9, 1e9)


def update(
    legs: LegAdmittances, support: Support, progress: float, forces: tuple[float, ...]
) -> tuple[float, float]:
    """Offsets after a cycle."""
    return legs.update(supported_plan(support, progress), SupportState(support, progress), forces, DT)


def test_the_spring_is_the_curve_of_figure_4_7() -> None:
    """k_a = 1/300, k_b = 0, k_c = 0.5, k_d = 0: pole at 32.9 mm, odd, 0.5 N half-way to the pole."""
    p = LegParameters()
    assert p.pole == pytest.approx(POLE)
    assert 1e3 * p.pole == pytest.approx(32.9, abs=0.05)
    assert p.spring(0.0) == 0.0
    assert p.spring(POLE / 2) == pytest.approx(0.5)
    assert p.spring(-POLE / 2) == pytest.approx(-0.5)
    assert p.spring(0.01) == pytest.approx(0.5 * math.tan(0.01 * 300 / (2 * math.pi)))
    assert p.spring(0.999 * POLE) > 300.0


def test_under_a_constant_force_the_leg_follows_the_differential_equation() -> None:
    """(4.1) integrated by another solver; the implicit step is of first order, so to 2 % at 10 ms."""
    p = LegParameters(force_tolerance=0.0, target_depth=0.0)
    leg = LegAdmittance(p)
    way = solve_ivp(
        lambda _, e: (2.0 - p.spring(e[0])) / p.D, (0.0, 1.0), [0.0], t_eval=[0.2, 0.5, 1.0], rtol=1e-9
    )
    measured = [leg.swing(2.0, DT) for _ in range(100)]
    assert [measured[19], measured[49], measured[99]] == pytest.approx(way.y[0], rel=0.02)


def test_a_force_held_for_ever_ends_where_the_spring_bears_it() -> None:
    p = LegParameters(force_tolerance=0.5, D=20.0)
    leg = LegAdmittance(p)
    for _ in range(5_000):
        leg.swing(5.5, DT)
    assert p.spring(leg.e) == pytest.approx(5.0, rel=1e-6)


@settings(max_examples=150)
@given(
    forces=st.lists(ANY, min_size=1, max_size=60),
    dt=st.floats(1e-4, 0.1),
    D=st.floats(1e-3, 1e4),
    k_b=st.floats(-0.03, 0.03),
    rate=st.floats(0.01, 1e6),
)
def test_the_spring_never_reaches_its_pole(
    forces: list[float], dt: float, D: float, k_b: float, rate: float
) -> None:
    leg = LegAdmittance(LegParameters(D=D, k_b=k_b, max_rate=rate))
    for i, force in enumerate(forces):
        if i % 7 == 3:
            leg.shift(math.copysign(min(abs(force), 1.0), force))
        else:
            leg.swing(force, dt, progress=(0.13 * i) % 1.0, ankle_z=-0.15)
        assert abs(leg.e + k_b) < POLE


@settings(max_examples=150)
@given(
    cycles=st.lists(
        st.tuples(ANY, ANY, st.sampled_from(["L", "R", "both"]), st.floats(0.0, 1.0)), min_size=2, max_size=80
    )
)
def test_the_offsets_change_at_a_bounded_rate_whatever_support_and_progress_do(
    cycles: list[tuple[float, float, Support, float]],
) -> None:
    legs = LegAdmittances(LegParameters(max_ankle_z=0.0), 0.045)
    before = (0.0, 0.0)
    for left, right, support, progress in cycles:
        offsets = update(legs, support, progress, (left, right))
        for old, new, side in zip(before, offsets, "LR", strict=True):
            assert abs(new - old) <= LegParameters().max_rate * DT * (1.0 + 1e-9)
            if support == side:
                assert new == old  # the stance leg keeps its length
        before = offsets


def test_a_double_support_passes_the_offset_of_the_landed_foot_to_the_other_leg() -> None:
    """Thesis 3.1: l_HD is constant in double support, and the coming stance leg then has the length l_GH."""
    legs = LegAdmittances(LegParameters(target_depth=0.0), 0.045)
    for k in range(150):  # the right foot meets a plate: 11 N for a while in the second half
        force = 11.0 if 80 <= k < 110 else 0.0
        left, right = update(legs, "L", k / 150, (45.0, force))
    found = right - left
    assert left == 0.0 and 0.005 < found < 0.02
    for k in range(201):
        left, right = update(legs, "both", k / 200, (20.0, 25.0))
        assert right - left == pytest.approx(found, abs=1e-12)
    assert (left, right) == pytest.approx((-found, 0.0), abs=1e-12)


def test_offsets_do_not_ratchet_over_many_steps() -> None:
    """Each foot lands 2 mm early, as on a robot that tilts to its swing side; the legs stay within that."""
    legs = LegAdmittances(LegParameters(target_depth=0.0), 0.045)
    for step in range(20):
        stance: Support = "L" if step % 2 == 0 else "R"
        side = 1 if stance == "L" else 0
        for k in range(100):
            loads = [45.0, 45.0]
            loads[side] = 2.0 if k >= 90 else 0.0
            offsets = update(legs, stance, k / 100, tuple(loads))
        for k in range(101):
            offsets = update(legs, "both", k / 100, (25.0, 25.0))
        assert offsets[side] == pytest.approx(0.0, abs=1e-12)
        assert abs(offsets[1 - side]) < 0.006


@settings(max_examples=60)
@given(forces=st.lists(ANY, min_size=1, max_size=60), z=st.floats(-0.2, -0.101))
def test_the_leg_is_never_folded_beyond_its_limit(forces: list[float], z: float) -> None:
    leg = LegAdmittance(LegParameters())
    for force in forces:
        assert z + leg.swing(force, DT, ankle_z=z) <= -0.100 + 1e-12


def swing(leg: LegAdmittance, ground: float, stiffness: float, cycles: int = 150) -> list[float]:
    """One swing of the static gait (35 mm, 1.5 s) and 50 cycles of stance. From mid-swing on there is a springy
    floor, whose load the controller sees 4 cycles after it commanded a height. Returns the forces."""
    heights, forces = [], []
    force = 0.0
    for k in range(cycles + 50):
        s = min(k / cycles, 1.0)
        half = 1.0 - abs(2.0 * s - 1.0)
        lifted = 0.035 * half * half * (3.0 - 2.0 * half)
        heights.append(lifted + (leg.swing(force, DT, progress=s) if k < cycles else leg.offset))
        sunk = ground - heights[max(k - 4, 0)] if k >= cycles // 2 else 0.0
        force = stiffness * max(sunk, 0.0)
        forces.append(force)
    return forces


def test_the_force_of_the_first_contact_moves_the_foot_by_half_a_centimetre_at_most() -> None:
    """Thesis 4.1.1: about 70 N, and e stays small; here for 20 ms, within the depth of the target, 5 mm."""
    p = LegParameters(force_tolerance=0.0)
    e = 0.0
    for _ in range(20):  # (4.3) in steps of 1 ms
        e += (70.0 - p.spring(e)) * 1e-3 / p.D
    leg = LegAdmittance(p)
    for _ in range(2):
        leg.swing(70.0, DT, progress=0.5)
    assert 0.004 < leg.e <= 0.005 and leg.e == pytest.approx(e, rel=0.01)


def test_on_an_obstacle_the_load_is_that_of_the_sinking_target() -> None:
    """D v at the foot's 0.065 m/s there, and k v T by the delay of 4 cycles; a stiff leg presses with 50 N."""
    stiff = swing(LegAdmittance(LegParameters(D=1e9, target_depth=0.0)), 0.010, 5000.0)
    assert stiff[-40:] == pytest.approx([50.0] * 40, rel=1e-3)
    leg = LegAdmittance(LegParameters())
    forces = swing(leg, 0.010, 5000.0)
    assert max(forces) < (LegParameters().D + 5000.0 * 0.04) * 0.065
    assert leg.offset == pytest.approx(0.010, abs=0.003)


def test_the_load_of_a_foot_that_is_just_leaving_the_ground_does_not_shorten_the_step() -> None:
    leg = LegAdmittance(LegParameters())
    for k in range(75):
        leg.swing(20.0 * max(1.0 - k / 10, 0.0), DT, progress=k / 150)
    assert leg.e == 0.0


def _ripple(late: float, told: float) -> float:
    """Largest less smallest force, over its mean, of a foot that is pressed onto a stiff floor at 20 mm/s.

    The loop has the parameters' latency and is `late` besides; the admittance is `told` so much of it, s.
    """
    p = LegParameters(force_tolerance=0.0, target_depth=0.0)
    leg, stiffness = LegAdmittance(p), 0.8 * math.pi * p.D / (2.0 * p.latency)  # k < pi D / (2 T) is stable
    offsets = [0.0] * (1 + round((p.latency + late) / DT))
    forces = []
    for n in range(100):
        forces.append(max(stiffness * (0.02 * DT * n - offsets[n]), 0.0))
        offsets.append(leg.swing(forces[-1], DT, delay=told))
    end = forces[-40:]
    return (max(end) - min(end)) * len(end) / sum(end)


@pytest.mark.parametrize("late", [0.02, 0.03])
def test_a_late_loop_rings_unless_the_admittance_knows_of_it(late: float) -> None:
    assert _ripple(0.0, 0.0) < 0.8
    assert _ripple(late, 0.0) > 2.0
    assert _ripple(late, late) < 0.8


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
