"""The walking cycle of Huang et al. (2001) as a phase machine: start, cycles, stop.

A cycle is a double support, in which the rear foot rolls onto its toe and the front foot from its heel onto
its sole, and a single support on the front foot. Whether another step follows is decided when the swing foot
has landed. From rest the body swings sideways into the first cycle, whose step has half the way; the last step
brings the feet together. Over known ground the lengths of the steps and the heights of feet and hip follow it.

The planned zero moment point is that of all bodies (13), (14), from the poses themselves at every call.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from typing import Final, Literal

import msgspec

from bridge.datasheet import Body
from bridge.datasheet.model import Side
from walker.arms import ARMS
from walker.gait.huang.checks import check_swing, check_walk
from walker.gait.huang.clear import ClearPaths
from walker.gait.huang.foot import FootPath, FootShape, Placement
from walker.gait.huang.footholds import Footholds
from walker.gait.huang.found import chosen
from walker.gait.huang.multibody import STEP, Ankle, Bodies
from walker.gait.huang.parameters import HuangParameters, check_bounds
from walker.gait.huang.pieces import Piece, Pieces
from walker.gait.reference import Foot, Phase, Reference, Support

_SIGN: Final[dict[Side, float]] = {"L": 1.0, "R": -1.0}
_OTHER: Final[dict[Side, Side]] = {"L": "R", "R": "L"}
_EPSILON: Final = 1e-9
"""s; cycles end on robot cycles in spite of rounding."""
Pose = tuple[tuple[float, float, float], Ankle, Ankle]
"""Hips' middle, left and right ankle, walk frame, m and rad."""


class HuangGait:
    """Phase machine of the walking cycle with heel and toe.

    Args:
        parameters: of the gait; what of the hip's motion they leave open is searched, see `search`.
        body: data sheet.

    Raises:
        ConfigurationError: parameters that the body cannot walk; names the bound or the joint, and by how much.
    """

    name = "huang"
    quasi_static = False

    def __init__(self, parameters: HuangParameters, body: Body) -> None:
        check_bounds(parameters)
        check_swing(parameters, body)
        ground = parameters.ground.stretched(1.0 / parameters.progress)
        self.parameters = parameters = msgspec.structs.replace(parameters, ground=ground, progress=1.0)
        self.choice = chosen(parameters, body)
        """Where the hip is at the ends of single support."""
        self._shape, self._bodies = FootShape.of(body), Bodies(body, ARMS)
        half_width = max(abs(y) for _, y in body.foot.sole)
        self._footholds = Footholds(parameters, self._shape, half_width)
        self._footholds.check_width()
        self._swings = ClearPaths(parameters, body)
        half = 0.5 * parameters.l_FA
        self._feet: dict[Side, Placement] = {
            side: self._footholds.place(0.0, sign * half) for side, sign in _SIGN.items()
        }
        self._paths: dict[Side, tuple[FootPath, float]] = {}
        self._swing: Side = parameters.first_swing
        self._stage: Literal["stand", "start", "cycle", "stop"] = "stand"
        self._began = self._t = self._carry = 0.0
        self.steps = 0
        """Steps completed."""
        rest, self._com_from_hip, height = self._standing(body)
        self._pieces = Pieces(parameters, self.choice, rest, height)
        self._piece = self._pieces.stand(0.0, self._level(self._feet["L"]))
        check_walk(body, self._bodies, self, max(parameters.ground.edges(), default=0.0))

    def stand(self) -> Reference:
        """The plan at rest where the gait is now."""
        return self.plan()

    def advance(self, dt: float, *, go_on: bool) -> Reference:
        """The plan `dt` seconds later; see `Gait.advance`."""
        if self._stage == "stand":
            if not go_on:
                return self.stand()
            self._begin("start", self._pieces.start(*self._place(), self._side))
        elif self._over:
            self._next_stage(go_on=go_on)
        self._t += self._carry + dt
        self._carry = 0.0
        if self._over:
            # What comes next is decided at the next call, by whoever has seen this step completed.
            self._carry = max(self._t - self._piece.duration, 0.0)
            self._t = self._piece.duration
            self._complete()
        return self.plan()

    def pose(self) -> Pose:
        """The last plan's hip and ankles."""
        return self._pose(self._t)

    def trial(self, dt: float) -> Iterator[HuangGait]:
        """An endless walk from the stand on a copy of this gait, which is yielded after each `dt`."""
        gait = copy.copy(self)
        gait._feet, gait._paths = dict(self._feet), dict(self._paths)
        while True:
            gait.advance(dt, go_on=True)
            yield gait

    @property
    def stance_x(self) -> float:
        """Place of the foot that is furthest ahead, m."""
        return max(foot.x for foot in self._feet.values())

    @property
    def _over(self) -> bool:
        return self._t >= self._piece.duration - _EPSILON

    @property
    def _side(self) -> float:
        """1 where the cycle that comes stands on the left foot, -1 on the right one."""
        return -_SIGN[self._swing]

    def _place(self) -> tuple[float, float]:
        """X and height of the ground of a standing robot, m."""
        foot = self._feet[_OTHER[self._swing]]
        return foot.x, self._level(foot)

    def _begin(self, stage: Literal["start", "cycle", "stop"], piece: Piece) -> None:
        self._stage, self._piece, self._t = stage, piece, 0.0

    def _complete(self) -> None:
        """At the end of a piece."""
        if self._stage == "cycle":
            self.steps += 1
            self._feet[self._swing] = self._paths[self._swing][0].end
            self._swing = _OTHER[self._swing]
        elif self._stage == "stop":
            self._began += self._t
            self._stage, self._t, self._carry = "stand", 0.0, 0.0
            self._piece = self._pieces.stand(*self._place())

    def _next_stage(self, *, go_on: bool) -> None:
        """From the end of a start or a cycle: another cycle, or to rest."""
        self._began += self._piece.duration
        rear, stance = self._feet[self._swing], self._feet[_OTHER[self._swing]]
        levels = self._piece.level, self._level(stance)
        if not go_on and rear.x == stance.x:
            self._begin("stop", self._pieces.stop(stance.x, levels, self._side))
            return
        y = _SIGN[self._swing] * 0.5 * self.parameters.l_FA
        landing = self._footholds.next(stance.x, y) if go_on else self._footholds.place(stance.x, y)
        self._paths[self._swing] = self._swings.path(rear, landing, y), self._began
        self._begin("cycle", self._pieces.cycle((rear, stance, landing), levels, self._side))

    def _level(self, foot: Placement) -> float:
        """Height of the patch below a foot over the floor, m."""
        return foot.z + math.tan(self.parameters.ground.slope) * foot.x

    def plan(self) -> Reference:
        """The last plan."""
        hip, left, right = self._pose(self._t)
        before, now, after = (self._bodies.frames(*self._pose(self._t + shift)) for shift in (-STEP, 0.0, STEP))
        phase, support, progress = self._where()
        return Reference(
            phase=phase,
            support=support,
            progress=progress,
            step=self.steps,
            left=self._sole(left),
            right=self._sole(right),
            com=(hip[0] + self._com_from_hip[0], hip[1] + self._com_from_hip[1]),
            zmp=self._bodies.zmp(before, now, after),
            hip_height=hip[2],
        )

    def _where(self) -> tuple[Phase, Support, float]:
        """Phase, support and progress."""
        stance, p = _OTHER[self._swing], self.parameters
        double: Phase = "DSL" if stance == "L" else "DSR"
        if self._stage == "stand":
            return "stand", "both", 0.0
        if self._over:
            return double, "both", 0.0
        if self._stage != "cycle":
            return self._stage, "both", self._t / self._piece.duration
        if self._t < p.T_d - _EPSILON:
            return double, "both", self._t / p.T_d
        return "SSL" if stance == "L" else "SSR", stance, max((self._t - p.T_d) / (p.T_c - p.T_d), 0.0)

    def _pose(self, t: float) -> Pose:
        """At a time of the piece, s, a little before and after it too."""
        if self._stage == "stand" or (self._stage == "start" and t < 0.0):
            t = 0.0
        elif self._stage == "stop":
            t = min(t, self._piece.duration)
        return self._piece.hip(t), self._ankle("L", self._began + t), self._ankle("R", self._began + t)

    def _ankle(self, side: Side, now: float) -> Ankle:
        foot = self._feet[side]
        path, began = self._paths.get(side, (None, 0.0))
        y = _SIGN[side] * 0.5 * self.parameters.l_FA
        if path is None:
            s, c = math.sin(foot.pitch), math.cos(foot.pitch)
            return Ankle(foot.x + self._shape.l_an * s, y, foot.z + self._shape.l_an * c, foot.pitch)
        x, z, pitch = path.motion(now - began)
        return Ankle(x.position, y, z.position, pitch.position)

    def _sole(self, ankle: Ankle) -> Foot:
        height, s, c = self._shape.l_an, math.sin(ankle.pitch), math.cos(ankle.pitch)
        return Foot(ankle.x - height * s, ankle.y, ankle.z - height * c, ankle.pitch)

    def _standing(self, body: Body) -> tuple[float, tuple[float, float], float]:
        """The stand whose centre of mass is over the soles' middle.

        Returns:
            x of the hip from the ankles; centre of mass from the hip, x and y; its height; m.
        """
        left, right = self._ankle("L", 0.0), self._ankle("R", 0.0)
        ahead, base = 0.0, self._feet["L"].z
        for _ in range(30):  # a fixed point, as in `walker.pose`
            hip = (ahead, 0.0, self.parameters.H_min + base)
            com = self._bodies.centre_of_mass(self._bodies.frames(hip, left, right))
            ahead += body.foot.centre[0] - float(com[0])
        return ahead, (float(com[0]) - hip[0], float(com[1]) - hip[1]), float(com[2]) - base
