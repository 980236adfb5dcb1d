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

STEPS: Final = {"dynamic": 20, "static": 6}
"""Of the walk that is cut, by gait."""
AGAIN: Final = 4
"""Steps of the second controller."""
LONGEST: Final = 30.0
"""s of robot time for anything to end."""
LIMP: Final = 0.2
"""A robot at rest has no joint with more stiffness."""
WATCHED: Final = 4.0
"""s at rest in which it must not fall over either."""


class Cut(msgspec.Struct, frozen=True, kw_only=True):
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


class GaitCuts(msgspec.Struct, frozen=True, kw_only=True):
    """All cuts of one gait."""

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


class WatchdogResult(msgspec.Struct, frozen=True, kw_only=True):
    """All cuts together."""

    name: str = "watchdog"
    passed: bool
    gaits: tuple[GaitCuts, ...]


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
        reference = plan.advance(body.cycle, go_on=reference.step < STEPS[gait] - 1)
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
        fell, began, rest = False, self.robot.time, LONGEST
        while self.robot.time - began < min(rest + WATCHED, LONGEST):
            self.robot.advance(self.guard.cycle(self.robot.frame, None, owed=True))
            fell = fell or self.robot.truth().fell
            resting = self.guard.state == "rest" and not self.guard.busy
            if rest == LONGEST and resting and max(self.robot.frame.stiffness) <= LIMP:
                rest = self.robot.time - began
        return fell, rest


def run_once(body: Body, wear: WearProfile, gait: str, seed: int, share: float, settings: GuardSettings) -> Cut:
    """One walk, cut at `share` of its length."""
    with EmulatedRobot(body, seed=seed, wear=wear) as robot:
        run, first = Run(robot, settings), _controller(body, gait, STEPS[gait])
        run.walk(first, 1, max(round(share * walk_cycles(body, gait)), 1))
        cut, before = robot.seq, robot.truth().fell
        fell, rest = run.silence()
        if fell:
            robot.stand_up()
        second = _controller(body, gait, AGAIN)
        taken = run.walk(second, 2, round(LONGEST / body.cycle), begun=True) and not robot.truth().fell
    return Cut(
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


def judge(cuts: Sequence[Cut], gait: str) -> GaitCuts:
    """The verdict on the cuts of a gait; nothing passes without any."""
    at_rest = sum(cut.rest < LONGEST for cut in cuts)
    stood = sum(not cut.fell for cut in cuts)
    taken_over = sum(cut.taken_over for cut in cuts)
    return GaitCuts(
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
    """One cut per gait and seed, at moments drawn evenly over the walk."""
    tasks = [
        Task(
            msgspec.structs.replace(context.changes, gait=gait, seed=seed),
            float(np.random.default_rng(seed).uniform()),
        )
        for seed in context.seeds
        for gait in STEPS
    ]
    cuts: dict[str, list[Cut]] = {gait: [] for gait in STEPS}
    for cut in context.campaign.map("watchdog", make, tasks):
        cuts[cut.gait].append(cut)
    gaits = tuple(judge(found, gait) for gait, found in cuts.items())
    return Outcome(WatchdogResult(passed=all(g.passed for g in gaits), gaits=gaits), _page(context, gaits))


def _page(context: Context, gaits: Sequence[GaitCuts]) -> Page:
    claims, rows, findings = [], [], []
    for g in gaits:
        low, high = g.stood_interval
        rest, over = f"{g.at_rest} of {g.n}", f"{g.taken_over} of {g.n}"
        claims += [
            Claim(f"{g.gait} gait: the guard brings every robot to rest.", rest, g.n == g.at_rest > 0),
            Claim(f"{g.gait} gait: a second controller takes every one over.", over, g.n == g.taken_over > 0),
        ]
        rows += [(g.gait, phase, str(up), str(of)) for phase, (up, of) in g.stood_by_phase.items()]
        findings.append(
            f"{g.gait} gait: {g.stood} of {g.n} came to rest and stayed there without a fall (95 % interval "
            f"{low:.0%} to {high:.0%}), {g.rest_time:.1f} s after the last command on average."
        )
    steps = ", ".join(f"{gait} gait with {n} steps" for gait, n in STEPS.items())
    return Page(
        name="watchdog",
        title="Walks whose controller dies",
        source="Not in the thesis.",
        setup=(
            ("robot", f"{context.robot}, {context.wear}"),
            ("walks", f"{steps}, each cut once at a moment drawn evenly over its length"),
            (
                "then",
                f"the guard alone, watched for {WATCHED:g} s at rest; a second controller walks {AGAIN} steps",
            ),
        ),
        claims=tuple(claims),
        tables=(Table("By the phase that was cut", ("gait", "phase", "stood", "cut"), tuple(rows)),),
        findings=tuple(findings),
    )
