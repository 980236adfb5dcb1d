"""The interface that all gaits share: a gait is a value, and a step of it is a pure function."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol, TypeVar

import msgspec

from bridge.body import Body
from bridge.errors import ConfigurationError
from bridge.types import Vec3
from walker.gaits.plan import NO_FEEDBACK, Feedback, Plan

P = TypeVar("P", bound="GaitParameters")


class Limits(Protocol):
    """Velocity limits of a gait that walks in any direction."""

    @property
    def max_velocity(self) -> Vec3:
        """Forward, to either side, m/s, and turn, rad/s."""
        ...

    @property
    def max_acceleration(self) -> Vec3:
        """Fastest gain of velocity, m/s^2, m/s^2, rad/s^2."""
        ...

    def share(self, velocity: Vec3) -> float:
        """Part of the limits that a velocity takes up, over 1 outside of them."""
        ...


class PeriodicStep(NamedTuple):
    """The step that a gait repeats."""

    length: float
    """From one foothold to the next, m."""
    duration: float
    """Duration of a step, s."""

    @property
    def velocity(self) -> float:
        """Mean, m/s."""
        return self.length / self.duration


class GaitParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of the parameters of every gait."""

    LENGTH: ClassVar[str | None] = None
    """Name of the parameter to which the length of a step is proportional; None: the length is fixed."""

    @property
    def periodic_step(self) -> PeriodicStep:
        """The step that these parameters mean."""
        raise NotImplementedError

    @property
    def limits(self) -> Limits | None:
        """Limits of the velocity of a gait that walks in any direction; None: straight only."""
        return None

    @property
    def velocity(self) -> Vec3:
        """Mean velocity, forward and to the left, m/s, and turn, rad/s."""
        return self.periodic_step.velocity, 0.0, 0.0

    def with_velocity(self: P, velocity: Vec3) -> P:
        """The parameters with steps of the length that makes a mean velocity; the phases keep their times.

        Whether the body can walk them, the gait and `walker.gaits.catalogue` check.

        Args:
            velocity: forward and to the left, m/s, and turn, rad/s.

        Raises:
            ConfigurationError: the length of the steps is fixed, or the gait does not walk that way.
        """
        x, y, turn = velocity
        if x <= 0.0 or y != 0.0 or turn != 0.0:
            raise ConfigurationError(
                f"This gait walks straight ahead: vx must be positive, vy and omega 0, not {x:g} m/s, "
                f"{y:g} m/s and {turn:g} rad/s; `omni` goes in any direction."
            )
        if self.LENGTH is None:
            raise ConfigurationError("The steps of this gait have a fixed length; leave the velocity out.")
        value = getattr(self, self.LENGTH) * x / self.periodic_step.velocity
        return msgspec.structs.replace(self, **{self.LENGTH: value})


def clipped_in_words(wanted: Vec3, walked: Vec3) -> str:
    """Sentence on the velocity cut off by the limits of a gait; empty: none.

    Args:
        wanted: Forward and to the left, m/s, and turn, rad/s.
        walked: The part that is walked.
    """
    if math.dist(wanted, walked) < 1e-9:
        return ""
    x, y, turn = wanted
    return f"{x:g} m/s, {y:g} m/s and {turn:g} rad/s are beyond the gait's limits and were scaled down together"


S = TypeVar("S")


@dataclass(frozen=True, slots=True)
class GaitCommand:
    """Request to a gait in one cycle."""

    walk: bool
    """Whether another step is wanted after the one under way; without it the gait brings the feet together and
    stops (phase `stand`)."""
    velocity: Vec3 | None = None
    """Mean velocity from the next step on: forward and to the left, m/s, and turn, rad/s. Of gaits that are
    `adjustable`, within the limits of gait and body. None: as the gait's parameters have it."""
    last_step: int = 0
    """Number of the step that ends the walk, for gaits that slow down over several steps; 0: no bound."""
    feedback: Feedback = NO_FEEDBACK
    """Feedback of gaits whose plans have a pendulum."""


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
        """Limits of the velocity of a gait that walks in any direction; None: straight only."""
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
    """Entry of a gait in the catalogue, besides its `gait.toml` and `control.toml`."""

    parameters: type[GaitParameters]
    """Type of its parameters, those of `gait.toml`."""
    make: Callable[[Any, Body], Gait[Any]]
    """Parameters and body to the gait; raises ConfigurationError where the body cannot walk it."""
    max_delay: float = 0.015
    """Mean delay of the answers that a walk bears, s; see `walker.monitor`. Measured on emulated
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
