"""Falls in a walk: foreseen or not, how hard, and whether the robot gets up and walks on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import msgspec
import numpy as np

from nao_hil.analysis.report.page import Claim, Outcome, ReportPage, ReportTable
from nao_hil.analysis.statistics import few_words, wilson
from nao_hil.experiments.context import Context
from nao_hil.experiments.falls_run import (
    FELLING,
    IMPULSE,
    PUSH_PERIOD,
    WALKS,
    Fall,
    PushedWalk,
    pushed_walk,
    pushes,
)
from nao_hil.experiments.setup import setup_rows
from nao_hil.runs.campaign import Interrupted

LEAD: Final = 0.2
"""s before the torso leans by 45 degrees."""
SHARE: Final = 0.9
SPEED: Final = 2.0
"""m/s"""


class FallsResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "falls"
    passed: bool
    n: int
    fell: int
    foreseen: int
    """Falls that were noticed `LEAD` before."""
    foreseen_interval: tuple[float, float]
    """Wilson's 95 % interval of the share."""
    lead_median_s: float
    tilt_max_deg: float
    """Largest lean of the torso at the notice of a fall."""
    needless: int
    """Pushes after which the robot gave way, and did not come to lean by 45 degrees."""
    false_alarms: int
    walked_s: float
    """In which they came: undisturbed walking."""
    speed_max: dict[str, float]
    """Largest of torso and head as they reached the ground, m/s."""
    walks_on: int
    """Of all pushes."""
    falls: tuple[Fall, ...]


def judge(falls: Sequence[Fall]) -> FallsResult:
    """The figures of all pushes."""
    down = [each for each in falls if each.fell]
    foreseen = sum(each.lead >= LEAD for each in down)
    parts = sorted({part for each in falls for part in each.speed})
    result = FallsResult(
        passed=False,
        n=len(falls),
        fell=len(down),
        foreseen=foreseen,
        foreseen_interval=wilson(foreseen, len(down)),
        lead_median_s=float(np.median([each.lead for each in down])) if down else 0.0,
        tilt_max_deg=max((each.tilt for each in down), default=0.0),
        needless=sum(not each.fell and each.tilt > 0.0 for each in falls),
        false_alarms=sum(each.false_alarms for each in falls),
        walked_s=sum(each.walked for each in falls),
        speed_max={part: max(each.speed.get(part, 0.0) for each in falls) for part in parts},
        walks_on=sum(each.walks_on for each in falls),
        falls=tuple(falls),
    )
    return msgspec.structs.replace(result, passed=all(claim.holds for claim in claims(result)))


def claims(result: FallsResult) -> tuple[Claim, ...]:
    """The claims, each with the measured value."""
    low, high = result.foreseen_interval
    hardest = max(result.speed_max.values(), default=0.0)
    return (
        Claim(
            f"{SHARE:.0%} of the falls are noticed {LEAD:g} s before 45 degrees, by the interval's lower bound",
            f"{result.foreseen} of {result.fell} (95 % interval {low:.0%} to {high:.0%}), "
            f"median {result.lead_median_s:.2f} s",
            low >= SHARE,
        ),
        Claim(
            "Every fall is noticed before 20 degrees",
            f"at {result.tilt_max_deg:.0f} degrees at most",
            result.tilt_max_deg < 20.0,
        ),
        Claim(
            "No false alarm in undisturbed walking",
            f"{result.false_alarms} in {result.walked_s:.0f} s",
            result.false_alarms == 0,
        ),
        Claim(
            f"Torso and head reach the ground at no more than {SPEED:g} m/s",
            f"{hardest:.1f} m/s",
            hardest <= SPEED,
        ),
        Claim(
            f"After every push the robot walks on for {WALKS:g} s",
            f"{result.walks_on} of {result.n}",
            result.walks_on == result.n,
        ),
    )


def experiment(context: Context) -> Outcome:
    """One push per seed; with a duration, one a minute."""
    if context.duration is not None:
        pushes(context.duration)
    tasks = [
        PushedWalk(config=msgspec.structs.replace(context.changes, seed=seed), duration=context.duration)
        for seed in context.seeds
    ]
    walks: list[list[Fall]] = context.campaign.map("falls", pushed_walk, tasks)
    if not walks:
        raise Interrupted
    result = judge([each for walk in walks for each in walk])
    push = f"{IMPULSE[0]:g} to {IMPULSE[1]:g} N s"
    if context.duration is not None:
        push = f"{FELLING:g} N s every {PUSH_PERIOD:g} s of {context.duration:g} s"
    rows = tuple(
        (
            str(each.seed),
            f"{each.impulse:.1f} N s",
            "yes" if each.fell else "no",
            f"{each.lead:.2f} s" if each.fell else "",
            f"{each.tilt:.0f}",
            ", ".join(f"{part} {speed:.1f} m/s" for part, speed in each.speed.items()),
            "yes" if each.walks_on else "no",
        )
        for each in result.falls
    )
    head = ("seed", "push", "fell", "noticed before", "at degrees", "reached the ground", "walks on")
    page = ReportPage(
        name="falls",
        title=f"Pushes that fell a walking robot{few_words(result.n)}",
        source="Not in the thesis.",
        setup=setup_rows(
            context,
            [
                ("gait", context.changes.gait),
                ("push", f"{push}, on the torso in any level direction, 50 ms"),
            ],
        ),
        claims=claims(result),
        tables=(ReportTable("Pushes", head, rows),),
        findings=(f"After {result.needless} pushes the robot gave way and did not fall.",),
    )
    return Outcome(result, page)
