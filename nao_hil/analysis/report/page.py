"""The page of an experiment: claims with measured values, figures, setup, findings."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Claim:
    """A claim with its measured value."""

    text: str
    measured: str
    holds: bool


@dataclass(frozen=True)
class Picture:
    """A figure's file and caption."""

    file: Path
    title: str
    """With the number of the thesis' figure, where it has one."""
    caption: str


@dataclass(frozen=True)
class ReportTable:
    """Numbers in rows; all cells are text."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def yes_no(value: bool) -> str:
    """A truth value in a table."""
    return "yes" if value else "no"


@dataclass(frozen=True)
class ReportPage:
    """An experiment in the report."""

    name: str
    title: str
    source: str
    """Statement and place in the thesis."""
    setup: tuple[tuple[str, str], ...]
    """Conditions: name and value."""
    claims: tuple[Claim, ...]
    pictures: tuple[Picture, ...] = ()
    tables: tuple[ReportTable, ...] = ()
    findings: tuple[str, ...] = field(default=())
    """Sentences computed from the data, most of them where a claim is not confirmed."""

    @property
    def passed(self) -> bool:
        """Every claim holds."""
        return all(claim.holds for claim in self.claims)

    @property
    def verdict(self) -> str:
        """Whether every claim holds, in words; a page without claims has measurements only."""
        if not self.claims:
            return "measured"
        return "confirmed" if self.passed else "not confirmed"


@dataclass(frozen=True)
class Outcome:
    """An experiment that is done."""

    page: ReportPage
    figures: dict[str, Any]
    """Measured quantities by their key in the JSON."""

    @property
    def result(self) -> dict[str, Any]:
        """The JSON: name, verdict, figures."""
        return {"name": self.page.name, "passed": self.page.passed} | self.figures
