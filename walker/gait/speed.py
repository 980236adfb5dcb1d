"""Velocities and steps: which parameters of a gait mean which mean velocity.

A gait's phases keep their times; what changes with the velocity is the length of the steps. In the static
gait that is l_SW itself. In the dynamic gait the times follow from the sideways motion alone (3.11), so the
length of a step, S_a + S_b + S_d, is proportional to S_a0. In Huang's gait it is D_s.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NamedTuple

import msgspec

from walker.gait.pendulum import plan_step


class Step(NamedTuple):
    """The periodic step of a gait."""

    length: float
    """From one foothold to the next, m."""
    duration: float
    """s"""

    @property
    def velocity(self) -> float:
        """Mean, m/s."""
        return self.length / self.duration


def _static(p: Any) -> Step:
    return Step(p.l_SW, p.T_DSP + p.T_SSP)


def _dynamic(p: Any) -> Step:
    plan = plan_step(p)
    return Step(plan.length, plan.duration)


def _huang(p: Any) -> Step:
    return Step(p.D_s, p.T_c)


STEPS: Final[dict[str, tuple[str, Callable[[Any], Step]]]] = {
    "static": ("l_SW", _static),
    "dynamic": ("S_a0", _dynamic),
    "huang": ("D_s", _huang),
}
"""Name of a gait -> (the parameter that the length of its step is proportional to, its step)."""


def step_of(gait: str, parameters: msgspec.Struct) -> Step:
    """The periodic step that a gait's parameters mean."""
    return STEPS[gait][1](parameters)


def with_velocity(gait: str, parameters: msgspec.Struct, velocity: float) -> msgspec.Struct:
    """The parameters with steps of the length that makes a mean velocity (m/s, positive).

    Whether the body can walk them is for the gait and `walker.walkable` to say.
    """
    name, _ = STEPS[gait]
    value = getattr(parameters, name) * velocity / step_of(gait, parameters).velocity
    return msgspec.structs.replace(parameters, **{name: value})
