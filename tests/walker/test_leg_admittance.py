"""The leg admittance against (4.1), (4.4), and what it promises for every force history."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from bridge.config import from_dict
from bridge.errors import ConfigurationError
from walker.estimation.contact import SupportState
from walker.gaits import Plan, SolePose
from walker.gaits.plan import Support
from walker.mechanisms.admittance import LegAdmittance, LegAdmittances, LegParameters

DT = 0.01
POLE = math.pi**2 / 300.0
ANY = st.floats(-1e9, 1e9)


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
        offsets = legs.update(plan(support, progress), SupportState(support, progress), (left, right), DT)
        for old, new, side in zip(before, offsets, "LR", strict=True):
            assert abs(new - old) <= LegParameters().max_rate * DT * (1.0 + 1e-9)
            if support == side:
                assert new == old  # the stance leg keeps its length
        before = offsets


def plan(support: Support, progress: float) -> Plan:
    return Plan(
        phase="DSL",
        support=support,
        progress=progress,
        step=0,
        left=SolePose(0.0, 0.05),
        right=SolePose(0.06, -0.05),
        com=(0.0, 0.0),
        zmp=(0.0, 0.0),
        hip_height=0.215,
    )


def test_a_double_support_passes_the_offset_of_the_landed_foot_to_the_other_leg() -> None:
    """Thesis 3.1: l_HD is constant in double support, and the coming stance leg then has the length l_GH."""
    legs = LegAdmittances(LegParameters(target_depth=0.0), 0.045)
    for k in range(150):  # the right foot meets a plate: 3 N for a while in the second half
        force = 3.0 if 80 <= k < 110 else 0.0
        left, right = legs.update(plan("L", k / 150), SupportState("L", k / 150), (45.0, force), DT)
    found = right - left
    assert left == 0.0 and 0.005 < found < 0.02
    for k in range(201):
        left, right = legs.update(plan("both", k / 200), SupportState("both"), (20.0, 25.0), DT)
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
            offsets = legs.update(plan(stance, k / 100), SupportState(stance, k / 100), tuple(loads), DT)  # type: ignore[arg-type]
        for k in range(101):
            offsets = legs.update(plan("both", k / 100), SupportState("both"), (25.0, 25.0), DT)
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


def test_on_an_obstacle_of_a_centimetre_the_load_stays_near_five_newtons() -> None:
    """R1, figure 4.1; the delay of 4 cycles adds 2.6 N (k v T) to the 5 N for which the damping is laid out."""
    stiff = swing(LegAdmittance(LegParameters(D=1e9, target_depth=0.0)), 0.010, 1000.0)
    assert stiff[-40:] == pytest.approx([10.0] * 40, rel=1e-3)
    leg = LegAdmittance(LegParameters())
    forces = swing(leg, 0.010, 1000.0)
    assert max(forces) < 7.6
    assert max(forces[-50:]) < 3.0
    assert leg.e - leg.depth == pytest.approx(0.010, abs=0.003)


@pytest.mark.parametrize(("ground", "offset"), [(0.0, 0.0), (-0.003, -0.003), (-0.02, -0.005)])
def test_the_foot_reaches_below_the_ground_as_far_as_the_target_does(ground: float, offset: float) -> None:
    leg = LegAdmittance(LegParameters())
    swing(leg, ground, 1000.0)
    assert leg.e - leg.depth == pytest.approx(offset, abs=0.003)


def test_the_load_of_a_foot_that_is_just_leaving_the_ground_does_not_shorten_the_step() -> None:
    leg = LegAdmittance(LegParameters())
    for k in range(75):
        leg.swing(20.0 * max(1.0 - k / 10, 0.0), DT, progress=k / 150)
    assert leg.e == 0.0


def test_noise_below_the_tolerance_moves_nothing() -> None:
    leg = LegAdmittance(LegParameters(target_depth=0.0))
    assert {leg.swing(0.5, DT) for _ in range(500)} == {0.0}


def test_a_spring_without_room_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"k_b = 0\.04 m lies beyond the spring's pole"):
        from_dict({"k_b": 0.04}, "admittance", LegParameters)


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
