"""Surfaces that a scenario can give its floor.

No figure of a NAO's soles on a floor is published. All values are assumed: the friction as usual for hard
rubber on dry wood and on short pile; the stiffness per area so that under the weight of a NAO on one sole (47 N
on 0.0133 m^2) the sole and its force sensors sink by 0.06 mm on wood, a carpet's pile by half a millimetre, and
that of artificial turf, 8 mm high and filled, by a whole one; the relaxation so that a landing foot hardly
rebounds. Above 4e7 N/m^3 walks no longer depend on the stiffness; at 2e7 and 3 ms the dynamic gait on ideal
drives falls without its controllers.
"""

from __future__ import annotations

from typing import Final

from emulator.engine.values import Surface

WOOD: Final = Surface(friction=0.8, stiffness_per_area=6.0e7, relaxation=0.005)
"""The emulator's own: a hard floor."""
SURFACES: Final = {
    "wood": WOOD,
    "carpet": Surface(friction=0.9, stiffness_per_area=0.7e7, relaxation=0.010),
    "turf": Surface(friction=0.7, stiffness_per_area=0.3e7, relaxation=0.015),
}
"""By the name that a scenario uses."""
