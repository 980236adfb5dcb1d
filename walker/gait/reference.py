"""What every gait yields each cycle, and the interface they share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

Support = Literal["L", "R", "both"]
Phase = Literal["stand", "start", "DSL", "SSL", "DSR", "SSR", "stop"]


@dataclass(frozen=True, slots=True)
class Foot:
    """Pose of a sole (frame 9 of the thesis, below the ankle) in the walk frame.

    The walk frame lies on the nominal ground: x forward, y left, z up, origin midway between the ankles at
    the start.
    """

    x: float
    """m"""
    y: float
    """m"""
    z: float = 0.0
    """m above the nominal ground"""
    pitch: float = 0.0
    """rad, positive: toe down"""


@dataclass(frozen=True, slots=True)
class Reference:
    """The plan at one instant, in the walk frame, SI units."""

    phase: Phase
    support: Support
    """The foot that bears the weight; `both` in double support."""
    progress: float
    """Share of the phase that has passed, 0..1."""
    step: int
    """Steps completed (swing feet put down)."""
    left: Foot
    right: Foot
    com: tuple[float, float]
    """Centre of mass, x and y, m."""
    zmp: tuple[float, float]
    """m"""
    hip_height: float
    """Height of the hip joints (frame 0 of the legs) above the nominal ground, m."""


class Gait(Protocol):
    """A phase machine: time goes in, plans come out; no clock, no I/O."""

    @property
    def name(self) -> str:
        """Name on the command line."""
        ...

    @property
    def quasi_static(self) -> bool:
        """Whether the planned centre of mass is its own ZMP, so that the weights of the limbs alone count."""
        ...

    def stand(self) -> Reference:
        """The plan at rest, before the first and after the last step of a walk that began now."""
        ...

    def advance(self, dt: float, *, go_on: bool) -> Reference:
        """The plan `dt` seconds later.

        Args:
            dt: time since the last call, s.
            go_on: whether another step is wanted after the one under way; without it the gait brings the
                feet together and comes to a stand (phase `stand`).
        """
        ...


@runtime_checkable
class AdjustableGait(Gait, Protocol):
    """A gait whose steps may become longer or shorter while it walks."""

    def set_step_length(self, length: float) -> None:
        """Length of the steps from the next one on, m, within what the gait and the body can walk."""
        ...
