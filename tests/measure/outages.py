"""Outages of the link and of either process during a walk: reaction of the robot, and completion of the walk.

The guard (`bridge.guard`) promises: a short silence is bridged, a longer one held, then the robot crouches
and lets go; any controller may take it afterwards. Only killed processes are started again.
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
from bridge.recording.playback import read_recording
from nao_hil.analysis.report.render import Claim, ReportTable, table, yes_no
from nao_hil.experiments.context import Context
from nao_hil.experiments.experiment import Experiment
from nao_hil.runs.campaign import Interrupted
from tests.measure.network_walks import Pair, options, walk_key
from tests.measure.site import NetworkConditions, Site
from tests.measure.stored import stored

STEPS: Final = {"static": 6, "dynamic": 30}
"""Of a walk, by gait; it lasts some 20 s."""
OUTAGES: Final = (0.1, 0.5, 2.0, 10.0)
"""s"""
EVENTS: Final = (*(f"outage of {length:g} s" for length in OUTAGES), "walker killed", "robot killed")
WALKING: Final = 8.0
"""s after the walker found the robot, by which it walks."""
SPREAD: Final = 4.0
"""s after that within which it happens: a step of the static gait."""
TIMEOUT: Final = 120.0
"""s for everything afterwards."""
KILLED: Final = 1.0
"""s between death and new start."""


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
    walker: str
    """The walker's last message; empty: it ended by order."""
    notices: list[str]
    """Codes of the notices in order, without the routine ones."""
    recordings: list[int]
    """Messages that can be read of each recording."""
    seconds: float
    """From the event to the end of the walk."""

    @property
    def note(self) -> str:
        """How it ended, in a word or two."""
        return ("walked" if self.walked else "gave up") + (" after a fall" if self.fell else "")


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
    """Promises of the guard and the results of the walks."""
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
            "After each event the walk is completed; only killed processes are started again",
            f"{walked} of {len(walks)}",
            walked == len(walks),
        ),
        Claim("No robot falls", f"{upright} of {len(walks)} upright", upright == len(walks)),
        Claim(
            "Every recording can be read",
            f"{readable} of {len(walks)}",
            readable == len(walks),
        ),
    )


class OutageTask(NamedTuple):
    """One walk to be made."""

    gait: str
    what: str
    seed: int


def measure(context: Context) -> list[OutageWalk]:
    """Each event once per gait and seed, several walks at a time.

    Raises:
        LinkError: no root, no namespaces, or a process failed.
        Interrupted: stopped before the end.
    """
    tasks = [OutageTask(gait, what, seed) for seed in context.seeds for gait in STEPS for what in EVENTS]
    key = walk_key(context.changes)

    def walk(task: OutageTask) -> OutageWalk:
        folder = context.out / "walks" / f"{task.gait}-{task.what.replace(' ', '-')}-{task.seed}"
        return stored(folder / "result.json", key, OutageWalk, lambda: _walk(context, task, folder))

    done = context.campaign.watch(walk, tasks, lambda task, result: (f"{task.gait}, {task.what}", result.note))
    walks = [each for each in done if each is not None]
    if len(walks) < len(tasks):
        raise Interrupted
    return walks


COLUMNS: Final = {
    "gait": "{0.gait}",
    "event": "{0.what}",
    "at, s": "{0.moment:.1f}",
    "walked to the end": lambda walk: yes_no(walk.walked),
    "fell": lambda walk: yes_no(walk.fell),
    "notices": lambda walk: ", ".join(walk.notices) or "none",
    "s": "{0.seconds:.1f}",
}
OUTAGES: Final = Experiment(
    title="Outages of the link and of the processes",
    source="No part of the thesis.",
    setup=lambda _: [
        ("walk", " or ".join(f"{n} steps of the {gait} gait" for gait, n in STEPS.items()) + " in real time"),
        ("event", f"{WALKING:g} to {WALKING + SPREAD:g} s after the walker found the robot"),
    ],
    measure=measure,
    quantities=lambda measured: {"walks": measured.results},
    claims=lambda measured: outage_claims(measured.results),
    tables=lambda measured: [
        ReportTable(
            "By event",
            ("gait", "event", "walked to the end", "upright", "of"),
            rows_by_event(measured.results),
        ),
        table("Each walk", measured.results, COLUMNS),
    ],
)


def _walk(context: Context, task: OutageTask, folder: Path) -> OutageWalk:
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
            site.link.set(NetworkConditions(outage=True))
            time.sleep(float(what.split()[-2]))
            site.link.set(NetworkConditions())
        pair.wait(TIMEOUT, lambda: context.campaign.interrupted)
        seconds = time.monotonic() - began
        end = pair.end()
        read = [_read(path) for path in pair.recordings]
    if context.campaign.interrupted:
        raise Interrupted
    return OutageWalk(
        gait=gait,
        what=what,
        seed=seed,
        moment=moment,
        walked=end.done,
        fell=end.fell,
        walker=end.walker,
        notices=[code for _, codes in read for code in codes],
        recordings=[count for count, _ in read],
        seconds=seconds,
    )


def _until_found(pair: Pair) -> None:
    """Wait until the walker reports that it found the robot."""
    deadline = time.monotonic() + TIMEOUT
    while time.monotonic() < deadline and pair.robot.running and pair.walker.running:
        if "found" in pair.walker.stderr:
            return
        time.sleep(0.05)


def _read(path: Path) -> tuple[int, list[str]]:
    """Messages that can be read, and the codes of the notices among them; (0, none) when it cannot be read."""
    codes: list[str] = []
    count = 0
    try:
        for recorded in read_recording(path):
            count += 1
            if isinstance(recorded.message, Notice) and not recorded.message.routine:
                codes.append(recorded.message.code)
    except ConfigurationError:
        return 0, []
    return count, codes
