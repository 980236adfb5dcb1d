"""The states of the controller and their transitions: one table, read from top to bottom.

In each cycle every row is evaluated once, in this order. A row whose state is in force and whose condition
holds is carried out, and the rows below see the new state. The controller has a method for each act.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, Literal, NamedTuple

from bridge.messages import SensorFrame
from bridge.motion import Lying
from bridge.stance import stands
from walker.monitor import Estimate
from walker.parameters import ControllerParameters
from walker.states.down import Fallen, Moving, Recovery, Resting
from walker.states.state import State, StateName, legs_hold
from walker.states.upright import Approaching, Walking

Verb = Literal[
    "get up",
    "stop",
    "fall",
    "resume",
    "stand up",
    "lie",
    "rest",
    "interrupt",
    "fail",
    "capture step",
    "play",
    "begin",
    "steer",
    "arrive",
    "stand",
]
"""Acts of the controller, by the name in the row's third column."""


class Situation(NamedTuple):
    """Inputs of the transitions in one cycle."""

    state: State
    frame: SensorFrame
    estimate: Estimate
    parameters: ControllerParameters
    recovery: Recovery
    lying_side: Lying
    """Side on which the robot lies."""
    first: bool
    """No frame has been answered before this one."""
    hold_over: bool
    """The time for which the walk is ordered is over."""
    motion_ordered: bool
    """A motion waits to begin."""
    walk_ordered: bool
    """A walk waits to begin."""
    target_ordered: bool
    """The walk under way leads to a place."""
    goes_on: bool
    """After getting up the order is resumed."""
    waits_for_orders: bool
    """The controller serves orders; otherwise it carries out the one of its constructor."""
    fell: bool
    """Since the last walk began."""


class Transition(NamedTuple):
    """One row: in one of these states, when the condition holds, do this."""

    states: tuple[StateName, ...]
    condition: Callable[[Situation], bool]
    next: Verb
    last: bool = False
    """No further row is evaluated in this cycle, and the new state sets its first pose."""


def _motion_got_up(s: Situation) -> bool:
    return isinstance(s.state, Moving) and s.state.got_up


def _motion_done(s: Situation) -> bool:
    return isinstance(s.state, Moving) and s.state.player.done


def _motion_left_it_standing(s: Situation) -> bool:
    """Another motion than getting up ended on stiff legs under the torso."""
    return _motion_done(s) and s.state.stiffness == 1.0 and stands(s.recovery.body, s.frame)


def _put_on_its_feet(s: Situation) -> bool:
    """It was limp, now it is stiff and upright: a person put it on its feet, not this controller.

    The fused angle of the frame counts. The walker's own still turns up from the lying pose.
    """
    state = s.state
    if not (s.waits_for_orders and isinstance(state, Fallen | Resting) and state.went_limp):
        return False
    return legs_hold(s.frame, state.stiffness) and math.hypot(*s.frame.angle) < s.parameters.fall.angle


def _failed(s: Situation) -> bool:
    return isinstance(s.state, Walking) and bool(s.state.failure)


def _may_begin(s: Situation) -> bool:
    """A walk may begin from a stand, from lying upright, or near to a stand that is approached."""
    if not s.walk_ordered:
        return False
    if isinstance(s.state, Approaching):
        return s.state.to_stand and s.waits_for_orders and not s.fell and s.state.near
    return s.state.name == "stand" or not s.estimate.fall


WALKING: Final[tuple[StateName, ...]] = ("walk", "stopping")

TRANSITIONS: Final = (
    # Before the fall: a robot that lies at the beginning has not fallen.
    Transition(("approach",), lambda s: s.first and s.recovery.begins_down(s.frame, s.lying_side), "get up"),
    Transition(WALKING, lambda s: s.hold_over, "stop"),
    # Ends the cycle: the pose before the impact must not wait for an order's.
    Transition(("approach", *WALKING, "stand"), lambda s: bool(s.estimate.fall), "fall", last=True),
    # Before the ends of motions, so that a motion that ends rests for a cycle before another begins.
    Transition(("fallen", "rest"), lambda s: s.recovery.due(s.state, ordered=s.walk_ordered), "get up"),
    # A get-up is judged by itself, before the rows for any motion.
    Transition(("motion",), lambda s: _motion_got_up(s) and s.goes_on, "resume"),
    Transition(("motion",), _motion_got_up, "stand up"),
    Transition(("motion",), lambda s: isinstance(s.state, Moving) and s.state.failed, "lie"),
    Transition(("motion",), _motion_left_it_standing, "stand up"),
    Transition(("motion",), _motion_done, "rest"),
    # Before an ordered motion or walk: these then begin from the stand.
    Transition(("fallen", "rest"), _put_on_its_feet, "stand up"),
    Transition(WALKING, lambda s: s.estimate.gap > s.parameters.max_gap, "interrupt"),
    # After the fall: a robot that falls braces.
    Transition(WALKING, _failed, "fail"),
    # Before orders: a robot that tips over has no time for them.
    Transition(("stand",), lambda s: s.estimate.feedback.capture_step is not None, "capture step"),
    # A motion before a walk: ordering a motion drops the walk, so a waiting walk is the later order.
    Transition(("stand", "rest", "fallen"), lambda s: s.motion_ordered, "play"),
    Transition(("approach", "stand", "fallen"), _may_begin, "begin"),
    # After the beginning, so that a walk heads for its target from its first cycle on.
    Transition(("walk",), lambda s: s.target_ordered, "steer"),
    # Last: the successor takes this cycle, and nothing before has seen it.
    Transition(("approach",), lambda s: isinstance(s.state, Approaching) and s.state.done, "arrive"),
)
"""Rows before the state answers."""

ENDINGS: Final = (
    Transition(("stopping",), lambda s: isinstance(s.state, Walking) and s.state.feet_closed, "stand"),
)
"""Rows after the state answered."""
