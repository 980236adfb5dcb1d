"""Support polygon against Qhull and closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from bridge.datasheet import BODIES, load_body
from bridge.datasheet.sole import foot_centre, sole_outline
from walker.errors import NoSupportError
from walker.kinematics.transforms import homogeneous, rotation
from walker.support_polygon import Soles, SupportPolygon, convex_hull, sole_rectangle

V3 = load_body("nao-v3")
SQUARE = SupportPolygon(convex_hull([(0, 0), (2, 0), (2, 1), (0, 1)]))


def standing(x, y, yaw=0.0, height=V3.lengths.FootHeight):
    return homogeneous(rotation(0.0, 0.0, yaw), [x, y, height])


def polygon_area(corners):
    x, y = np.array(corners).T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


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
    with pytest.raises(NoSupportError, match="at least one contact"):
        convex_hull([])
    with pytest.raises(NoSupportError):
        Soles(V3).support({})
    with pytest.raises(ValueError, match="not finite"):
        convex_hull([(0.0, 0.0), (math.nan, 1.0), (1.0, 1.0)])
    with pytest.raises(ValueError, match="not finite"):
        SQUARE.margin((math.nan, 0.0))


COORDINATE = st.floats(-1.0, 1.0) | st.sampled_from([0.0, 0.1, -0.1, 1.0])
POINTS = st.lists(st.tuples(COORDINATE, COORDINATE), min_size=1, max_size=12)


@settings(deadline=None)
@given(points=POINTS, weights=st.lists(st.floats(0.0, 1.0), min_size=12, max_size=12))
def test_mixtures_of_the_contacts_are_never_outside(points, weights):
    polygon = SupportPolygon(convex_hull(points))
    assert set(polygon.corners) <= set(points)
    share = np.array(weights[: len(points)]) + 1e-3
    assert polygon.margin(share @ np.array(points) / share.sum()) >= -1e-9


@settings(deadline=None)
@given(points=POINTS, point=st.tuples(COORDINATE, COORDINATE))
def test_margin_falls_by_no_more_than_the_way(points, point):
    # A signed distance changes by at most the distance that the point moves.
    polygon = SupportPolygon(convex_hull(points))
    moved = (point[0] + 0.3, point[1] - 0.4)
    assert abs(polygon.margin(moved) - polygon.margin(point)) <= 0.5 + 1e-9


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("side", ["L", "R"])
def test_the_thesis_rectangle_is_centred_at_fm_and_smaller_than_the_sole(name, side):
    body = load_body(name)
    rectangle = sole_rectangle(body, side)
    # FM is for the thesis' (mirrored) sensor places; other bodies' right rear pair is 0.6 mm off.
    assert rectangle.mean(axis=0) == pytest.approx(foot_centre(body, side), abs=0.4e-3)
    sole = SupportPolygon(convex_hull(sole_outline(body, side)))
    assert min(sole.margin(corner) for corner in rectangle) > 0.0
    # Sensors of table 4.1: 100.5 mm from front to rear, 53 mm from side to side.
    assert np.ptp(rectangle, axis=0) == pytest.approx([0.1005, 0.053], abs=0.7e-3)


def test_single_support_is_the_sole_where_the_foot_stands():
    soles = Soles(V3, "rectangle")
    x, y, yaw = 0.3, -0.2, math.pi / 2
    polygon = soles.support({"L": standing(x, y, yaw)})
    # Turned by 90 degrees: a point (a, b) of the foot is at (x - b, y + a).
    expected = {(round(x - b, 9), round(y + a, 9)) for a, b in sole_rectangle(V3, "L").tolist()}
    assert {(round(a, 9), round(b, 9)) for a, b in polygon.corners} == expected
    centre = foot_centre(V3, "L")
    assert polygon.margin((x - centre[1], y + centre[0])) == pytest.approx(0.0265, abs=1e-12)


def test_double_support_of_parallel_feet_has_the_closed_form_area():
    # Two equal rectangles shifted by (s, w): length b, width c each; hull = b (w + c) + s c, for 0 <= s.
    soles, s, w = Soles(V3, "rectangle"), 0.04, 0.1
    left, right = sole_rectangle(V3, "L"), sole_rectangle(V3, "R")
    b, c = np.ptp(left, axis=0)
    gap = left.mean(axis=0)[1] - right.mean(axis=0)[1]
    polygon = soles.support({"L": standing(0.0, w / 2), "R": standing(s, -w / 2)})
    assert len(polygon.corners) == 6
    assert polygon_area(polygon.corners) == pytest.approx(b * (w + gap + c) + s * c, rel=1e-12)
    middle = (0.02 + s / 2, 0.0)
    assert polygon.margin(middle) > 0.04
    assert soles.support({"L": standing(0.0, w / 2)}).margin(middle) < 0.0


@pytest.mark.parametrize("name", BODIES)
def test_the_outline_bears_more_than_the_rectangle(name):
    body = load_body(name)
    feet = {"L": standing(0.0, 0.05), "R": standing(0.05, -0.05)}
    whole, small = Soles(body).support(feet), Soles(body, "rectangle").support(feet)
    assert all(whole.margin(corner) > 0.0 for corner in small.corners)
    # Published outline: the sole reaches 99.4 mm before the ankle and 50.7 mm behind it.
    x = np.array(whole.corners)[:, 0]
    assert x.max() == pytest.approx(0.05 + 0.09942, abs=1e-5)
    assert x.min() == pytest.approx(-0.05072, abs=1e-5)
