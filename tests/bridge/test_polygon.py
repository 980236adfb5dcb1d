"""Support polygon against Qhull and closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from bridge.polygon import SupportPolygon, convex_hull

SQUARE = SupportPolygon(convex_hull([(0, 0), (2, 0), (2, 1), (0, 1)]))


@pytest.mark.parametrize("n", [3, 4, 10, 200])
def test_hull_is_qhulls(n):
    rng = np.random.default_rng(31)
    for _ in range(50):
        points = rng.normal(size=(n, 2))
        expected = points[ConvexHull(points).vertices]
        got = np.array(convex_hull(points))
        start = np.argmin(np.abs(expected - got[0]).sum(axis=1))
        assert np.array_equal(got, np.roll(expected, -start, axis=0))


def test_margin_is_the_distance_to_qhulls_edges():
    # Qhull's facet equations n . x + b <= 0: inside, the largest of them is minus the margin.
    rng = np.random.default_rng(32)
    for _ in range(50):
        points = rng.normal(size=(12, 2))
        hull, polygon = ConvexHull(points), SupportPolygon(convex_hull(points))
        for point in points[rng.integers(0, 12, 20)] * rng.uniform(0.0, 1.5, (20, 1)):
            signed = (hull.equations[:, :2] @ point + hull.equations[:, 2]).max()
            if signed < 0.0:
                assert polygon.margin(point) == pytest.approx(-signed, abs=1e-12)
            else:
                # Outside it is at least the distance to the farthest line, more beyond a corner.
                assert polygon.margin(point) <= -signed + 1e-12


@pytest.mark.parametrize(
    ("point", "margin"),
    [
        ((1.0, 0.5), 0.5),
        ((0.25, 0.5), 0.25),
        ((1.9, 0.3), 0.1),
        ((2.0, 0.5), 0.0),
        ((0.0, 0.0), 0.0),
        ((2.5, 0.5), -0.5),
        ((1.0, -3.0), -3.0),
        ((5.0, 5.0), -5.0),
        ((-3.0, -4.0), -5.0),
    ],
)
def test_margin_in_a_rectangle(point, margin):
    assert SQUARE.margin(point) == pytest.approx(margin, abs=1e-15)


def test_a_point_and_a_line_have_no_inside():
    point = SupportPolygon(convex_hull([(1.0, 1.0)] * 3))
    assert point.corners == ((1.0, 1.0),)
    assert point.margin((1.0, 1.0)) == 0.0
    assert point.margin((4.0, 5.0)) == -5.0
    line = SupportPolygon(convex_hull([(0.0, 0.0), (2.0, 2.0), (1.0, 1.0), (0.5, 0.5)]))
    assert line.corners == ((0.0, 0.0), (2.0, 2.0))
    assert line.margin((1.0, 1.0)) == 0.0
    assert line.margin((2.0, 0.0)) == pytest.approx(-math.sqrt(2.0))
    assert line.margin((3.0, 2.0)) == -1.0


def test_no_contact_and_contacts_that_are_no_numbers_are_refused():
    with pytest.raises(ValueError, match="at least one contact"):
        convex_hull([])
    with pytest.raises(ValueError, match="not finite"):
        convex_hull([(0.0, 0.0), (math.nan, 1.0), (1.0, 1.0)])
    with pytest.raises(ValueError, match="not finite"):
        SQUARE.margin((math.nan, 0.0))


COORDINATE = st.floats(-1.0, 1.0) | st.sampled_from([0.0, 0.1, -0.1, 1.0])
POINTS = st.lists(st.tuples(COORDINATE, COORDINATE), min_size=1, max_size=12)


@given(points=POINTS, weights=st.lists(st.floats(0.0, 1.0), min_size=12, max_size=12))
def test_mixtures_of_the_contacts_are_never_outside(points, weights):
    polygon = SupportPolygon(convex_hull(points))
    assert set(polygon.corners) <= set(points)
    weight = np.array(weights[: len(points)]) + 1e-3
    assert polygon.margin(weight @ np.array(points) / weight.sum()) >= -1e-9


@given(points=POINTS, point=st.tuples(COORDINATE, COORDINATE))
def test_margin_falls_by_no_more_than_the_way(points, point):
    # A signed distance changes by at most the distance that the point moves.
    polygon = SupportPolygon(convex_hull(points))
    moved = (point[0] + 0.3, point[1] - 0.4)
    assert abs(polygon.margin(moved) - polygon.margin(point)) <= 0.5 + 1e-9
