"""Gaits on the same courses: same seeds and worlds, each gait paired with the first one."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

from nao_hil.analysis.report.render import Claim, Column, ReportTable, table
from nao_hil.analysis.statistics import Paired, wilson
from nao_hil.experiments.conditions import Condition, condition, pairs
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import bounded
from nao_hil.runs.walk import WalkOutcome

STANDS: Final = wilson(45, 50)[0]
"""A share counts as "45 of 50 stand" when the lower bound of its interval is at least that one's."""
Conditions = Mapping[str, Mapping[str, Condition]]
"""By course and gait."""


class CourseWalks(NamedTuple):
    """Walks over all courses."""

    walks: Mapping[str, Mapping[str, list[WalkOutcome]]]
    """By course and gait."""
    planned: int
    """Walks of all seeds."""

    @property
    def conditions(self) -> dict[str, dict[str, Condition]]:
        """By course and gait."""
        return {
            course: {gait: condition(found) for gait, found in by_gait.items()}
            for course, by_gait in self.walks.items()
        }

    def pairs(self, course: str, gait: str) -> Paired:
        """The first gait and another one on a course, seed by seed."""
        by_gait = self.walks[course]
        return pairs(next(iter(by_gait.values())), by_gait[gait])


def walk_courses(
    context: Context, name: str, tasks: Mapping[str, Mapping[str, Task]], share: float | None = None
) -> CourseWalks:
    """Walk all courses with all gaits.

    Args:
        context: Robot and seeds.
        name: Of the experiment.
        tasks: By course and gait.
        share: That is to stand: a course ends when its verdict is certain; None: all seeds walk.
    """
    planned = {
        (course, gait): task.walks(context, f"{name}, {course}, {gait}")
        for course, by_gait in tasks.items()
        for gait, task in by_gait.items()
    }
    found = context.run(planned) if share is None else context.run_until_certain(share, planned)
    walks = {course: {gait: found[course, gait] for gait in by_gait} for course, by_gait in tasks.items()}
    return CourseWalks(walks, sum(map(len, planned.values())))


def stand_claims(titles: Mapping[str, str], conditions: Conditions, course: str, *gaits: str) -> list[Claim]:
    """A claim for each gait that 45 of 50 stand on a course."""
    return [
        bounded(f"{titles[course]}: 45 of 50 stand, {gait}", conditions[course][gait], STANDS) for gait in gaits
    ]


def course_table(
    title: str, head: str, titles: Mapping[str, str], walks: CourseWalks, conditions: Conditions
) -> ReportTable:
    """Survivors and speed of each gait on each course, and McNemar's test of its pairs with the first one.

    Args:
        title: Of the table.
        head: Of the courses' column.
        titles: By course.
        walks: With the pairs.
        conditions: The walks, summed up.
    """
    first, *others = next(iter(conditions.values()))

    def stand(item: tuple[str, dict[str, Condition]], gait: str) -> str:
        return item[1][gait].words()

    def discordant(item: tuple[str, Any], gait: str) -> str:
        pair = walks.pairs(item[0], gait)
        return f"{pair.only_with} / {pair.only_without}, p = {pair.p_value:.2g}"

    columns: dict[str, Column] = {head: lambda item: titles[item[0]]}
    for gait in (first, *others):
        columns[f"{gait}: stand"] = functools.partial(stand, gait=gait)
        columns[f"{gait}: m/s over ground"] = f"{{0[1][{gait}].speed:.3f}}"
    for gait in others:
        columns[f"only {first} / only {gait}, McNemar"] = functools.partial(discordant, gait=gait)
    return table(title, conditions.items(), columns)
