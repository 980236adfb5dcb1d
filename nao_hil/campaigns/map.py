"""A robustness map: who walks on, over two quantities."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np

from bridge.errors import ConfigurationError
from bridge.types import Array
from nao_hil.analysis.statistics import Sprt, wilson
from nao_hil.campaigns.file import with_seed
from nao_hil.campaigns.quantities import UNITS, changed_all
from nao_hil.files import save_figure
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.walk import Walk

Cell = tuple[int, int]
FIRST_SPACING: Final = 4
"""Cells between those of the first lattice."""
Try = Callable[[Sequence[tuple[Cell, int]]], Iterable[bool]]
"""Walks each cell with the seed of that number; gives who survived, in order."""
CELLS: Final = 20


@dataclass
class Survey:
    """Results on a grid of cells; an island smaller than the first lattice's gaps may be missed."""

    shape: Cell
    test: Sprt = field(default_factory=Sprt)
    batch: int = 4
    """Walks of a cell at a time: the fewest after which the test can be sure."""
    survived: dict[Cell, int] = field(default_factory=dict)
    tried: dict[Cell, int] = field(default_factory=dict)

    def run(self, attempt: Try) -> None:
        """Try cells until the boundary is known to a cell."""
        step = FIRST_SPACING
        while step >= 1:
            lattice = self._lattice(step)
            wanted = [cell for cell in lattice if step == FIRST_SPACING]
            while wanted or (wanted := self._mixed(lattice, step)):
                if not self._decide(wanted, attempt):
                    return
                wanted = []
            step //= 2

    def verdicts(self) -> dict[Cell, bool]:
        """The cells that are decided: whether more walk on than fall."""
        verdicts = {cell: self.test.verdict(self.survived[cell], self.tried[cell]) for cell in self.tried}
        return {cell: verdict for cell, verdict in verdicts.items() if verdict is not None}

    def shares(self) -> Array:
        """Share that walks on; a cell without walks has that of the nearest with some. Shape of the grid."""
        cells = np.array(list(self.tried))
        known = np.array([self.survived[cell] / self.tried[cell] for cell in self.tried])
        grid = np.stack(np.meshgrid(*map(np.arange, self.shape), indexing="ij"), axis=-1)
        distance = ((grid[:, :, None, :] - cells) ** 2).sum(axis=-1)
        return np.asarray(known[distance.argmin(axis=-1)], dtype=np.float64)

    def _lattice(self, step: int) -> list[Cell]:
        """Every so many cells, the last ones always."""
        axes = [sorted({*range(0, n, step), n - 1}) for n in self.shape]
        return [(i, j) for i in axes[0] for j in axes[1]]

    def _mixed(self, lattice: list[Cell], step: int) -> list[Cell]:
        """Untried cells of the lattice whose neighbours disagree."""
        verdicts = self.verdicts()
        wanted = []
        for i, j in lattice:
            near = {
                verdicts[a, b]
                for a in range(i - step, i + step + 1)
                for b in range(j - step, j + step + 1)
                if (a, b) in verdicts
            }
            if (i, j) not in self.tried and len(near) == 2:
                wanted.append((i, j))
        return wanted

    def _decide(self, cells: list[Cell], attempt: Try) -> bool:
        """Try cells until each is decided; False: the walks end before."""
        open_cells = cells
        while open_cells:
            asked = [(cell, self.tried.get(cell, 0) + k) for cell in open_cells for k in range(self.batch)]
            alive = list(attempt(asked))
            for (cell, _), survived in zip(asked, alive, strict=False):
                self.tried[cell] = self.tried.get(cell, 0) + 1
                self.survived[cell] = self.survived.get(cell, 0) + survived
            if len(alive) < len(asked):
                return False
            decided = self.verdicts()
            open_cells = [cell for cell in open_cells if cell not in decided]
        return True


class Axis(NamedTuple):
    """A quantity from one value to another."""

    name: str
    values: tuple[float, ...]

    @property
    def label(self) -> str:
        """With its unit, for a plot."""
        return f"{self.name}, {UNITS[self.name]}" if self.name in UNITS else self.name


def parse_axis(text: str) -> Axis:
    """`NAME=LOW:HIGH` or `NAME=LOW:HIGH:CELLS`.

    Raises:
        ConfigurationError: not of this form, or fewer than two cells.
    """
    number = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
    matched = re.fullmatch(rf"([\w.]+)=({number}):({number})(?::(\d+))?", text)
    if matched is None or float(matched[2]) >= float(matched[3]) or not 2 <= int(matched[4] or CELLS) <= 1000:
        raise ConfigurationError(
            f"{text}: must be NAME=LOW:HIGH or NAME=LOW:HIGH:CELLS with LOW < HIGH, such as push=0:8:20."
        )
    values = np.linspace(float(matched[2]), float(matched[3]), int(matched[4] or CELLS))
    return Axis(matched[1], tuple(round(float(value), 12) for value in values))


def survey(campaign: Campaign, task: Walk, x: Axis, y: Axis, first_seed: int, most: int) -> Survey:
    """Walk where the verdict changes.

    Args:
        campaign: To walk in.
        task: To change.
        x: Quantity.
        y: Quantity.
        first_seed: All cells walk with the same seeds, from this one on.
        most: Walks of a cell.

    Raises:
        ConfigurationError: an unknown quantity or an impossible value.
    """
    cells = {
        (i, j): changed_all(task, {x.name: a, y.name: b})
        for i, a in enumerate(x.values)
        for j, b in enumerate(y.values)
    }

    def attempt(asked: Sequence[tuple[Cell, int]]) -> list[bool]:
        """Whether each walk that is asked for, the k-th of a cell, survives."""
        walks = [
            msgspec.structs.replace(
                with_seed(cells[cell], first_seed + k),
                name=f"{x.name} {x.values[cell[0]]:g}, {y.name} {y.values[cell[1]]:g}",
            )
            for cell, k in asked
        ]
        done = {result.walk.name + str(result.seed): result.end.survived for result in campaign.walk(walks)}
        alive = [done.get(walk.name + str(walk.config.seed)) for walk in walks]
        return [each for each in alive if each is not None] if None not in alive else []

    surveyed = Survey((len(x.values), len(y.values)))
    surveyed.test = msgspec.structs.replace(surveyed.test, most=most)
    surveyed.run(attempt)
    return surveyed


def summary(found: Survey, x: Axis, y: Axis) -> dict[str, Any]:
    """For JSON: the cells tried, with Wilson's 95 % intervals, and the saving."""
    full = len(x.values) * len(y.values) * found.test.most
    walks = sum(found.tried.values())
    cells = [
        {
            "x": x.values[cell[0]],
            "y": y.values[cell[1]],
            "n": n,
            "survived": found.survived[cell],
            "interval": wilson(found.survived[cell], n),
        }
        for cell, n in sorted(found.tried.items())
    ]
    return {
        "x": x.name, "y": y.name, "cells": cells, "walks": walks, "full_grid": full, "share": walks / full
    }  # fmt: skip


def draw(found: Survey, x: Axis, y: Axis, title: str, path: Path) -> Path:
    """The map as a picture: share that survives, and the width of its interval where there are walks."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.8), layout="constrained")
    share, width = figure.subplots(1, 2, sharex=True, sharey=True)
    intervals = np.full(found.shape, np.nan)
    for cell, n in found.tried.items():
        low, high = wilson(found.survived[cell], n)
        intervals[cell] = 100.0 * (high - low)
    dx, dy = (0.5 * (axis.values[1] - axis.values[0]) for axis in (x, y))
    extent = (x.values[0] - dx, x.values[-1] + dx, y.values[0] - dy, y.values[-1] + dy)
    for axes, values, words, colours, most in (
        (
            share,
            100.0 * found.shares(),
            "walk on, % (dots: walked; others: as the nearest)",
            "RdYlGn",
            100,
        ),
        (
            width,
            intervals,
            "width of the 95 % interval, % (white: not walked)",
            "viridis_r",
            None,
        ),
    ):
        image = axes.imshow(
            values.T, origin="lower", extent=extent, aspect="auto", cmap=colours, vmin=0, vmax=most
        )
        figure.colorbar(image, ax=axes)
        axes.set(xlabel=x.label, ylabel=y.label)
        axes.set_title(words, fontsize=8)
    walked = np.array([(x.values[i], y.values[j]) for i, j in found.tried])
    share.plot(*walked.T, "k.", markersize=2)
    figure.suptitle(title, fontsize=10)
    return save_figure(figure, path)
