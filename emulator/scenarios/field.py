"""The playing field of a scenario: lines that are seen, and goals that robots and balls strike.

The middle of the field is the origin of the floor, its length along x. Lines are given by their middles.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Final

import msgspec

from bridge.messages.world_state import Field, Stripe
from bridge.types import Vec2
from emulator.scenarios.ground import PlacedBox, ScenarioTable

Metres = Annotated[float, msgspec.Meta(gt=0.0, le=30.0)]
CIRCLE_STRIPES: Final = 48
"""Straight lines of the centre circle: they leave a circle of 0.75 m by less than 2 mm."""


class ScenarioField(ScenarioTable, frozen=True, kw_only=True):
    """A playing field; the defaults are those of the Standard Platform League."""

    length: Metres
    """Between the goal lines."""
    width: Metres
    """Between the touchlines."""
    border: Metres = 0.7
    """Width of the carpet outside the lines."""
    line: Metres = 0.05
    """Width of a line."""
    circle: Metres = 1.5
    """Diameter of the centre circle."""
    goal_area: tuple[Metres, Metres] = (0.6, 2.2)
    """Depth from the goal line, and width."""
    penalty_area: tuple[Metres, Metres] | None = None
    """As `goal_area`; none: there is no such area."""
    penalty_mark: Metres = 1.3
    """From the goal line to the middle of the mark."""
    mark: Metres = 0.1
    """Length of both bars of a penalty mark."""
    goal: tuple[Metres, Metres] = (1.5, 0.8)
    """Width between the posts, and height under the bar."""
    post: Metres = 0.1
    """Diameter of the posts, and edge of the bar."""

    def __post_init__(self) -> None:
        """Raises ValueError for parts that do not fit into the field."""
        half = 0.5 * self.length
        parts = {
            "circle": (0.5 * self.circle, self.circle),
            "goal_area": self.goal_area,
            "penalty_area": self.penalty_area or self.goal_area,
            "penalty_mark": (self.penalty_mark, self.mark),
            "goal": (self.post, self.goal[0]),
        }
        for name, (depth, width) in parts.items():
            if depth > half or width > self.width:
                raise ValueError(
                    f"`{name}` is {depth:g} m deep and {width:g} m wide; a half of the field has {half:g} x "
                    f"{self.width:g} m"
                )

    def goals(self) -> tuple[PlacedBox, ...]:
        """Posts and bars; the posts' fronts are at the inner edge of the goal line."""
        inner, height = self.goal
        x, y = 0.5 * (self.length - self.line + self.post), 0.5 * (inner + self.post)
        found = []
        for number, side in ((1, -1.0), (2, 1.0)):
            for name, place in (("left", y), ("right", -y)):
                at, size = (side * x, place), (self.post, self.post, height)
                found.append(PlacedBox(name=f"goal{number}-{name}", shape="pole", size=size, at=at, height=0.0))
            size = (self.post, inner + 2.0 * self.post, self.post)
            found.append(PlacedBox(name=f"goal{number}-bar", size=size, at=(side * x, 0.0), height=height))
        return tuple(found)

    def painted(self) -> Field:
        """Carpet and lines, floor frame."""
        x, y = 0.5 * self.length, 0.5 * self.width
        lines: list[tuple[Vec2, Vec2]] = [*_rectangle(-x, x, y), ((0.0, -y), (0.0, y))]
        for depth, width in filter(None, (self.goal_area, self.penalty_area)):
            for side in (-x, x):
                lines += _rectangle(math.copysign(x - depth, side), side, 0.5 * width)
        bar = 0.5 * (self.mark - self.line)  # a line ends half its width farther out
        lines.append(((-bar, 0.0), (bar, 0.0)))
        for at in (self.penalty_mark - x, x - self.penalty_mark):
            lines += [((at - bar, 0.0), (at + bar, 0.0)), ((at, -bar), (at, bar))]
        angles = [2.0 * math.pi * i / CIRCLE_STRIPES for i in range(CIRCLE_STRIPES + 1)]
        ring = [(0.5 * self.circle * math.cos(a), 0.5 * self.circle * math.sin(a)) for a in angles]
        lines += pairwise(ring)
        return Field(
            size=(self.length + 2.0 * self.border, self.width + 2.0 * self.border),
            stripes=tuple(Stripe(begin, end, self.line) for begin, end in lines),
            goals=tuple(box.name for box in self.goals()),
        )


def _rectangle(back: float, front: float, y: float) -> list[tuple[Vec2, Vec2]]:
    corners = [(back, -y), (front, -y), (front, y), (back, y)]
    return list(zip(corners, [*corners[1:], corners[0]], strict=True))
