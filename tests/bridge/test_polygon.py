"""Support polygon against Qhull and closed forms."""

import math

import numpy as np
import pytest
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
