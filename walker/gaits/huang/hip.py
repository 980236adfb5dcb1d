"""The motion of the hip: x by (8), (9), z by (7), and y by the same means, from rest, through cycles, to rest.

Time of a cycle counts from the beginning of double support; the rear foot is at x = 0, the front foot, the next
stance foot, at D_s, and y is positive towards the front foot. The source walks in the plane.
Sideways the hip has three knots: `y_d` off the path at both ends of single support, `y_m` in its middle, and
every cycle is the mirror image of the one before. The source gives no motion from rest and to rest for y.

The printed closed form (10) violates its own conditions (8), (9); the periodic spline on x_h - (D_s / T_c) t
satisfies them. The middle of single support is T_d + (T_c - T_d) / 2, not the (T_c - T_d) / 2 printed in (7).

The knots are named by the parameters, or scaled from the shipped plan of the body. `nao-hil plan --robot BODY
--out DIR` searches a plan; `plans/BODY.toml` is the `config.toml` that it writes for the shipped parameters.
x_sd and x_ed scale with the length of a step, as bound (11) does, and y_d and y_m with the distance of the
feet. With steps of up to 50 mm the scaled motion has the margin of a searched one (within 0.2 mm on a nao-v3
and a nao-v6); at 70 mm it has 2 to 3 mm less, at 80 mm 4 to 7 mm. Other changed parameters keep the motion;
`nao-hil plan --set` searches one for them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

import msgspec
import numpy as np

from bridge.body import Body
from bridge.config import load_toml
from walker.functions import LinearPendulum, MotionState, quintic
from walker.gaits.huang.foot import Placement
from walker.gaits.huang.parameters import HuangParameters, refuse
from walker.gaits.huang.spline import Cubic, even, joined, periodic


class Choice(NamedTuple):
    """Hip at the ends of single support and, sideways, in its middle, m; see `HuangParameters`."""

    x_sd: float
    x_ed: float
    y_d: float
    y_m: float


def hip_x(p: HuangParameters, x_sd: float, x_ed: float) -> Cubic:
    """X less the even motion D_s / T_c t, periodic (8), (9)."""
    mean = p.D_s / p.T_c
    values = (x_ed, p.D_s - x_sd - mean * p.T_d, x_ed)
    return periodic((0.0, p.T_d, p.T_c), [p.x_0 + value for value in values])


def hip_y(p: HuangParameters, y_d: float, y_m: float) -> Cubic:
    """y, antiperiodic."""
    return periodic((0.0, p.T_d, 0.5 * (p.T_c + p.T_d), p.T_c), (-y_d, y_d, y_m, y_d), sign=-1.0)


def hip_z(p: HuangParameters) -> Cubic:
    """Height of the hip joints (7), from the middle of double support to that of the next one."""
    times = (0.5 * p.T_d, 0.5 * (p.T_c + p.T_d), p.T_c + 0.5 * p.T_d)
    return periodic(times, (p.H_min, p.H_max, p.H_min))


def ends_of_cycle(p: HuangParameters, choice: Choice) -> tuple[MotionState, MotionState]:
    """X and y at the beginning of a cycle: where the phases from and to rest join on."""
    x = hip_x(p, choice.x_sd, choice.x_ed).at(0.0)
    return MotionState(x.position, x.velocity + p.D_s / p.T_c, x.acceleration), hip_y(
        p, choice.y_d, choice.y_m
    ).at(0.0)


PLANS: Final = Path(__file__).parent / "plans"


class ShippedPlan(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A plan with all parameters of its search."""

    robot: str
    gait: str
    parameters: HuangParameters


def choice_of(p: HuangParameters, body: Body) -> Choice:
    """Places of the hip at the ends and in the middle of single support.

    Args:
        p: parameters; the numbers that they name are taken as they are.
        body: data sheet.

    Raises:
        ConfigurationError: the parameters leave a number open and no plan is shipped for this body.
    """
    if p.x_sd is not None and p.x_ed is not None and p.y_d is not None and p.y_m is not None:
        return Choice(p.x_sd, p.x_ed, p.y_d, p.y_m)
    file = PLANS / f"{body.name}.toml"
    if not file.exists():
        refuse(
            f"no plan is shipped for a {body.name}; search one with `nao-hil plan --out plan` and the same "
            "--robot, and walk with --config plan/config.toml"
        )
    planned = load_toml(file, ShippedPlan).parameters
    along, across = p.D_s / planned.D_s, p.l_FA / planned.l_FA
    return Choice(
        *(
            scale * getattr(planned, name) if getattr(p, name) is None else getattr(p, name)
            for name, scale in (("x_sd", along), ("x_ed", along), ("y_d", across), ("y_m", across))
        )
    )


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


@dataclass(frozen=True)
class Piece:
    """The hip over a start, a cycle or a stop; time counts from its beginning."""

    duration: float
    """Duration of the half cycle, s."""
    x: Cubic
    y: Cubic
    z: tuple[tuple[float, Cubic], ...]
    """Heights over the ground, m, each with the time from which it holds, s."""
    ground: tuple[float, float]
    """Height of the patch under the hip before and after, m."""
    rise: float
    """Time in which it changes over, s."""
    slope: float
    """Slope of the floor, rad."""

    def hip(self, t: float) -> tuple[float, float, float]:
        """Middle between the hip joints, walk frame, m; also a little before and after the piece."""
        x, y = self.x.at(t).position, self.y.at(t).position
        height = next(spline for begin, spline in reversed(self.z) if begin <= t)
        ground = quintic(*self.ground, self.rise, t).position - math.tan(self.slope) * x
        return x, y, height.at(t).position + ground

    @property
    def level(self) -> float:
        """Height of the patch at its end, m."""
        return self.ground[1]


class Pieces:
    """Makes the pieces of a configuration.

    Args:
        p: of the gait.
        choice: of the search.
        rest: x of the hip at rest, from the ankles, m.
        height: of the centre of mass, m.
    """

    def __init__(self, p: HuangParameters, choice: Choice, rest: float, height: float) -> None:
        self._p, self._choice, self._rest = p, choice, rest
        self._end_x, end_y = ends_of_cycle(p, choice)
        self._y, self._z = hip_y(p, choice.y_d, choice.y_m), hip_z(p)
        self._start, self._stop = sway(p, end_y, height)
        self._half = 0.5 * (p.T_c + p.T_d)

    def stand(self, x: float, level: float) -> Piece:
        """At rest with the ankles at x."""
        return self._still(x, _rest(0.0), (level, level))

    def start(self, x: float, level: float, side: float) -> Piece:
        """From rest with the ankles at x to a first cycle on the left (1) or right (-1) foot."""
        return self._still(x, _mirrored(self._start, side), (level, level))

    def stop(self, x: float, levels: tuple[float, float], side: float) -> Piece:
        """To rest with the ankles at x, in place of a cycle on the left (1) or right (-1) foot."""
        return self._still(x, _mirrored(self._stop, side), levels)

    def cycle(
        self, feet: tuple[Placement, Placement, Placement], levels: tuple[float, float], side: float
    ) -> Piece:
        """A cycle.

        Steps of another length than D_s scale the ends of the hip's motion (8) and their derivatives; they join
        where the steps do.

        Args:
            feet: lift-off of the swing foot, the stance foot, landing of the swing foot.
            levels: height of the ground below the last stance foot and below this one, m.
            side: 1 on the left foot, -1 on the right one.
        """
        p, (rear, stance, landing) = self._p, feet
        before, after = (stance.x - rear.x) / p.D_s, (landing.x - stance.x) / p.D_s
        middle = stance.x + self._rest + before * (p.x_0 - self._choice.x_sd - self._rest)
        return Piece(
            p.T_c,
            joined((0.0, p.T_d, p.T_c), self._between(rear.x, before), middle, self._between(stance.x, after)),
            _mirrored(self._y, side),
            self._heights(from_rest=before == 0.0, to_rest=after == 0.0),
            levels,
            self._half,
            p.ground.slope,
        )

    def _between(self, rear: float, ratio: float) -> MotionState:
        """X where the double support of a step of `ratio` times D_s begins."""
        x, velocity, acceleration = self._end_x
        return MotionState(rear + self._rest + ratio * (x - self._rest), ratio * velocity, ratio * acceleration)

    def _heights(self, *, from_rest: bool, to_rest: bool) -> tuple[tuple[float, Cubic], ...]:
        """Z by (7) in three parts, its ends replaced where the walk begins or ends."""
        p, half = self._p, self._half
        top, low, mean = self._z.at(half), MotionState(p.H_min, 0.0, 0.0), 0.5 * (p.H_min + p.H_max)
        before = Cubic(self._z.breaks - p.T_c, self._z.coefficients)
        parts = [(-math.inf, before), (0.5 * p.T_d, self._z)]
        if from_rest:
            parts = [(-math.inf, joined((0.0, 0.5 * half, half), low, mean, top)), (half, self._z)]
        if to_rest:
            parts = [part for part in parts if part[0] < half]
            parts.append((half, joined((half, 0.5 * (half + p.T_c), p.T_c), top, mean, low)))
        return tuple(parts)

    def _still(self, x: float, y: Cubic, levels: tuple[float, float]) -> Piece:
        p = self._p
        z = ((-math.inf, _rest(p.H_min)),)
        return Piece(p.T_start, _rest(x + self._rest), y, z, levels, p.T_start, p.ground.slope)


def _rest(position: float) -> Cubic:
    return Cubic((0.0, 1.0), [[0.0], [0.0], [0.0], [position]])


def _mirrored(spline: Cubic, side: float) -> Cubic:
    return Cubic(spline.breaks, side * spline.coefficients)
