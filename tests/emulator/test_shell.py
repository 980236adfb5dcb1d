"""The shell is closed, smooth enough to have an inside, and as large as the published robot."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from bridge.body import BODIES, load_body
from bridge.body.sole import sole_hull
from emulator.engine.shapes import link_shapes
from emulator.shell import ColouredMesh, Section, loft, shell


def volume(part: ColouredMesh) -> float:
    """By the divergence theorem: positive where all faces look outward."""
    a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize("name", BODIES)
def test_every_piece_is_closed_and_its_faces_look_outward(name: str) -> None:
    for link, parts in shell(load_body(name)).items():
        for part in parts:
            edges = Counter((int(f[i]), int(f[(i + 1) % 3])) for f in part.faces for i in range(3))
            assert all(edges[b, a] == n == 1 for (a, b), n in edges.items()), link
            assert volume(part) > 0.0, link


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_loft_of_equal_circles_has_the_volume_of_a_cylinder(axis: int) -> None:
    part = loft(
        axis, [Section(0.0, (0.1, 0.1)), Section(0.5, (0.1, 0.1))], (0, 0, 0), (0.0, 0.0), 2.0, (64, 20)
    )
    assert volume(part) == pytest.approx(np.pi * 0.1**2 * 0.5, rel=0.01)


@pytest.mark.parametrize("name", BODIES)
def test_the_sole_has_the_published_outline_and_limbs_the_published_length(name: str) -> None:
    body = load_body(name)
    parts = shell(body)
    plate = parts["LAnkleRoll"][0].vertices[:-2]
    low = plate[plate[:, 2] < -body.lengths.FootHeight + 1e-9][:, :2]
    assert sorted(map(tuple, low.round(6))) == sorted(map(tuple, sole_hull(body, "L").round(6)))
    thigh = np.vstack([part.vertices for part in parts["LHipPitch"]])
    assert thigh[:, 2].min() == pytest.approx(-body.lengths.ThighLength, abs=0.006)
    assert set(link_shapes(body)) - {"Torso"} <= set(parts)  # what touches the world is seen
