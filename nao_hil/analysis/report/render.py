"""From pages to one self-contained HTML file, and the same as JSON beside it."""

from __future__ import annotations

import base64
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from bridge.errors import ConfigurationError
from nao_hil.analysis.report.page import Picture, ReportPage
from nao_hil.files import write_bytes, write_text
from nao_hil.runs.folder import versions

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
    """Experiments that were not done, and why."""
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
