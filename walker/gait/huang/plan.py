"""The choice of a configuration: named, kept from an earlier search, or searched now."""

from __future__ import annotations

from functools import lru_cache

import msgspec

from bridge.datasheet import Body
from walker.arms import ARMS
from walker.gait.huang import cache
from walker.gait.huang.hip import Choice
from walker.gait.huang.parameters import HuangParameters
from walker.gait.huang.search import Cycle, search


def chosen(p: HuangParameters, body: Body) -> Choice:
    """Where the hip is at the ends of single support; what the parameters leave open is searched.

    Raises:
        ConfigurationError: parameters out of their bounds, or poses out of the legs' reach.
    """
    if p.x_sd is not None and p.x_ed is not None and p.y_d is not None and p.y_m is not None:
        return Choice(p.x_sd, p.x_ed, p.y_d, p.y_m)
    return _kept(cache.key(p, body), msgspec.json.encode((p, body))).choice


@lru_cache(maxsize=32)
def _kept(name: str, configuration: bytes) -> cache.CachedChoice:
    """By the name of a configuration, and the configuration itself in a form that can be hashed."""
    found = cache.load(name)
    if found is None:
        p, body = msgspec.json.decode(configuration, type=tuple[HuangParameters, Body])
        plan = search(Cycle(p, body, dict(ARMS)))
        found = cache.CachedChoice(choice=plan.choice, margin=plan.margin)
        cache.store(name, found)
    return found
