"""One walk whose controller dies: the walk, the guard, and the takeover."""

from __future__ import annotations

from typing import Final

import msgspec

from bridge.body import Body
from bridge.guard import Guard, GuardSettings
from emulator.robot import EmulatedRobot
from emulator.wear import WearProfile
from walker.controller import Controller, WalkOrder
from walker.gaits import dry_walk, gait_parameters, make_gait
from walker.parameters import controller_parameters

STEPS: Final = {"omni": 40, "dynamic": 20, "static": 6}
"""Of the walk that is cut, by gait."""


AGAIN: Final = 4
"""Steps of the second controller."""


LONGEST: Final = 30.0
"""s of robot time for anything to end."""


LIMP: Final = 0.2
"""A robot at rest has no joint with more stiffness."""


WATCHED: Final = 4.0
"""s at rest in which it must not fall over either."""


class Outage(msgspec.Struct, frozen=True, kw_only=True):
    """One walk that lost its controller."""

    gait: str
    seed: int
    cycle: int
    """Number of the first cycle without a command."""
    phase: str
    """Of the gait at the cut: `DSL`, `SSL`, ..."""
    step: int
    """Steps completed by then."""
    fell_before: bool
    """It had fallen already while it walked."""
    fell: bool
    """By the ground truth, until the guard had it at rest and `WATCHED` beyond that."""
    rest: float
    """Time from the cut until the joints had let go, s; `LONGEST`: they never did."""
    taken_over: bool
    """A second controller walked on from there; after a fall the robot was put on its feet first."""


def _controller(body: Body, gait: str, steps: int) -> Controller:
    parameters = gait_parameters(gait, {})
    order = WalkOrder(steps=steps)
    return Controller(body, make_gait(gait, parameters, body), order, body.cycle, controller_parameters(gait))


def walk_cycles(body: Body, gait: str) -> int:
    """Length of the walk by its plan, from the first phase to the stand, in cycles."""
    walk = dry_walk(make_gait(gait, gait_parameters(gait), body), body.cycle, STEPS[gait])
    return sum(plan.phase != "stand" for plan, _ in walk)


class Run:
    """A robot behind its guard, cycle by cycle.

    Args:
        robot: at its start.
        settings: of the guard.
    """

    def __init__(self, robot: EmulatedRobot, settings: GuardSettings) -> None:
        self.robot, self.guard = robot, Guard(robot.body, settings)

    def walk(self, controller: Controller, lease: int, cycles: int, *, begun: bool = False) -> bool:
        """Walk until the controller is done (True), the robot fell, or `cycles` after the walk began."""
        while cycles > 0 and not self.robot.truth().fell:
            frame = self.robot.frame
            answer = msgspec.structs.replace(controller.tick(frame), lease=lease)
            self.robot.advance(self.guard.cycle(frame, self.guard.check(answer, frame.seq), supervised=True))
            if controller.done:
                return True
            begun = begun or controller.state == "walk"
            cycles -= int(begun)
        return False

    def silence(self) -> tuple[bool, float]:
        """No command from now on: whether the robot fell, and how long until its joints had let go, s."""
        fell, began, rest = False, self.robot.time, LONGEST
        while self.robot.time - began < min(rest + WATCHED, LONGEST):
            self.robot.advance(self.guard.cycle(self.robot.frame, None, supervised=True))
            fell = fell or self.robot.truth().fell
            resting = self.guard.state == "rest" and not self.guard.busy
            if rest == LONGEST and resting and max(self.robot.frame.stiffness) <= LIMP:
                rest = self.robot.time - began
        return fell, rest


def run_once(
    body: Body, wear: WearProfile, gait: str, seed: int, share: float, settings: GuardSettings, engine: str
) -> Outage:
    """One walk, cut at `share` of its length."""
    with EmulatedRobot(body, seed=seed, wear=wear, engine=engine) as robot:
        run, first = Run(robot, settings), _controller(body, gait, STEPS[gait])
        run.walk(first, 1, max(round(share * walk_cycles(body, gait)), 1))
        cut, before = robot.seq, robot.truth().fell
        fell, rest = run.silence()
        if fell:
            robot.stand_up()
        second = _controller(body, gait, AGAIN)
        taken = run.walk(second, 2, round(LONGEST / body.cycle), begun=True) and not robot.truth().fell
    return Outage(
        gait=gait,
        seed=seed,
        cycle=cut,
        phase=first.telemetry.phase,
        step=first.telemetry.step,
        fell_before=before,
        fell=fell,
        rest=rest,
        taken_over=taken,
    )
