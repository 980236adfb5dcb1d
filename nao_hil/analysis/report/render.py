"""The page of an experiment: claims with measured values, figures, setup; one HTML file, the same as JSON."""

from __future__ import annotations

import base64
import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeAlias

import msgspec

from bridge.errors import ConfigurationError
from nao_hil.files import write_bytes, write_text
from nao_hil.runs.folder import versions

Column: TypeAlias = str | Callable[[Any], str]
"""Text of a cell: a format of the item, such as `{0.seed}`, or a function of it."""
Columns: TypeAlias = Mapping[str, Column]
"""By their heads."""


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


def table(title: str, items: Iterable[Any], columns: Columns) -> ReportTable:
    """A table with an item a row."""
    rows = tuple(
        tuple(column(item) if callable(column) else column.format(item) for column in columns.values())
        for item in items
    )
    return ReportTable(title, tuple(columns), rows)


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


TEMPLATE: Final = "report.html.j2"


@dataclass(frozen=True)
class Report:
    """All that is in the file."""

    title: str
    pages: Sequence[ReportPage]
    facts: Sequence[tuple[str, str]]
    """On the whole of it: robot, seeds, how to do it again."""
    configuration: str = ""
    """Gaits and controllers in full, TOML."""
    missing: Sequence[tuple[str, str]] = ()
    """Experiments that did not run, and why."""
    about: str = ""
    """The common part of the pages, and how to read them."""

    @property
    def has_claims(self) -> bool:
        """There are verdicts to list."""
        return bool(self.missing) or any(page.claims for page in self.pages)


class Stored(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON: a report, its time and versions. Pictures are named from its folder."""

    report: Report
    made: str
    versions: dict[str, str]


def write_report(path: Path, report: Report) -> None:
    """Write the report, and its JSON under the same name.

    Args:
        path: Of the HTML file.
        report: Its contents; the pictures' files must be there.

    Raises:
        ConfigurationError: jinja2 is not installed, or a file cannot be written.
    """
    try:
        import jinja2
    except ImportError:
        raise ConfigurationError(
            "The report needs jinja2, which is not installed; `pip install 'nao-hil[analysis]'` brings it."
        ) from None
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    made, found = time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()), versions()
    html = environment.get_template(TEMPLATE).render(
        report=report,
        picture=embedded,
        versions=found,
        made=made,
    )
    write_text(path, html)
    stored = Stored(report=report, made=made, versions=found)
    named = msgspec.json.encode(stored, enc_hook=lambda file: os.path.relpath(file, path.parent))
    write_bytes(path.with_suffix(".json"), msgspec.json.format(named))


def embedded(picture: Picture) -> str:
    """A picture as a data URI."""
    return "data:image/png;base64," + base64.b64encode(picture.file.read_bytes()).decode()
