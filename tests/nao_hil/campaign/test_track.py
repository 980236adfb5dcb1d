"""Angles and places from a track, against scipy and closed forms."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bridge.body import load_body
from bridge.rotations import matrix
from nao_hil.experiments.conditions import growth_per_step, soles_in_world, zmp_margin
from nao_hil.runs.track import CHANNELS, PHASES, WIDTH, Track

V3 = load_body("nao-v3")


def track(**channels: object) -> Track:
    """A track with some channels, the others zero."""
    n = max(len(np.atleast_1d(value)) for value in channels.values())  # type: ignore[arg-type]
    rows = np.zeros((n, WIDTH), dtype=np.float32)
    starts = dict(zip(CHANNELS, np.cumsum([0, *CHANNELS.values()]), strict=False))
    rows[:, starts["orientation"] + 3] = 1.0
    for name, value in channels.items():
        rows[:, starts[name] : starts[name] + CHANNELS[name]] = np.reshape(
            np.asarray(value, dtype=np.float32), (n, -1)
        )
    return Track(rows)


def test_roll_pitch_and_tilt_of_a_turned_torso() -> None:
    # Ry(pitch) Rx(roll) with a heading in front of it
    angles = np.array([[0.3, 0.2, 0.1], [1.0, -0.2, 0.15], [-2.0, 0.05, -0.3]])
    turned = Rotation.from_euler("ZYX", angles)
    found = track(orientation=turned.as_quat())
    np.testing.assert_allclose(found.pitch, angles[:, 1], atol=1e-6)
    np.testing.assert_allclose(found.roll, angles[:, 2], atol=1e-6)
    np.testing.assert_allclose(found.tilt, np.arccos(turned.as_matrix()[:, 2, 2]), atol=1e-5)
    np.testing.assert_allclose(matrix(found["orientation"]), turned.as_matrix(), atol=1e-6)


def test_the_margin_is_the_distance_to_the_nearest_edge_of_the_stance_sole() -> None:
    outline = np.array(V3.foot.sole)
    low, high = outline.min(axis=0), outline.max(axis=0)
    yaw = Rotation.from_euler("z", 0.7)
    found = track(
        phase=[PHASES.index("SSL"), PHASES.index("SSR"), PHASES.index("DSL")],
        orientation=np.tile(yaw.as_quat(), (3, 1)),
        torso=np.tile([1.0, 2.0, 0.3], (3, 1)),
    )
    places = []
    for side, off in (("L", (high[0] - 0.02, 0.0)), ("R", (0.0, -(high[1] + 0.005)))):
        sole = soles_in_world(V3, side, found)[0]
        places.append((sole @ np.array([*off, 0.0, 1.0]))[:2])
    margin = zmp_margin(
        track(
            phase=found["phase"], orientation=found["orientation"], torso=found["torso"], zmp=[*places, (0, 0)]
        ),
        V3,
    )
    assert margin[0] == pytest.approx(0.02, abs=1e-5)
    assert margin[1] == pytest.approx(-0.005, abs=1e-5)
    assert math.isnan(margin[2])
    assert low[0] < 0.0 < high[0]


def test_growth_is_the_slope_of_the_means_over_steps() -> None:
    steps = np.repeat([0, 1, 2, 3], 50)
    ripple = np.tile([1.0, -1.0], 100)
    found = track(step=steps)
    assert growth_per_step(found, 0.7 * steps + ripple) == pytest.approx(0.7)
    assert growth_per_step(track(step=[0, 0, 1]), np.zeros(3)) is None
