"""Soles in PyBullet: a bed of springs at four points of the outline and four of a pad in the middle.

PyBullet gives a flat hull four contact points on its outline, each a spring with Coulomb friction once it has
a stiffness. Alone they would resist tilting three times, and turning on the spot 1.6 times as much as a patch
with even pressure. So most of the bed is put under a small pad flush with the sole: together they sink and turn
as the patch does. Known weaknesses: which points of the outline carry, PyBullet chooses, with an error of depth
of some 20 um, so that the stiffness against tilting is off by up to 40 %; and a sole on its rim sinks by
springs in a few points, not along a line.
"""

from __future__ import annotations

from emulator.engine.pybullet.client import bullet
from emulator.engine.pybullet.model import BulletModel
from emulator.engine.shapes import OUTER_SHARE, PATCH_RADIUS
from emulator.engine.values import Surface

_POINTS = 4
"""Contact points that PyBullet keeps of a hull or a box on a plane."""


def soften_soles(robot: BulletModel, surface: Surface) -> None:
    """Give both soles the springs of a surface.

    PyBullet multiplies the coefficient against turning by the floor's friction: it is a length here.

    Args:
        robot: With soles and pads.
        surface: Under it.
    """
    stiffness = surface.stiffness_per_area * robot.sole_area / _POINTS
    shares = ((robot.feet, OUTER_SHARE), (robot.pads, 1.0 - OUTER_SHARE))
    for links, share in shares:
        for link in links.values():
            bullet.changeDynamics(
                robot.robot,
                link,
                contactStiffness=share * stiffness,
                contactDamping=share * stiffness * surface.relaxation,
                spinningFriction=PATCH_RADIUS,
                physicsClientId=robot.client,
            )
