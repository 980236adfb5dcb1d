"""The line is cut in mid-walk, or a side is killed and started again: what the robot does, and what follows.

What the guard promises (`bridge.guard`): a short silence is bridged, a longer one held, then the robot crouches
and lets go; whoever asks afterwards may walk again. Nothing is started by hand but what was killed.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Final, NamedTuple

import msgspec
import numpy as np

from bridge.errors import ConfigurationError
from bridge.guard import GuardSettings
from bridge.messages import Notice
from bridge.playback import read_recording
from lab.campaign.campaign import Interrupted
from lab.experiments.context import Context
from lab.experiments.page import Claim, Outcome, Page, Table
from lab.weather import Site, Weather
from lab.weather.kept import depends_on, kept
from lab.weather.walks import Pair, options

STEPS: Final = {"static": 6, "dynamic": 30}
"""Of a walk, by gait; it lasts some 20 s."""
CUTS: Final = (0.1, 0.5, 2.0, 10.0)
"""s"""
EVENTS: Final = (*(f"line cut for {cut:g} s" for cut in CUTS), "walker killed", "robot killed")
WALKING: Final = 8.0
"""s after the walker found the robot, by which it walks."""
SPREAD: Final = 4.0
"""s after that within which it happens: a step of the static gait."""
PATIENCE: Final = 120.0
"""s for everything afterwards."""
KILLED: Final = 1.0
"""s between death and new start."""


class CutWalk(msgspec.Struct, frozen=True, kw_only=True):
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


class Cuts(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil experiment cuts`."""

    name: str = "cuts"
    passed: bool
    walks: list[CutWalk]


class Task(NamedTuple):
    """One walk to be made."""

    gait: str
    what: str
    seed: int


def experiment(context: Context) -> Outcome:
    """Each event once per gait and seed, several walks at a time.

    Raises:
        LinkError: no root, no namespaces, or a process failed.
        Interrupted: stopped before the end.
    """
    tasks = [Task(gait, what, seed) for seed in context.seeds for gait in STEPS for what in EVENTS]
    key = depends_on(context.changes)

    def walk(task: Task) -> CutWalk:
        folder = context.out / "walks" / f"{task.gait}-{task.what.replace(' ', '-')}-{task.seed}"
        return kept(folder / "result.json", key, CutWalk, lambda: _walk(context, task, folder))

    done = context.campaign.watch(walk, tasks, lambda task, result: (f"{task.gait}, {task.what}", result.note))
    walks = [each for each in done if each is not None]
    if len(walks) < len(tasks):
        raise Interrupted
    claims = _claims(walks)
    result = Cuts(passed=all(claim.holds for claim in claims), walks=walks)
    rows = tuple(
        (
            walk.gait,
            walk.what,
            f"{walk.moment:.1f}",
            "yes" if walk.walked else "no",
            "yes" if walk.fell else "no",
            ", ".join(walk.notices) or "none",
            f"{walk.seconds:.1f}",
        )
        for walk in walks
    )
    head = ("gait", "event", "at, s", "walked to the end", "fell", "notices", "s")
    page = Page(
        name="cuts",
        title="A line that is cut, sides that die",
        source="No part of the thesis.",
        setup=(
            ("robot", f"{context.robot}, {context.wear} drives and sensors"),
            (
                "walk",
                f"{' or '.join(f'{n} steps of the {gait} gait' for gait, n in STEPS.items())} in real time; "
                f"it happens {WALKING:g} to {WALKING + SPREAD:g} s after the walker found the robot",
            ),
        ),
        claims=claims,
        tables=(
            Table("By event", ("gait", "event", "walked to the end", "upright", "of"), _by_event(walks)),
            Table("Each walk", head, rows),
        ),
    )
    return Outcome(result, page)


def _walk(context: Context, task: Task, folder: Path) -> CutWalk:
    gait, what, seed = task
    moment = WALKING + SPREAD * float(np.random.default_rng(seed).uniform())
    with Site(seed) as site, Pair(site, folder, *options(context.changes, gait, seed, STEPS[gait])) as pair:
        _until_found(pair)
        time.sleep(moment)
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
    if context.campaign.interrupted:
        raise Interrupted
    return CutWalk(
        gait=gait,
        what=what,
        seed=seed,
        moment=moment,
        walked=end.done,
        fell=end.fell,
        notices=[code for _, codes in heard for code in codes],
        recordings=[count for count, _ in heard],
        seconds=seconds,
    )


def _until_found(pair: Pair) -> None:
    """Wait until the walker says that it found the robot."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline and pair.robot.running and pair.walker.running:
        if "found" in pair.walker.said:
            return
        time.sleep(0.05)


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


def _by_event(walks: list[CutWalk]) -> tuple[tuple[str, ...], ...]:
    rows = []
    for gait in STEPS:
        for what in EVENTS:
            of = [walk for walk in walks if (walk.gait, walk.what) == (gait, what)]
            counts = sum(walk.walked for walk in of), sum(not walk.fell for walk in of), len(of)
            rows.append((gait, what, *map(str, counts)))
    return tuple(rows)


def _claims(walks: list[CutWalk]) -> tuple[Claim, ...]:
    watchdog = GuardSettings().watchdog
    bridged = 0.01 * watchdog.silence
    short = [w for w in walks if w.what.startswith("line") and float(w.what.split()[-2]) < bridged]
    walked, upright = sum(w.walked for w in walks), sum(not w.fell for w in walks)
    readable = sum(all(w.recordings) for w in walks)
    return (
        Claim(
            f"A cut shorter than {bridged:g} s is bridged without a crouch",
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
