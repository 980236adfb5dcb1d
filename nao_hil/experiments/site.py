"""The report of a campaign as a page of the documentation, with its pictures; no number is typed by hand.

`python -m nao_hil.experiments.site DIR [--docs docs]` after `nao-hil experiment all --out DIR`.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from PIL import Image

from bridge.errors import ConfigurationError
from nao_hil.analysis.report.page import Picture, ReportPage
from nao_hil.analysis.report.render import Stored, read_report
from nao_hil.experiments.catalogue import EXPERIMENTS

PAGE: Final = "campaign.md"
PICTURES: Final = "images/campaign"
COLOURS: Final = 64
"""Of a picture: plots have few, and the repository keeps every one ever made."""


def write_page(folder: Path, docs: Path) -> Path:
    """Write the page and its pictures anew.

    Args:
        folder: Of the experiments: `report.json` and pictures.
        docs: Of the documentation.

    Raises:
        ConfigurationError: no report there.
    """
    stored = read_report(folder / "report.json")
    pictures = docs / PICTURES
    shutil.rmtree(pictures, ignore_errors=True)
    pictures.mkdir(parents=True)
    for page in stored.report.pages:
        for picture in page.pictures:
            with Image.open(folder / picture.file) as image:
                image.convert("RGB").quantize(COLOURS).save(pictures / name_of(page, picture), optimize=True)
    (docs / PAGE).write_text(text_of(stored), encoding="utf-8")
    return docs / PAGE


def name_of(page: ReportPage, picture: Picture) -> str:
    """A picture's file among those of all experiments."""
    name = picture.file.name
    return name if name.startswith(page.name) else f"{page.name}-{name}"


def text_of(stored: Stored) -> str:
    """The page, in markdown."""
    report = stored.report
    done = [page.name for page in report.pages]
    missing = dict(report.missing) | {
        name: "not part of this campaign"
        for name, entry in EXPERIMENTS.items()
        if entry.thesis and name not in done and name not in dict(report.missing)
    }
    verdicts = [
        (f"[{p.title}](#{p.name})", f"{sum(c.holds for c in p.claims)} of {len(p.claims)}", p.verdict)
        for p in report.pages
    ]
    verdicts += [(name, "", f"not done: {why}") for name, why in missing.items()]
    parts = [
        "<!-- Written by `python -m nao_hil.experiments.site DIR`; do not edit. -->",
        "# The last campaign",
        "What the thesis (Prenner 2011) claims, beside what the emulated robot does in the last campaign. "
        "[Experiments](experiments.md) says how each is measured. Shares have 95 % Wilson intervals; "
        "conditions that are compared walk with the same seeds.",
        table(("", ""), [*report.facts, ("made", stored.made)]),
        table(("experiment", "claims that hold", "verdict"), verdicts),
        *(section(page) for page in report.pages),
        "## With what it was made",
        table(("", ""), [(name, v) for name, v in sorted(stored.versions.items()) if name != "platform"]),
    ]
    return "\n\n".join(parts) + "\n"


def section(page: ReportPage) -> str:
    """One experiment."""
    claims = [(c.text, c.measured, "✓ holds" if c.holds else "✗ does not hold") for c in page.claims]
    parts = [f"## {plain(page.title)} {{ #{page.name} }}", plain(page.source)]
    parts.append(table(("claim", "measured", "verdict"), claims))
    if page.findings:
        parts.append("\n".join(f"- {plain(finding)}" for finding in page.findings))
    for each in page.tables:
        parts += [f"### {plain(each.title)}", table(each.head, each.rows)]
    for picture in page.pictures:
        parts.append(f"![{plain(picture.title)}]({PICTURES}/{name_of(page, picture)})")
        parts.append(f"*{plain(picture.title)}. {plain(picture.caption)}*")
    return "\n\n".join([*parts, table(("setup", ""), page.setup)])


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in markdown."""
    lines = [head, ["---"] * len(head), *([cell(text) for text in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def cell(text: str) -> str:
    """A cell, which may be a link."""
    return text if text.startswith("[") else plain(text).replace("|", "\\|")


def plain(text: str) -> str:
    """Text that markdown takes as it is, on one line."""
    text = " ".join(text.split())
    for sign in "*_<`":
        text = text.replace(sign, f"\\{sign}")
    return text


def main() -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--docs", type=Path, default=Path("docs"))
    arguments = parser.parse_args()
    try:
        print(f"written to {write_page(arguments.folder, arguments.docs)}")
    except ConfigurationError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
