"""The sway from rest into the first cycle, and from the last one to rest; the source gives neither for y."""

from __future__ import annotations

from typing import Final

import numpy as np

from walker.functions import LinearPendulum, MotionState
from walker.planning.huang.parameters import HuangParameters
from walker.planning.huang.spline import Cubic, even, joined

_TRIES: Final = 61
_REST: Final = MotionState(0.0, 0.0, 0.0)


def sway(p: HuangParameters, cycle: MotionState, height: float) -> tuple[Cubic, Cubic]:
    """Y of the hip, towards the front foot of the cycle: from rest to its beginning, and from there to rest.

    The splines' middle points are those with which the zero moment point of the pendulum (3.4) stays nearest to
    the middle between the feet: the margin principle again, as both soles are flat.

    Args:
        p: of the gait.
        cycle: state at the beginning of a cycle.
        height: of the centre of mass, m.
    """
    times = (0.0, 0.5 * p.T_start, p.T_start)
    moments = even(0.0, p.T_start, 61)
    pendulum, found = LinearPendulum(height), []
    for begin, end in ((_REST, cycle), (cycle, _REST)):
        tries = [joined(times, begin, middle, end) for middle in np.linspace(-p.l_FA, p.l_FA, _TRIES)]
        furthest = []
        for spline in tries:
            y, _, acceleration = spline.sample(moments)
            furthest.append(float(np.abs(pendulum.zmp(y, acceleration)).max()))
        found.append(tries[int(np.argmin(furthest))])
    return found[0], found[1]
