"""Sharing a load among the four cells of a foot."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from bridge.body import load_body
from emulator.engine.pybullet.client import bullet
from emulator.robot import EmulatedRobot
from emulator.sensors.fsr import FootForceSensors

BODY = load_body("nao-v3")
FEET = {"L": BODY.fsr.L, "R": BODY.fsr.R}


def centre(side: str, cells: tuple[float, ...]) -> np.ndarray:
    return np.array(cells) @ np.array(FEET[side])[:, :2] / sum(cells)


@pytest.mark.parametrize("side", ["L", "R"])
@pytest.mark.parametrize("cell", range(4))
def test_a_load_on_one_cell_is_felt_by_it_alone(side: str, cell: int) -> None:
    x, y, _ = FEET[side][cell]
    cells = FootForceSensors(FEET[side]).distribute(10.0, (x, y))
    expected = [0.0] * 4
    expected[cell] = 10.0
    np.testing.assert_allclose(cells, expected, atol=1e-9)


@given(st.floats(0.02, 0.98), st.floats(0.02, 0.98), st.floats(0.1, 60.0), st.sampled_from(["L", "R"]))
def test_inside_the_cells_sum_and_centre_are_exact(u: float, v: float, force: float, side: str) -> None:
    fl, fr, rl, rr = (np.array(place[:2]) for place in FEET[side])
    point = v * (u * fl + (1 - u) * fr) + (1 - v) * (u * rl + (1 - u) * rr)
    cells = FootForceSensors(FEET[side]).distribute(force, (point[0], point[1]))
    assert min(cells) >= 0.0
    assert sum(cells) == pytest.approx(force, rel=1e-9)
    np.testing.assert_allclose(centre(side, cells), point, atol=1e-9)


@pytest.mark.parametrize("point", [(0.02, 0.0), (0.05, 0.02), (-0.025, 0.015), (0.065, -0.02)])
def test_plate_on_equal_springs_stores_the_least_energy(point: tuple[float, float]) -> None:
    places = np.array(FEET["L"])[:, :2]
    found = minimize(
        lambda f: f @ f,
        np.full(4, 2.5),
        bounds=[(0.0, None)] * 4,
        constraints=[
            {"type": "eq", "fun": lambda f: np.array([f.sum() - 10.0, *(f @ places - 10.0 * np.array(point))])}
        ],
        options={"ftol": 1e-14},
    )
    np.testing.assert_allclose(FootForceSensors(FEET["L"]).distribute(10.0, point), found.x, atol=1e-4)


@given(st.floats(-0.1, 0.12), st.floats(-0.06, 0.06))
def test_outside_the_cells_none_pulls_and_the_centre_is_the_nearest_possible(x: float, y: float) -> None:
    cells = FootForceSensors(FEET["L"]).distribute(10.0, (x, y))
    assert min(cells) >= 0.0
    assert sum(cells) == pytest.approx(10.0, rel=1e-9)
    got = float(np.hypot(*(centre("L", cells) - (x, y))))
    places = np.array(FEET["L"])[:, :2]
    weights = np.random.default_rng(0).dirichlet([0.5] * 4, size=300)
    others = np.hypot(*(weights @ places - (x, y)).T)
    assert got <= others.min() + 1e-9


@pytest.mark.parametrize("side", ["L", "R"])
@pytest.mark.parametrize("cell", range(4))
def test_a_peg_under_one_cell_of_the_robot_is_felt_by_that_cell(side: str, cell: int) -> None:
    """The robot hangs in the air, nailed by its torso, and a peg comes up under one cell."""
    with EmulatedRobot(BODY, seed=0, held=True, lift=0.1, settle=0.2) as robot:
        assert robot.frame.fsr == (0.0,) * 8
        model = robot.multibody.model
        state = bullet.getLinkState(
            model.robot, model.feet[side], computeForwardKinematics=True, physicsClientId=model.client
        )
        x, y, _ = FEET[side][cell]
        under = (x, y, -BODY.lengths.FootHeight - 0.0195)
        centre, turn = bullet.multiplyTransforms(state[4], state[5], under, (0.0, 0.0, 0.0, 1.0))
        peg = bullet.createCollisionShape(
            bullet.GEOM_CYLINDER, radius=0.002, height=0.04, physicsClientId=model.client
        )
        bullet.createMultiBody(
            0.0, peg, basePosition=centre, baseOrientation=turn, physicsClientId=model.client
        )
        for _ in range(5):
            robot.advance(None)
        fsr = robot.frame.fsr
        own = fsr[4 * "LR".index(side) + cell]
        assert own > 0.5
        assert own > 0.9 * sum(fsr)
