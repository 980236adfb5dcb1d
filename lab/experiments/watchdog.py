"""The controller dies in mid-walk: does the guard bring the robot to rest, and can another take over?

In process, cycle by cycle as in real time: from a random moment on no command comes. A cut leaves the robot on
one leg as often as not, and a biped that stops in mid-step may fall whatever its joints do then; what counts
against the guard is a robot that is not limp in the end, or that nobody can take over.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import msgspec
import numpy as np

from bridge.datasheet import Body, load_body
from bridge.guard import Guard, GuardSettings
from emulator.robot import EmulatedRobot
from emulator.wear import WearProfile, load_wear
from lab.campaign.proportion import wilson
from lab.config import RunConfig
from lab.experiments.context import Context
from lab.experiments.page import Claim, Outcome, Page, Table
from walker.controller import Controller, WalkOrder
from walker.gait import gait_parameters, make_gait
from walker.parameters import controller_parameters

STEPS: Final = 20
"""Of the walk that is cut."""
AGAIN: Final = 4
"""Steps of the second controller."""
LONGEST: Final = 30.0
"""s of robot time for anything to end."""
LIMP: Final = 0.2
"""A robot at rest has no joint with more stiffness."""


class Cut(msgspec.Struct, frozen=True, kw_only=True):
    """One walk that lost its controller."""

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
    """By the ground truth, before the guard had it at rest."""
    rest: float
    """Time from the cut until the joints had let go, s; `LONGEST`: they never did."""
    taken_over: bool
    """A second controller walked on from there; after a fall the robot was put on its feet first."""


class WatchdogResult(msgspec.Struct, frozen=True, kw_only=True):
    """All cuts together."""

    name: str = "watchdog"
    passed: bool
    """Every robot came to rest, and every one was taken over."""
    gait: str
    n: int
    at_rest: int
    stood: int
    """Brought to rest without a fall."""
    stood_interval: tuple[float, float]
    """Wilson's 95 % interval of the share."""
    stood_by_phase: dict[str, tuple[int, int]]
    """Phase at the cut -> stood, cut."""
    taken_over: int
    rest_time: float
    """Mean time from the cut until the joints had let go, s."""
    cuts: tuple[Cut, ...]


def _controller(body: Body, gait: str, steps: int) -> Controller:
    parameters = gait_parameters(gait, {})
    order = WalkOrder(steps=steps)
    return Controller(body, make_gait(gait, parameters, body), order, body.cycle, controller_parameters(gait))


def walk_cycles(body: Body, gait: str) -> int:
    """Length of the walk by its plan, from the first phase to the stand, in cycles."""
    plan, cycles = make_gait(gait, gait_parameters(gait, {}), body), 0
    reference = plan.advance(body.cycle, go_on=True)
    while reference.phase != "stand":
        cycles += 1
        reference = plan.advance(body.cycle, go_on=reference.step < STEPS - 1)
    return cycles


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
            self.robot.advance(self.guard.cycle(frame, self.guard.check(answer, frame.seq), owed=True))
            if controller.done:
                return True
            begun = begun or controller.state == "walk"
            cycles -= int(begun)
        return False

    def silence(self) -> tuple[bool, float]:
        """No command from now on: whether the robot fell, and how long until its joints had let go, s."""
        fell, began = False, self.robot.time
        while self.robot.time - began < LONGEST:
            self.robot.advance(self.guard.cycle(self.robot.frame, None, owed=True))
            fell = fell or self.robot.truth().fell
            resting = self.guard.state == "rest" and not self.guard.busy
            if resting and max(self.robot.frame.stiffness) <= LIMP:
                return fell, self.robot.time - began
        return fell, LONGEST


def run_once(body: Body, wear: WearProfile, gait: str, seed: int, share: float, settings: GuardSettings) -> Cut:
    """One walk, cut at `share` of its length."""
    with EmulatedRobot(body, seed=seed, wear=wear) as robot:
        run, first = Run(robot, settings), _controller(body, gait, STEPS)
        run.walk(first, 1, max(round(share * walk_cycles(body, gait)), 1))
        cut, before = robot.seq, robot.truth().fell
        fell, rest = run.silence()
        if fell:
            robot.stand_up()
        second = _controller(body, gait, AGAIN)
        taken = run.walk(second, 2, round(LONGEST / body.cycle), begun=True) and not robot.truth().fell
    return Cut(
        seed=seed,
        cycle=cut,
        phase=first.telemetry.phase,
        step=first.telemetry.step,
        fell_before=before,
        fell=fell,
        rest=rest,
        taken_over=taken,
    )


class Task(NamedTuple):
    """One cut to be made, for a worker."""

    config: RunConfig
    """Body, wear, gait, seed, guard."""
    share: float
    """Of the walk's length at which it is cut."""


def make(task: Task) -> Cut:
    """Walk, cut, wait, take over."""
    c = task.config
    return run_once(load_body(c.robot), load_wear(c.wear), c.gait, c.seed, task.share, c.guard)


def judge(cuts: Sequence[Cut], gait: str) -> WatchdogResult:
    """The verdict on some cuts; nothing passes without any."""
    at_rest = sum(cut.rest < LONGEST for cut in cuts)
    stood = sum(not cut.fell for cut in cuts)
    taken_over = sum(cut.taken_over for cut in cuts)
    return WatchdogResult(
        passed=0 < len(cuts) == at_rest == taken_over,
        gait=gait,
        n=len(cuts),
        at_rest=at_rest,
        stood=stood,
        stood_interval=wilson(stood, len(cuts)),
        stood_by_phase={
            phase: (sum(not c.fell for c in cuts if c.phase == phase), sum(c.phase == phase for c in cuts))
            for phase in sorted({cut.phase for cut in cuts})
        },
        taken_over=taken_over,
        rest_time=float(np.mean([cut.rest for cut in cuts])) if cuts else 0.0,
        cuts=tuple(cuts),
    )


def experiment(context: Context) -> Outcome:
    """One cut per seed, at moments drawn evenly over the dynamic walk."""
    tasks = [
        Task(
            msgspec.structs.replace(context.changes, gait="dynamic", seed=seed),
            float(np.random.default_rng(seed).uniform()),
        )
        for seed in context.seeds
    ]
    result = judge(context.campaign.map("watchdog", make, tasks), "dynamic")
    low, high = result.stood_interval
    n = result.n
    page = Page(
        name="watchdog",
        title="Walks whose controller dies",
        source="Not in the thesis.",
        setup=(
            ("robot", f"{context.robot}, {context.wear}"),
            ("walk", f"dynamic gait, {STEPS} steps, cut once at a moment drawn evenly over its length"),
            ("then", f"the guard alone; a second controller walks {AGAIN} steps from where the robot rests"),
        ),
        claims=(
            Claim("The guard brings every robot to rest.", f"{result.at_rest} of {n}", result.at_rest == n),
            Claim("A second controller takes every one over.", f"{result.taken_over} of {n}", result.passed),
        ),
        tables=(
            Table(
                "By the phase that was cut",
                ("phase", "stood", "cut"),
                tuple((name, str(up), str(of)) for name, (up, of) in result.stood_by_phase.items()),
            ),
        ),
        findings=(
            f"{result.stood} of {n} came to rest without a fall (95 % interval {low:.0%} to {high:.0%}), "
            f"{result.rest_time:.1f} s after the last command on average.",
        ),
    )
    return Outcome(result, page)
