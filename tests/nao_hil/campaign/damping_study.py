"""A study whose best point is known: parameters, robots, and a formula in the place of the walk."""

from __future__ import annotations

from collections.abc import Sequence

from nao_hil.campaigns.objective import Ensemble
from nao_hil.campaigns.study import Range
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk, WalkEnd
from tests.made_walks import walk_end

SPACE = {"controller.damping.roll": Range(0.0, 0.2), "controller.damping.pitch": Range(0.0, 0.2)}
ENSEMBLE = Ensemble(
    base=RunConfig(gait="dynamic"),
    robots=("nao-v3",),
    wears=("nominal",),
    scenarios=("flat",),
    first_seed=0,
    seeds=20,
    duration=10.0,
)


def ended(walk: Walk) -> WalkEnd:
    """Stands the longer the nearer the roll damping is to 0.05; the pitch damping makes no difference."""
    off = abs(walk.config.controller.get("damping", {}).get("roll", 0.2) - 0.05)
    alive = off < 0.02
    time = 10.0 if alive else max(0.1, 10.0 - 80.0 * off)
    return walk_end("walked" if alive else "fell", time, tilt_max=0.1 + off)


def attempt(walks: Sequence[Walk]) -> list[WalkEnd]:
    return [ended(walk) for walk in walks]
