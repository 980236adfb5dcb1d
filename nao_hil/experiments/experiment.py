"""An experiment as data: conditions, quantities, claims, tables, pictures; and the one way to carry it out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeAlias, TypeVar

import msgspec
from matplotlib.figure import Figure

from bridge.body import Body
from nao_hil.analysis.report.render import Claim, Outcome, Picture, ReportPage, ReportTable, table
from nao_hil.experiments.conditions import Comparison, conditions_table
from nao_hil.experiments.context import Context, seed_words
from nao_hil.files import save_figure
from nao_hil.runs.walk import Walk

Results = TypeVar("Results")
Rows: TypeAlias = Sequence[tuple[str, str]]
"""Names and values."""
WIDE: Final = (9.0, 4.5)
"""Size of a picture, inches."""


@dataclass(frozen=True)
class Measured(Generic[Results]):
    """Measurements of an experiment, for its quantities, claims, tables and pictures."""

    context: Context
    results: Results
    """Result of `Experiment.measure`."""
    figures: dict[str, Any]
    """Result of `Experiment.quantities`."""

    @property
    def body(self) -> Body:
        """Data sheet of the robot."""
        return self.context.body


def bounded(
    text: str, value: Any, low: float = -math.inf, high: float = math.inf, words: str = "{:.3g}"
) -> Claim:
    """A claim that a number lies within bounds, the bounds included.

    Args:
        text: The claim.
        value: A number, or an estimate or share, of which the whole 95 % interval has to lie within the bounds.
        low: Least value.
        high: Largest one.
        words: Format of the measured value; by default an estimate or share has its own.
    """
    least, most = getattr(value, "interval", (value, value))
    own = hasattr(value, "words") and words == "{:.3g}"
    return Claim(text, value.words() if own else words.format(value), bool(least >= low and most <= high))


@dataclass(frozen=True)
class Drawing:
    """A picture to be drawn."""

    file: str
    """Name of the PNG."""
    draw: Callable[[Figure, Any], object]
    """Draws the measurements on an empty figure."""
    title: str
    caption: str = ""
    """`{seed}` becomes the first seed."""
    size: tuple[float, float] = WIDE

    def drawn(self, measured: Measured[Any]) -> Picture:
        """The picture, in the experiment's folder."""
        figure = Figure(figsize=self.size, layout="constrained")
        self.draw(figure, measured)
        context = measured.context
        file = save_figure(figure, context.out / self.file)
        return Picture(file, self.title, self.caption.format(seed=context.seeds[0]))


@dataclass(frozen=True, kw_only=True)
class Experiment(Generic[Results]):
    """Declaration of an experiment; name, question and seeds are in the catalogue."""

    title: str | Callable[[Measured[Results]], str]
    source: str
    """Claim of the thesis, or another source."""
    measure: Callable[[Context], Results]
    """Walks, or measures otherwise."""
    quantities: Callable[[Measured[Results]], dict[str, Any]]
    """Figures by their key in the JSON: pure functions of the results."""
    setup: Rows | Callable[[Measured[Results]], Rows] = ()
    claims: Callable[[Measured[Results]], Iterable[Claim]] = lambda _: ()
    """All of them decide."""
    tables: Callable[[Measured[Results]], Iterable[ReportTable]] = lambda _: ()
    pictures: Sequence[Drawing] = ()
    findings: Callable[[Measured[Results]], Iterable[str]] = lambda _: ()
    """Sentences; empty ones are left out."""
    most_seeds: int | None = None
    """Further seeds would measure nothing new; None: all count."""
    robot: bool = True
    """A robot is measured: body, wear, seeds and changed parameters belong to the setup."""

    def run(self, name: str, context: Context) -> Outcome:
        """Carry it out.

        Args:
            name: As in the catalogue.
            context: Robot, seeds and folder.

        Raises:
            Interrupted: stopped before there was anything to judge.
            NaoHilError: a configuration that cannot be walked, or a run that failed.
        """
        context = context.first(self.most_seeds) if self.most_seeds else context
        measured = Measured(context, self.measure(context), {})
        measured.figures.update(self.quantities(measured))
        setup = self.setup(measured) if callable(self.setup) else self.setup
        page = ReportPage(
            name=name,
            title=self.title(measured) if callable(self.title) else self.title,
            source=self.source,
            setup=(*setup, *(_robot_rows(context) if self.robot else ())),
            claims=tuple(self.claims(measured)),
            pictures=tuple(drawing.drawn(measured) for drawing in self.pictures),
            tables=(*self.tables(measured), *_figures_table(measured.figures)),
            findings=tuple(text for text in self.findings(measured) if text),
        )
        return Outcome(page, measured.figures)


def comparison(
    *,
    conditions: Callable[[Context], Mapping[str, Sequence[Walk]]],
    quantities: Callable[[Measured[Comparison]], dict[str, Any]] = lambda _: {},
    **parts: Any,
) -> Experiment[Comparison]:
    """An experiment that walks some conditions with the same seeds, tabled with their falls.

    Its first figures are the conditions: of one `walked`, of more the first two and their seeds in pairs.

    Args:
        conditions: Walks by the condition's name; each differs from the one before in one switch.
        quantities: Further figures.
        parts: More of `Experiment`.
    """

    def measure(context: Context) -> Comparison:
        """Walk all conditions."""
        return Comparison(context.run(conditions(context)))

    def figures(measured: Measured[Comparison]) -> dict[str, Any]:
        """Figures of the conditions, of their pairs, and the experiment's own."""
        first, *others = measured.results.conditions.values()
        of_all = (
            {"with": first, "without": others[0], "paired": measured.results.pair}
            if others
            else {"walked": first}
        )
        return of_all | quantities(measured)

    return Experiment(
        measure=measure,
        quantities=figures,
        **{
            "tables": lambda measured: [conditions_table(measured.results.conditions)],
            "findings": lambda measured: measured.results.findings(measured.body),
        }
        | parts,
    )


def _robot_rows(context: Context) -> Rows:
    """Robot, wear, seeds, and changed parameters."""
    changes = context.changes
    changed = {name: values for name in ("parameters", "controller") if (values := getattr(changes, name))}
    as_json = msgspec.json.encode(changed).decode()
    return (
        ("robot", f"{context.robot}, {context.wear} drives and sensors"),
        ("seeds", seed_words(context.seeds)),
        (f"changed ({changes.gait} gait)", as_json) if changed else ("parameters", "as shipped"),
    )


def _figures_table(figures: Mapping[str, Any]) -> list[ReportTable]:
    """The figures that are numbers, estimates, shares, or structs of such."""
    rows = [row for name, value in figures.items() for row in _numbers(name, value)]
    return [table("Figures, SI units", rows, {"figure": "{0[0]}", "value": "{0[1]}"})] if rows else []


def _numbers(name: str, value: Any) -> list[tuple[str, str]]:
    if hasattr(value, "words"):
        return [(name, value.words())]
    if isinstance(value, msgspec.Struct):
        fields = msgspec.structs.asdict(value).items()
        return [row for field, part in fields for row in _numbers(f"{name}.{field}", part)]
    return [(name, f"{value:.4g}")] if type(value) in (int, float) else []
