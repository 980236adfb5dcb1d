"""The interface that all gaits share: a gait is a value, and a step of it is a pure function."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from bridge.body import Body
from bridge.types import Vec3
from walker.planning.feedback import NONE, Feedback
from walker.planning.parameters import GaitParameters
from walker.planning.plan import Plan
from walker.planning.steering import Limits

S = TypeVar("S")


@dataclass(frozen=True, slots=True)
class GaitCommand:
    """What a gait is asked for in one cycle."""

    walk: bool
    """Whether another step is wanted after the one under way; without it the gait brings the feet together and
    comes to a stand (phase `stand`)."""
    velocity: Vec3 | None = None
    """Mean velocity from the next step on: forward and to the left, m/s, and turn, rad/s. Of gaits that are
    `adjustable`, within what the gait and the body can walk. None: as the gait's parameters have it."""
    last_step: int = 0
    """Number of the step that ends the walk, for gaits that slow down over several steps; 0: no bound."""
    feedback: Feedback = NONE
    """Of gaits whose plans have a pendulum."""


class Gait(Protocol[S]):
    """Turns time into plans; knows no sensor, clock or joint. `S` is its state, a frozen value."""

    @property
    def name(self) -> str:
        """Name on the command line."""
        ...

    @property
    def quasi_static(self) -> bool:
        """Whether the planned centre of mass is its own ZMP, so that the weights of the limbs alone count."""
        ...

    @property
    def adjustable(self) -> bool:
        """Whether the velocity may change while it walks."""
        ...

    @property
    def limits(self) -> Limits | None:
        """Of the velocity, where the gait walks in any direction; None: it does not."""
        ...

    def initial(self) -> S:
        """The state at rest at the origin of the walk frame."""
        ...

    def step(self, state: S, dt: float, command: GaitCommand) -> tuple[Plan, S]:
        """The plan and the state `dt` seconds later.

        Args:
            state: of the last call, or the initial one.
            dt: time since then, s.
            command: in force now.
        """
        ...


@dataclass(frozen=True)
class GaitKind:
    """What the folder of a gait tells the catalogue, beside its `gait.toml` and `control.toml`."""

    parameters: type[GaitParameters]
    """Type of its parameters, those of `gait.toml`."""
    make: Callable[[Any, Body], Gait[Any]]
    """Parameters and body to the gait; raises ConfigurationError where the body cannot walk it."""
    max_delay: float = 0.015
    """Mean delay of the answers that a walk bears, s; see `walker.estimation.delay`. Measured on emulated
    robots (docs/network.md): the static gait bears two late cycles, and on an ideal robot falls with three; the
    dynamic one bears three."""


def standing_plan(gait: Gait[Any]) -> Plan:
    """The plan of a gait at rest at the origin of the walk frame."""
    return gait.step(gait.initial(), 0.0, GaitCommand(walk=False))[0]


def dry_walk(gait: Gait[S], dt: float, steps: int | None = None) -> Iterator[tuple[Plan, S]]:
    """Plans and states of a walk from the initial stand, without a robot.

    Args:
        gait: to be walked.
        dt: time between two plans, s.
        steps: of the walk, the closing one included, at least 2; the last plan is that of the stand. None: the
            walk has no end.
    """
    state = gait.initial()
    plan, state = gait.step(state, dt, GaitCommand(walk=True))
    yield plan, state
    while plan.phase != "stand" or plan.step == 0:
        command = GaitCommand(walk=steps is None or plan.step < steps - 1, last_step=steps or 0)
        plan, state = gait.step(state, dt, command)
        yield plan, state
