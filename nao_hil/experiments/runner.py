"""Runs experiments one after the other: folders, JSON, text on the terminal, report."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import msgspec
from rich.console import Console
from rich.text import Text

from nao_hil.analysis.report.render import Outcome, Report, ReportPage, write_report
from nao_hil.experiments.catalogue import ALL, EXPERIMENTS
from nao_hil.experiments.context import Context, seed_words
from nao_hil.files import write_bytes
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.config import RunConfig
from nao_hil.runs.fingerprint import source_hash
from walker.gaits import gait_parameters
from walker.parameters import controller_parameters

GAITS: Final = ("static", "dynamic")
"""Parameters of these gaits and of the chosen one are in the report."""
ABOUT: Final = (
    "L. Prenner, Steuerung und Regelung für den Gang eines humanoiden Roboters, TU Wien 2011: its claims and "
    "the results of the emulated robot. Shares have 95 % Wilson intervals. Compared conditions walk with the "
    "same seeds. A fall is one by the ground truth: torso beyond 45 degrees, below half its height, or "
    "anything but a foot on the ground. A claim that is not confirmed stands here as such, with the "
    "result."
)
"""Above the report."""


class Runner:
    """Runs experiments and keeps their results.

    Args:
        context: Of all of them; its folder gets the report, its seeds are not read.
        console: For claims and findings.
        seeds: Number of them; None: each experiment's own.
        first_seed: The first of them.
    """

    def __init__(
        self, context: Context, console: Console, seeds: int | None = None, first_seed: int = 0
    ) -> None:
        self._context, self._console = context, console
        self._seeds, self._first = seeds, first_seed
        self._pages: list[ReportPage] = []
        self.results: dict[str, dict[str, Any]] = {}
        """JSON by name."""
        self.missing: list[tuple[str, str]] = []
        """Experiments that did not run, and why."""

    @property
    def interrupted(self) -> bool:
        """Stopped before the end."""
        return self._context.campaign.interrupted

    @property
    def passed(self) -> bool:
        """Every experiment is done, and every claim holds."""
        return not self.missing and all(result["passed"] for result in self.results.values())

    def seeds(self, name: str) -> tuple[int, ...]:
        """Seeds of an experiment."""
        return tuple(range(self._first, self._first + (self._seeds or EXPERIMENTS[name].seeds)))

    def run(self, name: str, out: Path) -> None:
        """Do an experiment; `out` is for its JSON and figures.

        Raises:
            NaoHilError: a configuration that cannot be walked, or a run that failed.
        """
        if self.interrupted:
            self.missing.append((name, "interrupted before it began"))
            return
        out.mkdir(parents=True, exist_ok=True)
        try:
            context = replace(self._context, out=out, seeds=self.seeds(name))
            outcome = EXPERIMENTS[name].load().run(name, context)
        except Interrupted:
            self.missing.append((name, "interrupted; walks that are done are kept"))
            return
        self._keep(name, out, outcome)

    def _keep(self, name: str, out: Path, outcome: Outcome) -> None:
        seeds = self.seeds(name)
        written = msgspec.json.encode(outcome.result)
        write_bytes(out / f"{name}.json", msgspec.json.format(written))
        self.results[name] = msgspec.json.decode(written) | {
            "robot": self._context.robot,
            "wear": self._context.wear,
            "engine": self._context.engine,
            "seeds": len(seeds),
            "first_seed": seeds[0],
            "interrupted": self.interrupted,
        }
        page, wanted = outcome.page, EXPERIMENTS[name].seeds
        if len(seeds) < wanted:
            page = replace(page, title=f"{page.title} (only {len(seeds)} of {wanted} seeds)")
        self._pages.append(page)
        self._print_page(page)

    def _print_page(self, page: ReportPage) -> None:
        verdict = page.verdict, "green" if page.passed else "yellow"
        self._console.print(Text.assemble((page.name, "bold"), ": ", verdict))
        for claim in page.claims:
            mark = ("holds", "green") if claim.holds else ("does not hold", "yellow")
            self._console.print(Text.assemble("  ", mark, f"  {claim.text}: {claim.measured}"))
        for finding in page.findings:
            self._console.print(f"  - {finding}", style="dim")

    def summary(self, name: str) -> dict[str, Any]:
        """The JSON of an experiment, or of all."""
        data = self.results.get(name, {"name": name, "passed": self.passed, "interrupted": self.interrupted})
        if name == ALL:
            data = data | {"experiments": self.results, "missing": [each for each, _ in self.missing]}
        return data

    def report(self, title: str) -> Path:
        """Write the report; gives its path."""
        changes = self._context.changes
        names = [page.name for page in self._pages]
        facts = [
            ("robot", f"{changes.robot}, {changes.wear} drives and sensors, on {changes.engine}"),
            ("seeds", ", ".join(f"{n}: {seed_words(self.seeds(n))}" for n in names) or "none"),
            ("sources", f"sha256 {source_hash()[:16]} of robot, walker and contract"),
        ]
        if self.interrupted:
            facts.append(("interrupted", "shares are of the runs that were done"))
        path = self._context.out / "report.html"
        write_report(path, Report(title, self._pages, facts, _configuration(changes), self.missing, ABOUT))
        return path


def _configuration(changes: RunConfig) -> str:
    """Parameters of gaits and controllers of the runs, in the form of a configuration file."""
    parts = []
    for gait in dict.fromkeys((*GAITS, changes.gait)):
        same = gait == changes.gait
        table = {
            "gait": gait,
            "parameters": gait_parameters(gait, changes.parameters if same else {}),
            "controller": controller_parameters(gait, changes.controller if same else {}),
        }
        parts.append(msgspec.toml.encode(table).decode())
    return "\n".join(parts)
