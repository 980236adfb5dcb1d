"""The controller dies in mid-walk: does the guard bring the robot to rest, and can another take over?

In process, cycle by cycle as in real time: from a random moment on no command comes. A cut leaves the robot on
one leg as often as not, and a biped that stops in mid-step may fall whatever its joints do then; what counts
against the guard is a robot that is not limp in the end, or that nobody can take over.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import msgspec
import numpy as np

from bridge.body import load_body
from emulator.wear import load_wear
from nao_hil.analysis.report.page import Claim, Outcome, ReportPage, ReportTable
from nao_hil.analysis.statistics import wilson
from nao_hil.experiments.context import Context
from nao_hil.experiments.watchdog_run import AGAIN, LONGEST, STEPS, WATCHED, Outage, run_once
from nao_hil.runs.config import RunConfig


class GaitOutages(msgspec.Struct, frozen=True, kw_only=True):
    """All outages of one gait."""

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
    outages: tuple[Outage, ...]


class WatchdogResult(msgspec.Struct, frozen=True, kw_only=True):
    """All outages together."""

    name: str = "watchdog"
    passed: bool
    gaits: tuple[GaitOutages, ...]


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
    at_rest = sum(cut.rest < LONGEST for cut in outages)
    stood = sum(not cut.fell for cut in outages)
    taken_over = sum(cut.taken_over for cut in outages)
    return GaitOutages(
        passed=0 < len(outages) == at_rest == taken_over,
        gait=gait,
        n=len(outages),
        at_rest=at_rest,
        stood=stood,
        stood_interval=wilson(stood, len(outages)),
        stood_by_phase={
            phase: (
                sum(not c.fell for c in outages if c.phase == phase),
                sum(c.phase == phase for c in outages),
            )
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
    gaits = tuple(judge(found, gait) for gait, found in outages.items())
    return Outcome(WatchdogResult(passed=all(g.passed for g in gaits), gaits=gaits), _page(context, gaits))


def _page(context: Context, gaits: Sequence[GaitOutages]) -> ReportPage:
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
    return ReportPage(
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
        tables=(ReportTable("By the phase that was cut", ("gait", "phase", "stood", "cut"), tuple(rows)),),
        findings=tuple(findings),
    )
