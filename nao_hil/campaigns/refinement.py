"""Which cells of a map to look at: a coarse lattice, then finer ones where the verdict changes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nao_hil.analysis.statistics import Sprt

Cell = tuple[int, int]
COARSEST: Final = 4
"""Cells between those of the first lattice."""
Try = Callable[[Sequence[tuple[Cell, int]]], Iterable[bool]]
"""Walks each cell with the seed of that number; gives who survived, in order."""


@dataclass
class Survey:
    """Verdicts on a grid of cells; an island smaller than the first lattice's gaps may be missed."""

    shape: Cell
    test: Sprt = field(default_factory=Sprt)
    batch: int = 4
    """Walks of a cell at a time: the fewest after which the test can be sure."""
    survived: dict[Cell, int] = field(default_factory=dict)
    tried: dict[Cell, int] = field(default_factory=dict)

    def run(self, attempt: Try) -> None:
        """Look at cells until the boundary is known to a cell."""
        step = COARSEST
        while step >= 1:
            lattice = self._lattice(step)
            wanted = [cell for cell in lattice if step == COARSEST]
            while wanted or (wanted := self._mixed(lattice, step)):
                if not self._decide(wanted, attempt):
                    return
                wanted = []
            step //= 2

    def verdicts(self) -> dict[Cell, bool]:
        """The cells that are decided: whether more walk on than fall."""
        found = {cell: self.test.verdict(self.survived[cell], self.tried[cell]) for cell in self.tried}
        return {cell: verdict for cell, verdict in found.items() if verdict is not None}

    def shares(self) -> NDArray[np.float64]:
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
        """Cells of the lattice not looked at whose neighbours disagree."""
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
        """Try cells until each is decided; False: the walks came to an end before."""
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
