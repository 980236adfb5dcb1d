"""Units and signs of NAOqi beside those of the contract, in both directions.

| quantity | contract | NAOqi (V3 to V5) | source |
|---|---|---|---|
| force sensors | N | kg: N / 9.81 | confirmed: vendor's page |
| accelerometer x, z | specific force, upright z +9.81 | gravity, upright z -9.81 | confirmed on V5: B-Human |
| accelerometer y | specific force | specific force | confirmed on V5: B-Human, NaoTH |
| gyroscope x, y | right-handed | right-handed | B-Human; UPenn on V4 has both negated: a contradiction |
| gyroscope z | right-handed | negated | confirmed on V5: B-Human, NaoTH; V3 and V4 have none |
| AngleX, AngleY | roll and pitch | the same | assumed |
| joints, stiffness | rad, hands 0 to 1; -1 to 1 | the same | confirmed: vendor's page |

What is confirmed on V5 is assumed for V3 and V4. Each row is its own inverse but the force, so that one table
serves both ways.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from bridge.messages import Vec3

KILOGRAM: Final = 9.81
"""N per kg of a force sensor's reading."""
_ACCELEROMETER: Final = (-1.0, 1.0, -1.0)
_GYROSCOPE: Final = (1.0, 1.0, -1.0)


def accelerometer(reading: Sequence[float]) -> Vec3:
    """Contract to NAOqi and back, m/s^2."""
    return _times(reading, _ACCELEROMETER)


def gyroscope(reading: Sequence[float]) -> Vec3:
    """Contract to NAOqi and back, rad/s."""
    return _times(reading, _GYROSCOPE)


def _times(reading: Sequence[float], signs: Vec3) -> Vec3:
    x, y, z = (value * sign + 0.0 for value, sign in zip(reading, signs, strict=True))  # + 0.0: no -0.0
    return x, y, z
