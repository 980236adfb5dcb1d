"""Getting up from wherever a robot fell: dropped limp, any side first, with any angles of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from emulator.servo.parameters import Heating
from nao_hil.analysis.report.page import Claim, Outcome, Picture, ReportPage, ReportTable
from nao_hil.analysis.statistics import few_words, wilson
from nao_hil.experiments import axes
from nao_hil.experiments.context import Context
from nao_hil.experiments.get_up_run import DROP, HOLD, WITHIN, Course, Drop, get_up
from nao_hil.experiments.setup import seed_words
from nao_hil.runs.campaign import Interrupted

SHARE: Final = {"worn": 0.80}
"""Of the drops after which it is to stand, by wear."""
USUAL: Final = 0.95
"""The same for any other wear."""
MEDIAN: Final = {"back": 8.0, "front": 6.0}
"""s in which half of those that stand are to do so."""
OVERLAP: Final = 0.003
"""m"""
_ROUNDING: Final = 1e-9
"""Of a current that the drive limits to the stall current."""
WARM: Final = Heating().warm
"""Degrees Celsius."""


class SideResult(msgspec.Struct, frozen=True, kw_only=True):
    """All drops that ended on one side."""

    n: int
    survived: int
    """Stood within the time."""
    interval: tuple[float, float]
    """Wilson's 95 % interval of the share."""
    median_s: float | None
    """Time of those that stood; None: none did."""
    tries: float
    """Mean number."""


class GetUpResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "get-up"
    passed: bool
    all: SideResult
    back: SideResult
    front: SideResult
    other: SideResult
    """On a side, or with the torso upright."""
    temperature: float
    """Of the hottest motor, degrees Celsius."""
    current: float
    """Largest of any motor, as a share of its stall current."""
    overlap: float
    """Deepest overlap of two limbs, m."""
    drops: tuple[Drop, ...]


def side(drops: Sequence[Drop]) -> SideResult:
    """The figures of some drops."""
    stood = [drop.time for drop in drops if drop.stands]
    return SideResult(
        n=len(drops),
        survived=len(stood),
        interval=wilson(len(stood), len(drops)),
        median_s=float(np.median(stood)) if stood else None,
        tries=float(np.mean([drop.tries for drop in drops])) if drops else 0.0,
    )


def judge(wear: str, drops: Sequence[Drop]) -> GetUpResult:
    """The verdict on all drops."""
    both = ("back", "front")
    sides = {name: side([drop for drop in drops if drop.began == name]) for name in both}
    result = GetUpResult(
        passed=False,
        all=side(drops),
        back=sides["back"],
        front=sides["front"],
        other=side([drop for drop in drops if drop.began not in both]),
        temperature=max(drop.temperature for drop in drops),
        current=max(drop.current for drop in drops),
        overlap=max(drop.overlap for drop in drops),
        drops=tuple(drops),
    )
    return msgspec.structs.replace(result, passed=all(claim.holds for claim in claims(wear, result)))


def claims(wear: str, result: GetUpResult) -> tuple[Claim, ...]:
    """The claims, each with the measured value."""
    share, low = SHARE.get(wear, USUAL), result.all.interval[0]
    stood = f"{result.all.survived} of {result.all.n} (95 % interval {low:.0%} to {result.all.interval[1]:.0%})"
    return (
        Claim(
            f"Of all drops {share:.0%} stand within {WITHIN:g} s, by the lower bound of the interval",
            stood,
            low >= share,
        ),
        *(
            Claim(
                f"From the {name} half of those that stand do so within {MEDIAN[name]:g} s",
                "none stood" if found.median_s is None else f"{found.median_s:.1f} s",
                found.median_s is not None and found.median_s <= MEDIAN[name],
            )
            for name, found in (("back", result.back), ("front", result.front))
            if found.n
        ),
        Claim(
            f"No motor is warmer than {WARM:g} degrees Celsius, where its board begins to lower the stiffness",
            f"{result.temperature:.1f} degrees Celsius",
            result.temperature < WARM,
        ),
        Claim(
            "No motor draws more than its stall current",
            f"{result.current:.0%} of it",
            result.current <= 1.0 + _ROUNDING,
        ),
        Claim(
            f"No two limbs overlap by more than {1e3 * OVERLAP:g} mm",
            f"{1e3 * result.overlap:.2f} mm",
            result.overlap <= OVERLAP,
        ),
    )


def dropped_courses(context: Context) -> list[Course]:
    """One drop per seed; those that are done when it was stopped.

    Raises:
        Interrupted: none is done.
    """
    configs = [msgspec.structs.replace(context.changes, seed=seed) for seed in context.seeds]
    courses: list[Course] = context.campaign.map("get-up", get_up, configs)
    if not courses:
        raise Interrupted
    return courses


def experiment(context: Context) -> Outcome:
    """One drop per seed."""
    courses = dropped_courses(context)
    result = judge(context.wear, [course.drop for course in courses])
    return Outcome(result, _page(context, result, courses))


def _page(context: Context, result: GetUpResult, courses: Sequence[Course]) -> ReportPage:
    rows = [
        (name, str(each.n), str(each.survived), _seconds(each.median_s), f"{each.tries:.1f}")
        for name, each in (("back", result.back), ("front", result.front), ("other", result.other))
    ]
    failed = [drop for drop in result.drops if not drop.stands]
    return ReportPage(
        name="get-up",
        title=f"Getting up after a fall of any kind{few_words(result.all.n)}",
        source="Not in the thesis.",
        setup=(
            ("robot", f"{context.robot}, {context.wear} drives and sensors"),
            ("seeds", seed_words([course.drop.seed for course in courses])),
            ("drop", f"limp, {DROP:g} m over the ground, any orientation and joint angles as likely"),
            ("stands", f"on its feet by the ground truth, and for {HOLD:g} s more"),
        ),
        claims=claims(context.wear, result),
        tables=(ReportTable("By what was below", ("below", "n", "stand", "median", "tries"), tuple(rows)),),
        pictures=(
            Picture(
                _plot(context.out / "get-up.png", courses),
                "Height of the torso",
                "Green: stands within the time. Red: does not.",
            ),
        ),
        findings=tuple(
            f"Seed {drop.seed}, {drop.began}: does not stand after {drop.time:.1f} s and {drop.tries} tries."
            for drop in failed
        ),
    )


def _seconds(time: float | None) -> str:
    return "" if time is None else f"{time:.1f} s"


def _plot(path: Path, courses: Sequence[Course]) -> Path:
    figure = axes.new_figure()
    panel = figure.subplots()
    for course in courses:
        colour = axes.GREEN if course.drop.stands else axes.RED
        panel.plot(course.time, course.height, color=colour, linewidth=0.6)
    panel.set(xlabel="time / s", ylabel="height of the torso / m")
    panel.grid(alpha=0.3)
    return axes.save(figure, path)
