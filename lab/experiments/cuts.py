"""The line is cut in mid-walk, or a side is killed and started again: what the robot does, and what follows.

What the guard promises (`bridge.guard`): a short silence is bridged, a longer one held, then the robot crouches
and lets go; whoever asks afterwards may walk again. Nothing is started by hand but what was killed.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Final

import msgspec

from bridge.errors import ConfigurationError
from bridge.guard import GuardSettings
from bridge.messages import Notice
from bridge.playback import read_recording
from lab.campaign.campaign import Interrupted
from lab.experiments.context import Context
from lab.experiments.page import Claim, Outcome, Page, Table
from lab.weather import Site, Weather
from lab.weather.walks import Pair, options

GAIT: Final = "static"
STEPS: Final = 6
CUTS: Final = (0.1, 0.5, 2.0, 10.0)
"""s"""
WALKING: Final = 8.0
"""s of robot time before it happens, by which the robot walks."""
PATIENCE: Final = 120.0
"""s for everything afterwards."""
KILLED: Final = 1.0
"""s between death and new start."""


class CutWalk(msgspec.Struct, frozen=True, kw_only=True):
    """One walk that something happened to."""

    what: str
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


class Cuts(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil experiment cuts`."""

    name: str = "cuts"
    passed: bool
    walks: list[CutWalk]


def experiment(context: Context) -> Outcome:
    """Each event once per seed.

    Raises:
        LinkError: no root, no namespaces, or a process failed.
        Interrupted: stopped before the end.
    """
    walks = []
    for seed in context.seeds:
        for what in (*(f"line cut for {cut:g} s" for cut in CUTS), "walker killed", "robot killed"):
            if context.campaign.interrupted:
                raise Interrupted
            walks.append(_walk(context, what, seed))
    claims = _claims(walks)
    result = Cuts(passed=all(claim.holds for claim in claims), walks=walks)
    rows = tuple(
        (
            walk.what,
            "yes" if walk.walked else "no",
            "yes" if walk.fell else "no",
            ", ".join(walk.notices) or "none",
            f"{walk.seconds:.1f}",
        )
        for walk in walks
    )
    page = Page(
        name="cuts",
        title="A line that is cut, sides that die",
        source="No part of the thesis.",
        setup=(
            ("robot", f"{context.robot}, {context.wear} drives and sensors"),
            ("walk", f"{STEPS} steps of the {GAIT} gait in real time; it happens after {WALKING:g} s"),
        ),
        claims=claims,
        tables=(Table("What happened", ("event", "walked to the end", "fell", "notices", "s"), rows),),
    )
    return Outcome(result, page)


def _walk(context: Context, what: str, seed: int) -> CutWalk:
    folder = context.out / "walks" / f"{what.replace(' ', '-')}-{seed}"
    with Site(seed) as site, Pair(site, folder, *options(context.changes, GAIT, seed, STEPS)) as pair:
        _until_walking(pair)
        began = time.monotonic()
        if what == "walker killed":
            pair.walker.kill()
            time.sleep(KILLED)
            pair.start_walker()
        elif what == "robot killed":
            pair.robot.kill()
            time.sleep(KILLED)
            pair.start_robot()
        else:
            site.line.set(Weather(cut=True))
            time.sleep(float(what.split()[-2]))
            site.line.set(Weather())
        pair.wait(PATIENCE, lambda: context.campaign.interrupted)
        seconds = time.monotonic() - began
        end = pair.end()
        heard = [_read(path) for path in pair.recordings]
    return CutWalk(
        what=what,
        walked=end.done,
        fell=end.fell,
        notices=[code for _, codes in heard for code in codes],
        recordings=[count for count, _ in heard],
        seconds=seconds,
    )


def _until_walking(pair: Pair) -> None:
    """Wait until the recording, which is written as it goes, holds some seconds."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline and pair.robot.running and pair.walker.running:
        time.sleep(0.25)
        if "found" in pair.walker.said:
            break
    time.sleep(WALKING)


def _read(path: Path) -> tuple[int, list[str]]:
    """Messages that can be read, and the codes of the notices among them; (0, none) when it cannot be read."""
    codes: list[str] = []
    count = 0
    try:
        for recorded in read_recording(path):
            count += 1
            if isinstance(recorded.message, Notice) and recorded.message.code != "guard-active":
                codes.append(recorded.message.code)
    except ConfigurationError:
        return 0, []
    return count, codes


def _claims(walks: list[CutWalk]) -> tuple[Claim, ...]:
    watchdog = GuardSettings().watchdog
    bridged = 0.01 * watchdog.silence
    short = [w for w in walks if w.what.startswith("line") and float(w.what.split()[-2]) < bridged]
    walked, upright = sum(w.walked for w in walks), sum(not w.fell for w in walks)
    readable = sum(all(w.recordings) for w in walks)
    return (
        Claim(
            f"A cut shorter than {bridged:g} s is bridged without a crouch",
            ", ".join(w.what for w in short if "guard-crouch" not in w.notices) or "none",
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
