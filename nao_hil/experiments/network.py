"""Success of walks in real time over delay, jitter and loss of the network.

Robot and walker run in two network namespaces; between them packets are delayed and dropped
(`nao_hil.network_emulation`). The link is TCP: a lost packet is late, not missing, and holds up those behind
it.
"""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Final, NamedTuple

from nao_hil.analysis.report.page import Outcome
from nao_hil.experiments.context import Context
from nao_hil.experiments.network_map import FEW_STEPS, STEPS, NetworkMap, cell_of, draw, map_page
from nao_hil.network_emulation import NetworkConditions, Site
from nao_hil.network_emulation.walks import NetworkWalk, Pair, options, walk_key
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.store import stored

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


def experiment(context: Context) -> Outcome:
    """The map; each cell with one walk per seed, seed by seed, several at a time.

    Raises:
        LinkError: no root, no namespaces, or a process failed.
        Interrupted: stopped before every cell had a walk.
    """
    gaits = (context.gait,) if context.gait else GAITS
    kinds = [
        (gait, NetworkConditions(delay=delay, jitter=jitter, loss=loss))
        for gait, loss, jitter, delay in itertools.product(gaits, LOSSES, JITTERS, DELAYS)
        if jitter <= delay
    ]
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
    cells = [cell_of(gait, conditions, walks) for (gait, conditions), walks in of_kind.items()]
    calm = all(c.success == c.n for c in cells if c.delay == c.jitter == c.loss == 0.0)
    result = NetworkMap(passed=calm, n=min(c.n for c in cells), cells=cells)
    picture = context.out / "network.png"
    draw(cells, picture)
    return Outcome(result, map_page(context, result, picture))


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
