"""Requests are clipped to ranges and anti-collision tables."""

import numpy as np
import pytest

from bridge.body import BODIES, joint_tree, load_body
from bridge.body.quantities import COUPLED_TO, coupled_limits
from emulator.servo.limits import RequestLimits


@pytest.mark.parametrize("name", BODIES)
def test_any_request_ends_inside_the_tables(name: str) -> None:
    body = load_body(name)
    joints = tuple(joint_tree(body))
    limits = RequestLimits(body, joints)
    random = np.random.default_rng(0)
    for _ in range(200):
        wild = random.uniform(-3.0, 3.0, len(joints))
        tame = dict(zip(joints, limits.clip(wild).tolist(), strict=True))
        for joint, asked in zip(joints, wild.tolist(), strict=True):
            lower, upper = coupled_limits(body, joint, tame[COUPLED_TO.get(joint, joint)])
            assert tame[joint] == pytest.approx(min(max(asked, lower), upper), abs=1e-12)


# the extreme rows of the vendor's table for the left ankle
@pytest.mark.parametrize(
    ("pitch", "lower", "upper"), [(-1.189442, -0.049916, 0.075049), (0.922755, 0.0, 0.049916)]
)
def test_the_ankle_has_little_room_at_the_ends(pitch: float, lower: float, upper: float) -> None:
    joints = ("LAnklePitch", "LAnkleRoll")
    limits = RequestLimits(load_body("nao-v3"), joints)
    for asked, allowed in ((-1.0, lower), (1.0, upper), (0.02, 0.02)):
        assert limits.clip(np.array([pitch, asked]))[1] == pytest.approx(allowed, abs=3e-4)
