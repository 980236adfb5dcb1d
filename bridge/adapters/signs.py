"""Signs and units of each robot's sensors against the contract's: LoLA's packets, NAOqi's memory.

| quantity | contract | LoLA (V6) | NAOqi (V3 to V5) |
|---|---|---|---|
| accelerometer | specific force, upright z +9.81 m/s^2 | x, y, z negated (1) | x, z negated, y the same (2) |
| gyroscope | right-handed, rad/s | the same (3) | x, y the same (4), z negated (2); V3 and V4 have no z |
| torso angle | roll, pitch, rad | the same (1) | the same (assumed) |
| force sensors | N | kg: N / 9.81 (5) | kg: N / 9.81 (5) |
| joints, stiffness | rad, hands 0 to 1; -1 to 1 | the same (5) | the same (5) |
| battery | charge, current, status, temperature | charge, status, current, temperature (1) | a key each |
| motor status | not in the frame | by motor temperature (assumed) | by motor temperature (assumed) |

Sources, confirmed: (1) captured packets of two V6; the vendor's page has another order of the battery;
(2) B-Human on V5, of the gyroscope's z and the accelerometer's y also NaoTH; V3 and V4 are assumed to be the
same; (3) NaoTH's converter; (5) the vendor's pages. (4) is a contradiction: this is B-Human's, UPenn has both
negated on a V4.

Each sign is its own inverse: the same factors serve both directions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from bridge.types import Vec3

KILOGRAM: Final = 9.81
"""N per kg of a force sensor's reading."""
_STATUS_FROM: Final = (85.0, 90.0, 100.0)
"""Degrees Celsius from which a motor's status is 1 (limit reached), 2 (very hot), 3 (critical);
assumed, the same as of the emulated drives."""


@dataclass(frozen=True, slots=True)
class SensorSigns:
    """Factors of a robot's inertial sensors against the contract's, by axis x, y, z."""

    accelerometer: Vec3
    gyroscope: Vec3


LOLA: Final = SensorSigns(accelerometer=(-1.0, -1.0, -1.0), gyroscope=(1.0, 1.0, 1.0))
NAOQI: Final = SensorSigns(accelerometer=(-1.0, 1.0, -1.0), gyroscope=(1.0, 1.0, -1.0))


def with_signs(reading: Sequence[float], signs: Vec3) -> Vec3:
    """A reading with a robot's signs, from the contract or to it.

    Args:
        reading: along x, y, z.
        signs: factors by axis, of `LOLA` or `NAOQI`.
    """
    x, y, z = (value * sign + 0.0 for value, sign in zip(reading, signs, strict=True))  # + 0.0: no -0.0
    return x, y, z


def motor_status(temperature: float) -> int:
    """Status of a motor of this temperature (degrees Celsius), 0 to 3."""
    return sum(temperature >= limit for limit in _STATUS_FROM)
