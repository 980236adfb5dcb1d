"""Result, page and figure of the walks over an emulated network."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Final

import msgspec

from nao_hil.analysis.report.page import Claim, Picture, ReportPage, ReportTable
from nao_hil.analysis.statistics import wilson
from nao_hil.experiments.context import Context
from nao_hil.files import atomic_path
from nao_hil.network_emulation import NetworkConditions
from nao_hil.network_emulation.walks import NetworkWalk

STEPS: Final = {"omni": 16}
"""Of a walk, by gait; `FEW_STEPS` of the others."""
FEW_STEPS: Final = 4


class NetworkCell(msgspec.Struct, frozen=True, kw_only=True):
    """The walks of one gait under the same network conditions."""

    gait: str
    delay: float
    jitter: float
    loss: float
    n: int
    success: int
    interval: tuple[float, float]
    """Of the success ratio, 95 %."""
    stopped: int
    """Walks that the walker ended because the link was worse than it bears."""
    fell: int
    missed: float
    """Fraction of cycles without a timely answer, mean."""
    torso_max: float
    """rad, mean."""


class NetworkMap(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil experiment network`."""

    name: str = "network"
    passed: bool
    n: int
    cells: list[NetworkCell]


def cell_of(gait: str, conditions: NetworkConditions, walks: list[NetworkWalk]) -> NetworkCell:
    """The walks of one gait and one set of network conditions, summed up."""
    success = sum(walk.success for walk in walks)
    return NetworkCell(
        gait=gait,
        delay=conditions.delay,
        jitter=conditions.jitter,
        loss=conditions.loss,
        n=len(walks),
        success=success,
        interval=wilson(success, len(walks)),
        stopped=sum(walk.stopped for walk in walks),
        fell=sum(walk.fell for walk in walks),
        missed=sum(walk.missed / max(1, walk.cycles) for walk in walks) / len(walks),
        torso_max=sum(walk.torso_max for walk in walks) / len(walks),
    )


def map_page(context: Context, result: NetworkMap, picture: Path) -> ReportPage:
    """Claims, map and table of the walks."""
    head = (
        "gait",
        "delay, ms",
        "jitter, ms",
        "loss, %",
        "walked",
        "95 %",
        "stopped",
        "fell",
        "missed cycles, %",
    )
    rows = tuple(
        (
            c.gait,
            f"{1e3 * c.delay:g}",
            f"{1e3 * c.jitter:g}",
            f"{1e2 * c.loss:g}",
            f"{c.success} of {c.n}",
            f"{c.interval[0]:.2f} to {c.interval[1]:.2f}",
            str(c.stopped),
            str(c.fell),
            f"{1e2 * c.missed:.1f}",
        )
        for c in result.cells
    )
    calm = [c for c in result.cells if c.delay == c.jitter == c.loss == 0.0]
    return ReportPage(
        name="network",
        title="Walks over a bad network",
        source="No part of the thesis, whose controller ran on the robot.",
        setup=(
            ("robot", f"{context.robot}, {context.wear} drives and sensors"),
            (
                "walk",
                f"{_steps_in_words(result.cells)}, in real time, two processes in two network namespaces, TCP",
            ),
        ),
        claims=tuple(
            Claim(
                f"The {c.gait} gait walks over an ideal network",
                f"{c.success} of {c.n}",
                c.success == c.n,
            )
            for c in calm
        ),
        pictures=(
            Picture(picture, "Fraction of walks that made all their steps", "Delay and jitter are one way."),
        ),
        tables=(ReportTable("Network conditions and success", head, rows),),
    )


def _steps_in_words(cells: list[NetworkCell]) -> str:
    gaits = dict.fromkeys(c.gait for c in cells)
    return ", ".join(f"{STEPS.get(gait, FEW_STEPS)} steps of {gait}" for gait in gaits)


def draw(cells: list[NetworkCell], file: Path) -> None:
    """One map per gait and loss: delay to the right, jitter upwards."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    gaits, losses = list(dict.fromkeys(c.gait for c in cells)), sorted({c.loss for c in cells})
    delays, jitters = sorted({c.delay for c in cells}), sorted({c.jitter for c in cells})
    figure, axes = plt.subplots(
        len(gaits),
        len(losses),
        figsize=(4.2 * len(losses), 2.3 * len(gaits)),
        squeeze=False,
        layout="constrained",
    )
    for (i, gait), (j, loss) in itertools.product(enumerate(gaits), enumerate(losses)):
        axis = axes[i][j]
        grid = [[float("nan")] * len(delays) for _ in jitters]
        for c in cells:
            if (c.gait, c.loss) == (gait, loss):
                y, x = jitters.index(c.jitter), delays.index(c.delay)
                grid[y][x] = c.success / c.n
                axis.text(
                    x,
                    y,
                    f"{c.success}/{c.n}\n{c.stopped} stopped\n{c.fell} fell",
                    ha="center",
                    va="center",
                    size=7,
                )
        axis.imshow(grid, origin="lower", vmin=0.0, vmax=1.0, cmap="RdYlGn", aspect="auto", alpha=0.8)
        axis.set_xticks(range(len(delays)), [f"{1e3 * d:g}" for d in delays])
        axis.set_yticks(range(len(jitters)), [f"{1e3 * d:g}" for d in jitters])
        axis.set_title(f"{gait} gait, {100 * loss:g} % loss", size=9)
        axis.set_xlabel("delay one way, ms")
        axis.set_ylabel("jitter, ms")
    with atomic_path(file) as temporary:
        figure.savefig(temporary, dpi=130)
    plt.close(figure)
