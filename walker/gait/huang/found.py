"""The choice of a configuration: named, kept from an earlier search, or searched now."""

from __future__ import annotations

from typing import NamedTuple

from bridge.datasheet import Body
from walker.arms import ARMS
from walker.gait.huang import cache
from walker.gait.huang.hip import Choice
from walker.gait.huang.parameters import HuangParameters
from walker.gait.huang.search import Cycle, Progress, admissible, search


class Found(NamedTuple):
    """A choice and where it is from."""

    choice: Choice
    margin: float
    """m"""
    kept: bool
    """From an earlier search."""


def find(p: HuangParameters, body: Body, *, fresh: bool = False, progress: Progress = lambda _: None) -> Found:
    """Where the hip is at the ends of single support; what the parameters leave open is searched.

    Args:
        p: parameters.
        body: data sheet.
        fresh: search, whatever is kept.
        progress: told what is being searched.

    Raises:
        ConfigurationError: parameters out of their bounds, or poses out of the legs' reach.
    """
    name = cache.key(p, body)
    kept = None if fresh else cache.load(name)
    if kept is not None and admissible(p, kept.choice):
        return Found(kept.choice, kept.margin, kept=True)
    plan = search(Cycle(p, body, ARMS), progress)
    cache.store(name, cache.CachedChoice(choice=plan.choice, margin=plan.margin))
    return Found(plan.choice, plan.margin, kept=False)


def chosen(p: HuangParameters, body: Body) -> Choice:
    """The choice alone; without a search where the parameters name all of it.

    Raises:
        ConfigurationError: as for `find`.
    """
    if p.x_sd is not None and p.x_ed is not None and p.y_d is not None and p.y_m is not None:
        return Choice(p.x_sd, p.x_ed, p.y_d, p.y_m)
    return find(p, body).choice
