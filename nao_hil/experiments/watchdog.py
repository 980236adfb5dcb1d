"""The controller dies in mid-walk: the guard brings the robot to rest, and another controller takes over.

In process, cycle by cycle as in real time: from a random moment on there is no command. A cut often leaves the
robot on one leg, and a biped that stops in mid-step may fall in any case; the guard fails where a robot is not
limp in the end, or where no other controller can take it over.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import msgspec
import numpy as np

from bridge.body import Body, load_body
from bridge.guard import Guard, GuardSettings
from emulator.robot import EmulatedRobot
from emulator.wear import WearProfile, load_wear
from nao_hil.analysis.report.render import Claim, Outcome, ReportTable
from nao_hil.analysis.statistics import Share, share_of
from nao_hil.experiments.context import Context
from nao_hil.runs.config import RunConfig
from walker.controller import Controller, WalkOrder
from walker.gaits import dry_walk, gait_parameters, make_gait
from walker.parameters import controller_parameters

STEPS: Final = {"omni": 40, "dynamic": 20, "static": 6}
"""Of the walk that is cut, by gait."""
SECOND_STEPS: Final = 4
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
    """A second controller walked on from there; after a fall the robot is put on its feet first."""


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
        second = _controller(body, gait, SECOND_STEPS)
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


class GaitOutages(msgspec.Struct, frozen=True, kw_only=True):
    """All outages of one gait."""

    passed: bool
    """All robots are at rest, and another controller took all of them over."""
    gait: str
    at_rest: Share
    stood: Share
    """Brought to rest without a fall."""
    stood_by_phase: dict[str, Share]
    """By the phase at the cut."""
    taken_over: Share
    rest_time: float
    """Mean time from the cut until the joints had let go, s."""
    outages: tuple[Outage, ...]


class WatchdogTask(NamedTuple):
    """One cut to be made, for a worker."""

    config: RunConfig
    """Body, wear, gait, seed, guard."""
    share: float
    """Of the walk's length at which it is cut."""


def make(task: WatchdogTask) -> Outage:
    """Walk, cut, wait, take over."""
    c = task.config
    body = load_body(c.robot)
    return run_once(body, load_wear(c.wear, body), c.gait, c.seed, task.share, c.guard, c.engine)


def judge(outages: Sequence[Outage], gait: str) -> GaitOutages:
    """The verdict on the outages of a gait; nothing passes without any."""
    at_rest = share_of([cut.rest < LONGEST for cut in outages])
    taken_over = share_of([cut.taken_over for cut in outages])
    return GaitOutages(
        passed=0 < len(outages) == at_rest.survived == taken_over.survived,
        gait=gait,
        at_rest=at_rest,
        stood=share_of([not cut.fell for cut in outages]),
        stood_by_phase={
            phase: share_of([not cut.fell for cut in outages if cut.phase == phase])
            for phase in sorted({cut.phase for cut in outages})
        },
        taken_over=taken_over,
        rest_time=float(np.mean([cut.rest for cut in outages])) if outages else 0.0,
        outages=tuple(outages),
    )


def experiment(context: Context) -> Outcome:
    """One cut per gait and seed, at moments drawn evenly over the walk."""
    tasks = [
        WatchdogTask(
            msgspec.structs.replace(context.changes, gait=gait, seed=seed),
            float(np.random.default_rng(seed).uniform()),
        )
        for seed in context.seeds
        for gait in STEPS
    ]
    outages: dict[str, list[Outage]] = {gait: [] for gait in STEPS}
    for cut in context.campaign.map("watchdog", make, tasks):
        outages[cut.gait].append(cut)
    gaits = [judge(found, gait) for gait, found in outages.items()]
    claims, rows, findings = [], [], []
    for g in gaits:
        claims += [
            Claim(f"{g.gait} gait: {text}", f"{share.survived} of {share.n}", share.n == share.survived > 0)
            for text, share in (
                ("the guard brings every robot to rest.", g.at_rest),
                ("a second controller takes every one over.", g.taken_over),
            )
        ]
        rows += [(g.gait, phase, str(s.survived), str(s.n)) for phase, s in g.stood_by_phase.items()]
        findings.append(
            f"{g.gait} gait: {g.stood.words()} came to rest and stayed there without a fall, "
            f"{g.rest_time:.1f} s after the last command on average."
        )
    steps = ", ".join(f"{gait} gait with {n} steps" for gait, n in STEPS.items())
    again = (
        f"the guard alone, watched for {WATCHED:g} s at rest; a second controller walks {SECOND_STEPS} steps"
    )
    return context.outcome(
        "watchdog",
        "Walks whose controller dies",
        "Not in the thesis.",
        setup=[
            ("walks", f"{steps}, each cut once at a moment drawn evenly over its length"),
            ("then", again),
        ],
        claims=claims,
        tables=[ReportTable("By the phase that was cut", ("gait", "phase", "stood", "cut"), tuple(rows))],
        findings=findings,
        figures={"gaits": gaits},
    )
