"""Success of walks in real time over delay, jitter and loss of the network.

Robot and walker run in two network namespaces; between them packets are delayed and dropped
(`tests.measure.site`). The link is TCP: a lost packet is late, not missing, and holds up those behind
it.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

import msgspec
from matplotlib.figure import Figure

from nao_hil.analysis.report.render import Claim, ReportTable
from nao_hil.analysis.statistics import Share
from nao_hil.experiments.context import Context
from nao_hil.experiments.experiment import Drawing, Experiment, Measured
from nao_hil.runs.campaign import Interrupted
from tests.measure.network_walks import NetworkWalk, Pair, options, walk_key
from tests.measure.site import NetworkConditions, Site
from tests.measure.stored import stored

STEPS: Final = {"omni": 16}
"""Of a walk, by gait; `FEW_STEPS` of the others."""
FEW_STEPS: Final = 4
GAITS: Final = ("static", "dynamic")
"""Unless one is named."""
DELAYS: Final = (0.0, 0.005, 0.010, 0.020)
"""s, one way."""
JITTERS: Final = (0.0, 0.005)
"""s, each way."""
LOSSES: Final = (0.0, 0.01)
"""Fraction of packets, each way."""
TIMEOUT: Final = 120.0
"""s for a walk of a few steps, which takes under 40 over a good network on an idle machine."""


class NetworkCell(msgspec.Struct, frozen=True, kw_only=True):
    """The walks of one gait under the same network conditions."""

    gait: str
    delay: float
    jitter: float
    loss: float
    completed: Share
    """Walks that made all their steps."""
    stopped: int
    """Walks that the walker ended because of the link."""
    fell: int
    missed: float
    """Fraction of cycles without a timely answer, mean."""
    torso_max: float
    """rad, mean."""


def cell_of(gait: str, conditions: NetworkConditions, walks: list[NetworkWalk]) -> NetworkCell:
    """The walks of one gait and one set of network conditions, summed up."""
    return NetworkCell(
        gait=gait,
        delay=conditions.delay,
        jitter=conditions.jitter,
        loss=conditions.loss,
        completed=Share(n=len(walks), survived=sum(walk.success for walk in walks)),
        stopped=sum(walk.stopped for walk in walks),
        fell=sum(walk.fell for walk in walks),
        missed=sum(walk.missed / max(1, walk.cycles) for walk in walks) / len(walks),
        torso_max=sum(walk.torso_max for walk in walks) / len(walks),
    )


def draw(figure: Figure, measured: Measured[list[NetworkCell]]) -> None:
    """One map per gait and loss: delay to the right, jitter upwards."""
    cells = measured.results
    gaits, losses = list(dict.fromkeys(c.gait for c in cells)), sorted({c.loss for c in cells})
    delays, jitters = sorted({c.delay for c in cells}), sorted({c.jitter for c in cells})
    figure.set_size_inches(4.2 * len(losses), 2.3 * len(gaits))
    panels = figure.subplots(len(gaits), len(losses), squeeze=False)
    for (i, gait), (j, loss) in itertools.product(enumerate(gaits), enumerate(losses)):
        panel = panels[i][j]
        grid = [[float("nan")] * len(delays) for _ in jitters]
        for c in cells:
            if (c.gait, c.loss) == (gait, loss):
                y, x = jitters.index(c.jitter), delays.index(c.delay)
                grid[y][x] = c.completed.survival_ratio
                text = f"{c.completed.survived}/{c.completed.n}\n{c.stopped} stopped\n{c.fell} fell"
                panel.text(x, y, text, ha="center", va="center", size=7)
        panel.imshow(grid, origin="lower", vmin=0.0, vmax=1.0, cmap="RdYlGn", aspect="auto", alpha=0.8)
        panel.set_xticks(range(len(delays)), [f"{1e3 * d:g}" for d in delays])
        panel.set_yticks(range(len(jitters)), [f"{1e3 * d:g}" for d in jitters])
        panel.set_title(f"{gait} gait, {100 * loss:g} % loss", size=9)
        panel.set(xlabel="delay one way, ms", ylabel="jitter, ms")


class NetworkTask(NamedTuple):
    """One walk to be made."""

    gait: str
    conditions: NetworkConditions
    seed: int

    @property
    def name(self) -> str:
        """For its folder, and for people."""
        w = self.conditions
        return f"{self.gait}-{1e3 * w.delay:g}-{1e3 * w.jitter:g}-{100 * w.loss:g}-{self.seed}"


def _gaits(context: Context) -> Sequence[str]:
    return (context.gait,) if context.gait else GAITS


def measure(context: Context) -> list[NetworkCell]:
    """The map; each cell with one walk per seed, seed by seed, several at a time.

    Raises:
        LinkError: no root, no namespaces, or a process failed.
        Interrupted: stopped before every cell had a walk.
    """
    kinds = [
        (gait, NetworkConditions(delay=delay, jitter=jitter, loss=loss))
        for gait, loss, jitter, delay in itertools.product(_gaits(context), LOSSES, JITTERS, DELAYS)
        if jitter <= delay
    ]
    return _cells(context, kinds)


NETWORK: Final = Experiment(
    title="Walks over a bad network",
    source="No part of the thesis, whose controller ran on the robot.",
    setup=lambda measured: [
        ("walk", f"{STEPS.get(gait, FEW_STEPS)} steps of {gait}, in real time, in two network namespaces, TCP")
        for gait in _gaits(measured.context)
    ],
    measure=measure,
    quantities=lambda measured: {"n": min(c.completed.n for c in measured.results), "cells": measured.results},
    claims=lambda measured: [
        Claim(
            f"The {c.gait} gait walks over an ideal network",
            f"{c.completed.survived} of {c.completed.n}",
            c.completed.survived == c.completed.n,
        )
        for c in measured.results
        if c.delay == c.jitter == c.loss == 0.0
    ],
    pictures=(
        Drawing(
            "network.png", draw, "Fraction of walks that made all their steps", "Delay and jitter are one way."
        ),
    ),
    tables=lambda measured: [_table(measured.results)],
)


def _cells(context: Context, kinds: Sequence[tuple[str, NetworkConditions]]) -> list[NetworkCell]:
    """One walk per seed of each gait and conditions, seed by seed, summed up. Raises as `experiment`."""
    tasks = [NetworkTask(gait, conditions, seed) for seed in context.seeds for gait, conditions in kinds]
    key = walk_key(context.changes)

    def walk(task: NetworkTask) -> NetworkWalk:
        folder = context.out / "walks" / task.name
        return stored(folder / "result.json", key, NetworkWalk, lambda: _walk(context, task, folder))

    walked = context.campaign.watch(walk, tasks, lambda task, result: (task.name, result.note))
    of_kind: dict[tuple[str, NetworkConditions], list[NetworkWalk]] = {kind: [] for kind in kinds}
    for task, one in zip(tasks, walked, strict=True):
        if one is not None:
            of_kind[task.gait, task.conditions].append(one)
    if not all(of_kind.values()):
        raise Interrupted
    return [cell_of(gait, conditions, walks) for (gait, conditions), walks in of_kind.items()]


def _table(cells: Sequence[NetworkCell]) -> ReportTable:
    head = (
        *("gait", "delay, ms", "jitter, ms", "loss, %", "walked", "95 %"),
        *("stopped", "fell", "missed cycles, %"),
    )
    rows = tuple(
        (
            c.gait,
            f"{1e3 * c.delay:g}",
            f"{1e3 * c.jitter:g}",
            f"{1e2 * c.loss:g}",
            f"{c.completed.survived} of {c.completed.n}",
            "{:.2f} to {:.2f}".format(*c.completed.interval),
            str(c.stopped),
            str(c.fell),
            f"{1e2 * c.missed:.1f}",
        )
        for c in cells
    )
    return ReportTable("Network conditions and success", head, rows)


def _walk(context: Context, task: NetworkTask, folder: Path) -> NetworkWalk:
    robot, walker = options(context.changes, task.gait, task.seed, STEPS.get(task.gait, FEW_STEPS))
    with Site(task.seed) as site, Pair(site, folder, robot, walker) as pair:
        site.link.set(task.conditions)
        pair.wait(TIMEOUT, lambda: context.campaign.interrupted)
        end = pair.end()
        recordings = pair.recordings
    if context.campaign.interrupted:
        raise Interrupted
    if not end.fell:  # hundreds of walks; those that fell are worth a look
        for recording in recordings:
            recording.unlink(missing_ok=True)
    return end
