"""Charts of the page: plots of viser, with values under the pointer, and zoom by dragging over a stretch."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_hil.analysis.diagnosis import Symptom
from nao_hil.view.gaps import with_breaks, with_gaps
from nao_hil.view.history import COLUMNS, History
from nao_hil.view.looks import Floats

WINDOW: Final = 10.0
"""s shown."""
BLUE, ORANGE, GREEN, RED, GREY, YELLOW = "#339af0", "#ff922b", "#40c057", "#fa5252", "#868e96", "#fcc419"
MARKS: Final = {"now": GREY, "world": YELLOW, "sign": ORANGE, "first": RED}
"""Colours of the vertical lines through all charts."""
PHASES: Final = {
    "DSL": "#495057",
    "DSR": "#495057",
    "SSL": "#1c7ed6",
    "SSR": "#e8590c",
    "start": "#2b8a3e",
    "stop": "#2b8a3e",
    "stand": "#343a40",
}
SHOWN_PHASES: Final = {"DSL, DSR": GREY, "SSL": BLUE, "SSR": ORANGE, "start, stop": GREEN}
"""In the chart of the phase; at a stand it is empty."""


class Line(NamedTuple):
    """One curve: its column, its name, its colour."""

    column: str
    name: str
    colour: str


class Chart(NamedTuple):
    """One strip."""

    title: str
    lines: tuple[Line, ...]
    least: tuple[float, float]
    """Range that is always shown."""
    height: float
    most: tuple[float, float] = (-math.inf, math.inf)
    """Range that is never left."""


CHARTS: Final = (
    Chart(
        "torso, deg",
        (Line("pitch", "pitch", BLUE), Line("roll", "roll", ORANGE)),
        (-5.0, 5.0),
        56.0,
        (-30.0, 30.0),
    ),
    Chart(
        "foot sensors, N",
        (Line("left", "left", BLUE), Line("right", "right", ORANGE)),
        (0.0, 55.0),
        44.0,
        (0.0, 120.0),
    ),
    Chart(
        "ZMP margin, mm",
        (
            Line("margin_plan", "planned", BLUE),
            Line("margin_fsr", "by FSR", ORANGE),
            Line("margin_true", "true", GREEN),
        ),
        (-10.0, 80.0),
        62.0,
        (-40.0, 120.0),
    ),
    Chart("cycle late, ms", (Line("late", "behind its clock", BLUE),), (0.0, 2.0), 26.0),
    Chart(
        "gyroscope, deg/s",
        (Line("rate_roll", "roll", ORANGE), Line("rate_pitch", "pitch", BLUE), Line("rate_yaw", "yaw", GREEN)),
        (-60.0, 60.0),
        44.0,
        (-240.0, 240.0),
    ),
    Chart(
        "feet, mm above the ground as planned",
        (Line("lift_left", "left", BLUE), Line("lift_right", "right", ORANGE)),
        (0.0, 20.0),
        44.0,
        (-10.0, 60.0),
    ),
    Chart("largest motor current, A", (Line("current", "of a leg", BLUE),), (0.0, 2.0), 44.0, (0.0, 4.0)),
    Chart("hottest motor, °C", (Line("heat", "of all", RED),), (20.0, 60.0), 44.0, (0.0, 110.0)),
)
"""All that can be chosen."""
FIRST_CHARTS: Final = 4
"""So many of them are shown at first."""
AXES_HEIGHT: Final = 24
"""Of a chart beyond its curves, pixels."""
PHASE_HEIGHT: Final = 68
"""Of the chart of the phase with the seconds below it, pixels."""
TOLD: Final = 3
"""Signs that are listed under the charts."""


class Charts:
    """All charts, and below them the last signs in words.

    Args:
        gui: `viser.ViserServer.gui`, in the tab that they are for.
    """

    def __init__(self, gui: Any) -> None:
        self.chosen: Sequence[Chart] = CHARTS[:FIRST_CHARTS]
        self._plots = [
            (chart, [COLUMNS.index(line.column) for line in chart.lines], _add(gui, chart)) for chart in CHARTS
        ]
        self._phase = _add_phase(gui)
        self._told = gui.add_html("")
        self._drawn: tuple[Any, ...] | None = None

    def choose(self, charts: Sequence[Chart]) -> None:
        """Show these."""
        self.chosen = charts
        if self._drawn is not None:  # a film that stands still draws nothing itself
            self.draw(*self._drawn)

    def draw(
        self,
        history: History,
        now: float,
        symptoms: Sequence[Symptom] = (),
        first: Symptom | None = None,
        ahead: float = 0.0,
    ) -> None:
        """Show the last seconds.

        Args:
            history: The numbers.
            now: The moment shown, robot time, s.
            symptoms: Marked by a line through all charts; the last ones up to `now` are listed.
            first: The one that is to stand out.
            ahead: How much of what comes after `now` is shown, s.
        """
        rows, phases = with_breaks(*history.window(now + ahead, WINDOW))
        if not len(rows):
            return
        self._drawn = history, now, symptoms, first, ahead
        times = {
            "now": [now] if ahead > 0.0 else [],
            "world": [s.time for s in symptoms if s.kind == "world" and s != first],
            "sign": [s.time for s in symptoms if s.kind != "world" and s != first],
            "first": [first.time] if first is not None else [],
        }
        order, marks = mark(rows[:, 0], [times[name] for name in MARKS])
        rows = rows[order]
        for chart, columns, plot in self._plots:
            visible = chart in self.chosen and bool(np.isfinite(rows[:, columns]).any())
            if plot.visible != visible:
                plot.visible = visible
            if visible:
                plot.data = with_gaps([rows[:, 0], *rows[:, columns].T, *marks])
        phase = np.array(phases)[order]
        shown = [np.isin(phase, name.split(", ")).astype(float) for name in SHOWN_PHASES]
        self._phase.data = [rows[:, 0].copy(), *shown, *marks]
        known = sorted((s for s in symptoms if s.time <= now), key=lambda s: s.time)
        self._told.content = _told(known[-TOLD:])


def mark(times: Floats, groups: Sequence[Sequence[float]]) -> tuple[NDArray[np.int_], list[Floats]]:
    """Curves that are vertical lines at some times, in a plot whose scale is 0 to 1.

    Args:
        times: Of the plot's points, increasing.
        groups: Times of the lines of each curve.

    Returns:
        The points to draw, by their number, those of lines repeated; and of each curve its values there.
    """
    inside = [[t for t in group if times[0] <= t <= times[-1]] for group in groups]
    at = [np.searchsorted(times, group) for group in inside]
    order: NDArray[np.int_] = np.sort(np.concatenate([np.arange(len(times)), *at, *at]))
    curves: list[Floats] = []
    for numbers in at:
        curve = np.full(len(order), -1.0)
        curve[np.searchsorted(order, numbers) + 1] = 2.0
        curves.append(curve)
    return order, curves


def _add(gui: Any, chart: Chart) -> Any:
    low, high = ({"pad": 0.1, "soft": soft, "mode": 1} for soft in chart.least)
    for limit, hard in zip((low, high), chart.most, strict=True):
        if math.isfinite(hard):
            limit["hard"] = hard
    lines = [{"label": line.name, "stroke": line.colour, "width": 1.3} for line in chart.lines]
    scale, numbers = {"range": {"min": low, "max": high}}, {"size": 36, "space": 18}
    return _plot(gui, chart.title, lines, scale, numbers, {"show": False}, chart.height + AXES_HEIGHT)


def _add_phase(gui: Any) -> Any:
    areas = [
        {"label": name, "stroke": colour, "fill": colour, "width": 0, "points": {"show": False}}
        for name, colour in SHOWN_PHASES.items()
    ]
    hidden = {"size": 36, "stroke": "transparent", "grid": {"show": False}, "ticks": {"show": False}}
    return _plot(gui, "phase", areas, {"range": (0.0, 1.0)}, hidden, {"size": 26}, PHASE_HEIGHT)


def _plot(gui: Any, title: str, lines: list[dict[str, Any]], scale: Any, y: Any, x: Any, height: float) -> Any:
    marks = [
        {
            "label": name,
            "class": "nao-mark",
            "scale": "mark",
            "stroke": colour,
            "width": 2 if name == "first" else 1,
            "points": {"show": False},
        }
        for name, colour in MARKS.items()
    ]
    series = ({"label": "s"}, *lines, *marks)
    return gui.add_uplot(
        (np.zeros(2),) * len(series),
        series,
        title=title,
        scales={"x": {"time": False}, "y": scale, "mark": {"range": (0.0, 1.0)}},
        axes=(x, y),
        cursor={"sync": {"key": "charts"}, "y": False},
        height=round(height),
        padding=(8, 8, 12, 0),
    )


def _told(symptoms: Sequence[Symptom]) -> str:
    """The last signs as words, the newest at the bottom."""
    lines = []
    for symptom in symptoms:
        colour = RED if symptom.kind == "fall" else MARKS.get(symptom.kind, ORANGE)
        time = f'<b style="color: {colour}">{symptom.time:.2f} s</b>'
        lines.append(f"<div>{time} {html.escape(symptom.text)}</div>")
    return f'<div class="signs" style="font-size: 12px; padding: 4px 14px">{"".join(lines)}</div>'
