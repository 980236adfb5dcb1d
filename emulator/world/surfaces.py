"""Surfaces that a scenario can give its floor.

No figure of a NAO's soles on a floor is published. The stiffness of the hard floor is calibrated with the
drives on the torso step (2.5e7 to 6e7 N/m^3 agree); all else is assumed: the friction as usual for hard rubber
on dry wood and on short pile, a carpet that sinks by half a millimetre under one sole (47 N on 0.0133 m^2),
artificial turf, 8 mm high and filled, that sinks by a whole one, and a relaxation that lets a landing foot
hardly rebound.
"""

from __future__ import annotations

from typing import Final

from emulator.engine.values import Surface

WOOD: Final = Surface(friction=0.8, stiffness_per_area=4.0e7, relaxation=0.005)
"""The emulator's own: a hard floor."""
SURFACES: Final = {
    "wood": WOOD,
    "carpet": Surface(friction=0.9, stiffness_per_area=0.7e7, relaxation=0.010),
    "turf": Surface(friction=0.7, stiffness_per_area=0.3e7, relaxation=0.015),
}
"""By the name that a scenario uses."""
