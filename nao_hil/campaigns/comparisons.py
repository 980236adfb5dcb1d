"""Comparisons of a campaign's cells, in pairs of walks with the same seed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import msgspec

from nao_hil.analysis.statistics import Estimate, Paired, holm, mean_of, paired
from nao_hil.campaigns.file import CampaignCell


class CellComparison(msgspec.Struct, frozen=True, kw_only=True):
    """A cell against the one that differs from it in one quantity, on the seeds that both walked."""

    quantity: str
    value: Any
    against: Any
    """Value of the other cell: the axis' first."""
    at: dict[str, Any]
    """Values of the other axes, the same in both."""
    survived: Paired
    """With `value` and without it, that is, with `against`."""
    speed: Estimate
    """Mean difference of the speeds of the seeds that walk on in both cells, m/s; Student's interval."""
    p_value: float
    """P value of McNemar's exact test, corrected by Holm's method for all comparisons of the campaign."""


def comparisons(cells: Sequence[CampaignCell]) -> list[CellComparison]:
    """Each cell against those that have the first value of one axis, and all else the same.

    Cells that share no seed, as after an early stop, are not compared: their own intervals have to do.

    Args:
        cells: All of a campaign, the axes' first values first.
    """
    compared = list(_compared(cells))
    corrected = holm([each.p_value for each in compared])
    return [msgspec.structs.replace(e, p_value=p) for e, p in zip(compared, corrected, strict=True)]


def _compared(cells: Sequence[CampaignCell]) -> Iterator[CellComparison]:
    by_point = {repr(cell.point): cell for cell in cells}
    first = cells[0].point
    for cell in cells:
        for quantity, value in cell.point.items():
            other = by_point[repr(cell.point | {quantity: first[quantity]})]
            seeds = [seed for seed in cell.ends if seed in other.ends]
            if other is cell or not seeds:
                continue
            ends = [(cell.ends[seed], other.ends[seed]) for seed in seeds]
            pair = paired([a.survived for a, _ in ends], [b.survived for _, b in ends])
            yield CellComparison(
                quantity=quantity,
                value=value,
                against=first[quantity],
                at={name: at for name, at in cell.point.items() if name != quantity},
                survived=pair,
                speed=mean_of([a.speed - b.speed for a, b in ends if a.survived and b.survived]),
                p_value=pair.p_value,
            )
