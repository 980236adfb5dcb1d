"""Outages of the link and of either process during a walk: what the robot does, and whether the walk completes.

What the guard promises (`bridge.guard`): a short silence is bridged, a longer one held, then the robot crouches
and lets go; whoever asks afterwards may walk again. Nothing is started by hand but what was killed.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from bridge.errors import ConfigurationError
from bridge.messages import Notice
from bridge.recording.playback import read_recording
from nao_hil.analysis.report.page import Outcome, ReportPage, ReportTable
from nao_hil.experiments.context import Context
from nao_hil.experiments.outage_result import EVENTS, STEPS, Outages, OutageWalk, outage_claims, rows_by_event
from nao_hil.network_emulation import NetworkConditions, Site
from nao_hil.network_emulation.walks import Pair, options, walk_key
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.store import stored

WALKING: Final = 8.0
"""s after the walker found the robot, by which it walks."""


SPREAD: Final = 4.0
"""s after that within which it happens: a step of the static gait."""


TIMEOUT: Final = 120.0
"""s for everything afterwards."""


KILLED: Final = 1.0
"""s between death and new start."""


class OutageTask(NamedTuple):
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
    tasks = [OutageTask(gait, what, seed) for seed in context.seeds for gait in STEPS for what in EVENTS]
    key = walk_key(context.changes)

    def walk(task: OutageTask) -> OutageWalk:
        folder = context.out / "walks" / f"{task.gait}-{task.what.replace(' ', '-')}-{task.seed}"
        return stored(folder / "result.json", key, OutageWalk, lambda: _walk(context, task, folder))

    done = context.campaign.watch(walk, tasks, lambda task, result: (f"{task.gait}, {task.what}", result.note))
    walks = [each for each in done if each is not None]
    if len(walks) < len(tasks):
        raise Interrupted
    claims = outage_claims(walks)
    result = Outages(passed=all(claim.holds for claim in claims), walks=walks)
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
    page = ReportPage(
        name="outages",
        title="Outages of the link and of the processes",
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
            ReportTable(
                "By event", ("gait", "event", "walked to the end", "upright", "of"), rows_by_event(walks)
            ),
            ReportTable("Each walk", head, rows),
        ),
    )
    return Outcome(result, page)


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
        heard = [_read(path) for path in pair.recordings]
    if context.campaign.interrupted:
        raise Interrupted
    return OutageWalk(
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
