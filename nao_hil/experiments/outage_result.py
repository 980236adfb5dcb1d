"""Result of the outages: each walk, the claims, and the table by event."""

from __future__ import annotations

from typing import Final

import msgspec

from bridge.guard import GuardSettings
from nao_hil.analysis.report.page import Claim

STEPS: Final = {"static": 6, "dynamic": 30}
"""Of a walk, by gait; it lasts some 20 s."""


OUTAGES: Final = (0.1, 0.5, 2.0, 10.0)
"""s"""


EVENTS: Final = (*(f"outage of {length:g} s" for length in OUTAGES), "walker killed", "robot killed")


class OutageWalk(msgspec.Struct, frozen=True, kw_only=True):
    """One walk that something happened to."""

    gait: str
    what: str
    seed: int
    moment: float
    """s from the walker's finding the robot to the event."""
    walked: bool
    """In the end all steps were made and the robot stands."""
    fell: bool
    """At any time."""
    notices: list[str]
    """Codes of what the robot said, in order, the usual ones left out."""
    recordings: list[int]
    """Messages that can be read of each recording."""
    seconds: float
    """From the event to the end of the walk."""

    @property
    def note(self) -> str:
        """How it ended, in a word or two."""
        return ("walked" if self.walked else "gave up") + (" after a fall" if self.fell else "")


class Outages(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil experiment outages`."""

    name: str = "outages"
    passed: bool
    walks: list[OutageWalk]


def rows_by_event(walks: list[OutageWalk]) -> tuple[tuple[str, ...], ...]:
    """How many walks of each gait and event completed, and how many stayed upright."""
    rows = []
    for gait in STEPS:
        for what in EVENTS:
            of = [walk for walk in walks if (walk.gait, walk.what) == (gait, what)]
            counts = sum(walk.walked for walk in of), sum(not walk.fell for walk in of), len(of)
            rows.append((gait, what, *map(str, counts)))
    return tuple(rows)


def outage_claims(walks: list[OutageWalk]) -> tuple[Claim, ...]:
    """Promises of the guard, beside what the walks did."""
    watchdog = GuardSettings().watchdog
    bridged = 0.01 * watchdog.silence_cycles
    short = [w for w in walks if w.what.startswith("outage") and float(w.what.split()[-2]) < bridged]
    walked, upright = sum(w.walked for w in walks), sum(not w.fell for w in walks)
    readable = sum(all(w.recordings) for w in walks)
    return (
        Claim(
            f"An outage shorter than {bridged:g} s is bridged without a crouch",
            f"{sum('guard-crouch' not in w.notices for w in short)} of {len(short)}",
            all("guard-crouch" not in w.notices for w in short),
        ),
        Claim(
            "After each event the walk is made to its end, with nothing started by hand but what was killed",
            f"{walked} of {len(walks)}",
            walked == len(walks),
        ),
        Claim("Nobody falls", f"{upright} of {len(walks)} upright", upright == len(walks)),
        Claim(
            "Every recording can be read",
            f"{readable} of {len(walks)}",
            readable == len(walks),
        ),
    )
