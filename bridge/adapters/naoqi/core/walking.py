"""ALMotion's walking methods, and the vendor's move configuration: step limits and their velocities.

Names, limits and the formula of the velocity: vendor's page on locomotion control; order: printed by robots.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from typing import Annotated, Any, Final, NamedTuple

from bridge.adapters.naoqi.core.motion_tasks import pass_on
from bridge.adapters.naoqi.core.walker_handover import Order, WalkerHandover
from bridge.adapters.naoqi.declared import OneOf, clipped, offers, text
from bridge.errors import NaoqiRefused
from bridge.planar import Pose2D
from bridge.types import Vec3

logger = logging.getLogger(__name__)

_CONFIG: Final = {
    "MaxStepX": (0.04, 0.001, 0.08),
    "MaxStepY": (0.14, 0.101, 0.16),
    "MaxStepTheta": (0.349066, 0.001, 0.524),
    "MaxStepFrequency": (1.0, 0.0, 1.0),
    "StepHeight": (0.02, 0.005, 0.04),
    "TorsoWx": (0.0, -math.radians(7.0), math.radians(7.0)),
    "TorsoWy": (0.0, -math.radians(7.0), math.radians(7.0)),
}
"""Name -> default, smallest and largest value."""
_FEET: Final = ("Left", "Right")
_KINDS: Final = ("Default", "Min", "Max")
_MAX_BACKWARD_STEP: Final = 0.04
"""Longest step backwards, m."""
_FEET_DISTANCE: Final = 0.1
_MIN_FEET_DISTANCE: Final = 0.088
"""Distance of the feet in a stand, and the least one, m."""
_SLOW_STEP: Final = 0.6
QUICK_STEP: Final = 0.42
"""s of a step."""


class FullSpeed(NamedTuple):
    """Velocities of the longest steps."""

    ahead: float
    """Largest velocity ahead, m/s."""
    back: float
    """Largest velocity backward, m/s."""
    across: float
    """Largest velocity sideways, m/s."""
    turn: float
    """Largest turning rate, rad/s."""

    def of(self, fractions: Vec3) -> Vec3:
        """The velocity by fractions forward, to the left and of the turn: m/s, m/s, rad/s."""
        x, y, turn = fractions
        return x * (self.ahead if x > 0.0 else self.back), y * self.across, turn * self.turn

    def clipped(self, velocity: Vec3) -> Vec3:
        """A velocity clipped to these, m/s, m/s, rad/s."""
        x, y, turn = velocity
        return (
            max(-self.back, min(self.ahead, x)),
            max(-self.across, min(self.across, y)),
            max(-self.turn, min(self.turn, turn)),
        )

    def towards(self, target: Vec3) -> Vec3:
        """The fastest velocity along the way to a distant target, m, m, rad."""
        x, y, turn = target
        duration = self.duration(target)
        return x / duration, y / duration, turn / duration

    def duration(self, target: Vec3) -> float:
        """Duration of the way to a target (m, m, rad), s."""
        x, y, turn = target
        return max(x / self.ahead, -x / self.back, abs(y) / self.across, abs(turn) / self.turn)


def full_speed(method: str, configs: Sequence[Any], frequency: Any = 1.0) -> FullSpeed:
    """The velocities of the longest steps of a configuration.

    Args:
        configs: `[[name, value], ...]` each; a number, the duration of `moveTo`, and an unknown name, which is
            logged, are left out. A foot's own value counts for its steps.
        frequency: of the steps, 0 to 1.
    """
    given: dict[str, float] = {}
    for config in configs:
        if isinstance(config, list):
            given |= _given(method, config)
    quickness = clipped(given.pop("Frequency", frequency), f"{method}: Frequency", 0.0, 1.0)
    default = {name: values[0] for name, values in _CONFIG.items()}
    feet = [default | given | {n: given[foot + n] for n in default if foot + n in given} for foot in _FEET]
    periods = [_SLOW_STEP + quickness * of["MaxStepFrequency"] * (QUICK_STEP - _SLOW_STEP) for of in feet]
    across = [of["MaxStepY"] - max(_MIN_FEET_DISTANCE, 2.0 * _FEET_DISTANCE - of["MaxStepY"]) for of in feet]
    both = sum(periods)
    return FullSpeed(
        sum(of["MaxStepX"] for of in feet) / both,
        2.0 * _MAX_BACKWARD_STEP / both,
        0.5 * sum(across) / both,
        sum(of["MaxStepTheta"] for of in feet) / both,
    )


def _given(method: str, config: list[Any]) -> Mapping[str, float]:
    values = {}
    for row in config:
        if not isinstance(row, list) or len(row) != 2:
            raise NaoqiRefused(f"{method}: {config!r:.60} was given; [[name, value], ...] is expected.")
        full_name = text(row[0], f"{method}: name of the configuration")
        name = full_name.removeprefix("Left").removeprefix("Right")
        if name != "Frequency" and name not in _CONFIG:
            logger.warning("%s: %.40s of the configuration is not known and left out", method, row[0])
            continue
        limits = _CONFIG.get(name, (1.0, 0.0, 1.0))[1:]
        values[full_name] = clipped(_as_number(row[1]), f"{method}: {row[0]}", *limits)
    return values


def _as_number(value: Any) -> Any:
    """A number given as text, as in the vendor's example of `ALNavigation.moveTo`."""
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value


_FIXED_STEPS: Final = 2
"""Fixed footsteps: as many as in the vendor's preview of 0.8 s."""
_MAX_FOOTSTEP: Final = 1.0
"""m and rad in a footstep; NAOqi's own bound is a tenth."""


class WalkingMethods:
    """Walking methods of `ALMotion`; thread-safe.

    Args:
        full: speed of the gait forward and to the left, m/s, and of its turn, rad/s; the last two are 0 for a
            gait that walks straight ahead only, at this speed. Others walk at the vendor's speeds.
    """

    def __init__(self, handover: WalkerHandover, full: Vec3) -> None:
        self.handover, self._full = handover, full

    @offers("ALMotion.move", "ALNavigation.move", kind="walk", begins_walk=True)
    def move(self, x: Any, y: Any, theta: Any, *config: Any) -> Future[Any]:
        """Walk at a velocity, m/s and rad/s; returns once the walker has accepted it."""
        velocity = _three("ALMotion.move", (x, y, theta), 1e4)
        if self._full[1]:
            velocity = full_speed("ALMotion.move", config).clipped(velocity)
        return self.handover.walk(velocity)

    @offers("ALMotion.moveToward", "ALNavigation.moveToward", kind="walk", begins_walk=True)
    def move_toward(self, x: Any, y: Any, theta: Any, *config: Any) -> Future[Any]:
        """Walk at fractions of the full speed, -1 to 1."""
        return self._toward("ALMotion.moveToward", (x, y, theta), 1.0, config)

    @offers("ALMotion.setWalkTargetVelocity", kind="walk", begins_walk=True)
    def set_target_velocity(self, x: Any, y: Any, theta: Any, frequency: Any, *config: Any) -> Future[Any]:
        """`moveToward` with the frequency of the steps, 0 to 1."""
        return self._toward("ALMotion.setWalkTargetVelocity", (x, y, theta), frequency, config)

    def _toward(
        self, method: str, fractions: Sequence[Any], frequency: Any, config: Sequence[Any]
    ) -> Future[Any]:
        wanted = self._checked_velocity(method, _three(method, fractions, 1.0))
        full = full_speed(method, config, frequency)
        return self.handover.walk(full.of(wanted) if self._full[1] else (wanted[0] * self._full[0], 0.0, 0.0))

    @offers("ALMotion.moveTo", "ALMotion.walkTo", "ALNavigation.moveTo", kind="walk", begins_walk=True)
    def move_to(self, *arguments: Any) -> Future[Any]:
        """Walk to a goal `x, y, theta` relative to the robot, m and rad, or over several, each from the last.

        A time and a configuration may follow; waits for the end: true, or false after an interruption.
        """
        method = "ALMotion.moveTo"
        if arguments and isinstance(arguments[0], list):
            given, *config = arguments
            several = bool(given) and all(isinstance(one, list) for one in given)
            places = given if several else [given]
        else:
            places, config = [arguments[:3]], list(arguments[3:])
        if any(len(place) != 3 for place in places):
            raise NaoqiRefused(f"{method}: {places!r:.60} was given; [x, y, theta] of each place is expected.")
        targets = [self._checked_velocity(method, _three(method, place, 1e4)) for place in places]
        return self._walk_over(targets, full_speed(method, config))

    def _walk_over(self, ways: Sequence[Vec3], full: FullSpeed) -> Future[Any]:
        """Walk one way after the other, with a stand between them."""
        ended: Future[Any] = Future()

        def walk_next(before: Future[Any] | None, i: int) -> None:
            if before is not None and (before.exception() or not before.result() or i == len(ways)):
                pass_on(before, ended)
                return
            self._walk_to(ways[i], full).add_done_callback(lambda done: walk_next(done, i + 1))

        walk_next(None, 0)
        return ended

    @offers("ALMotion.setFootSteps", kind="walk", begins_walk=True)
    @offers("ALMotion.setFootStepsWithSpeed", kind="walk", begins_walk=True, wait=True)
    def set_foot_steps(self, legs: Any, steps: Any, *_: Any, wait: bool = False) -> Future[Any]:
        """Begin a walk to the end of footsteps, by the gait's own steps, or wait for its end.

        Args:
            legs: `LLeg` or `RLeg` for each step.
            steps: `[x, y, theta]` of each foot in the frame of the other one, m and rad.
        """
        target = self._end_of("ALMotion.setFootSteps", legs, steps)
        return self._walk_to(target, full_speed("", ()), wait=wait)

    def _end_of(self, method: str, legs: Any, steps: Any) -> Vec3:
        """End of footsteps relative to the robot."""
        if not isinstance(legs, list) or not isinstance(steps, list) or len(legs) != len(steps) or not legs:
            raise NaoqiRefused(f"{method}: a list of legs and one of as many steps [x, y, theta] are expected.")
        half = 0.5 * _FEET_DISTANCE
        feet = {"LLeg": Pose2D(y=half), "RLeg": Pose2D(y=-half)}
        for i, (leg, step) in enumerate(zip(legs, steps, strict=True)):
            if leg not in list(feet):
                raise NaoqiRefused(f"{method}: leg {i} is {leg!r:.60}; LLeg or RLeg is expected.")
            if not isinstance(step, list) or len(step) != 3:
                raise NaoqiRefused(f"{method}: step {i} is {step!r:.60}; [x, y, theta] is expected.")
            other = feet["RLeg" if leg == "LLeg" else "LLeg"]
            feet[leg] = other.pose(Pose2D(*_three(f"{method}, step {i}", step, _MAX_FOOTSTEP)))
        left, right = feet["LLeg"], feet["RLeg"]
        x, y, turn = (0.5 * (a + b) for a, b in zip(left, right, strict=True))
        return self._checked_velocity(method, (x, y, turn))

    def _walk_to(self, target: Vec3, full: FullSpeed, *, wait: bool = True) -> Future[Any]:
        """Walk to a goal, see `WalkerHandover.walk_to`."""
        return self.handover.walk_to(lambda: self._order(target, full), wait=wait)

    def _order(self, target: Vec3, full: FullSpeed) -> Order | None:
        """The order of a walk to a goal relative to the robot; None: it is there.

        While the robot walks, the goal counts from the end of the fixed steps (confirmed: vendor's samples of
        `getNextRobotPosition`).
        """
        if not self._full[1]:
            speed, distance = math.copysign(self._full[0], target[0]), abs(target[0])
            return {"velocity": (speed, 0.0, 0.0), "distance": distance} if distance else None
        ahead = self.poses_ahead()[:_FIXED_STEPS] if self.handover.active else []
        x, y, turn = ahead[-1].pose(Pose2D(*target)) if ahead else target
        place = x, y, math.remainder(turn, math.tau)
        return {"velocity": full.towards(place), "target": place} if any(place) else None

    def poses_ahead(self) -> list[Pose2D]:
        """Pose after each coming step relative to the present one, m and rad, by the vendor's step length."""
        way, count = self.handover.remaining_way(), _FIXED_STEPS
        if way is None:
            way = Pose2D(*(_FIXED_STEPS * QUICK_STEP * speed for speed in self.handover.velocity()))
        elif any(way):
            count = max(count, math.ceil(full_speed("", ()).duration(way) / QUICK_STEP))
        shares = [i / count for i in range(1, count + 1)] if any(way) else []
        return [Pose2D(*(share * part for part in way)) for share in shares]

    def steps_ahead(self) -> list[list[Any]]:
        """Fixed and later footsteps, each `[leg, s, [x, y, theta]]`.

        The time counts from now; the pose is in the frame of the other foot, m and rad.
        """
        half, steps = 0.5 * _FEET_DISTANCE, []
        feet = {"LLeg": Pose2D(y=half), "RLeg": Pose2D(y=-half)}
        for i, pose in enumerate(self.poses_ahead()):
            leg, other = ("RLeg", "LLeg") if i % 2 else ("LLeg", "RLeg")
            feet[leg] = pose.pose(Pose2D(y=half if leg == "LLeg" else -half))
            place = feet[other].local_pose(feet[leg])
            steps.append([leg, QUICK_STEP * (i + 1), list(place)])
        return [steps[:_FIXED_STEPS], steps[_FIXED_STEPS:]]

    @offers("ALMotion.getNextRobotPosition", kind="walk")
    def _next_position(self) -> list[float]:
        """Pose of the robot after the fixed footsteps, m and rad."""
        here, ahead = self.handover.position(), self.poses_ahead()[:_FIXED_STEPS]
        return list(here.pose(ahead[-1]) if ahead else here)

    def _checked_velocity(self, method: str, wanted: Vec3) -> Vec3:
        """The wanted velocity; NaoqiRefused if it is not straight for a gait that walks straight only."""
        _, y, theta = wanted
        if not self._full[1] and (y or theta):
            raise NaoqiRefused(
                f"{method}: y is {y:g} and theta is {theta:g}, but this gait walks straight only; both must be "
                "0. `--gait omni` walks in any direction."
            )
        return wanted

    @offers("ALMotion.moveInit", "ALMotion.walkInit", kind="walk")
    def _prepare(self) -> Future[Any]:
        return self.handover.prepare()

    @offers("ALMotion.stopMove", "ALMotion.stopWalk", "ALMotion.killMove", "ALMotion.killWalk", kind="walk")
    def _stop(self) -> Future[Any]:
        return self.handover.stop()

    @offers(
        "ALMotion.waitUntilMoveIsFinished",
        "ALMotion.waitUntilWalkIsFinished",
        "ALVisualCompass.waitUntilTargetReached",
        kind="walk",
    )
    def _wait(self) -> Future[Any]:
        return self.handover.wait()

    @offers("ALMotion.getMoveConfig", kind="walk")
    def _move_config(self, config: Annotated[str, OneOf("config", _KINDS)]) -> list[list[Any]]:
        return [[name, values[_KINDS.index(config)]] for name, values in _CONFIG.items()]

    _get_robot_velocity = offers("ALMotion.getRobotVelocity", kind="walk")(
        lambda self: self.handover.velocity()
    )
    _move_is_active = offers("ALMotion.moveIsActive", "ALMotion.walkIsActive", kind="walk")(
        lambda self: self.handover.active_or_ordered
    )
    _get_robot_position = offers("ALMotion.getRobotPosition", kind="walk")(
        lambda self, *_: list(self.handover.position())
    )


def _three(method: str, values: Sequence[Any], bound: float) -> Vec3:
    x, y, theta = values
    return (
        clipped(x, f"{method}: x", -bound, bound),
        clipped(y, f"{method}: y", -bound, bound),
        clipped(theta, f"{method}: theta", -bound, bound),
    )
