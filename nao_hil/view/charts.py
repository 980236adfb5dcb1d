"""Strip charts as one SVG: they need no library in the browser, and nothing from beyond this machine."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from nao_hil.analysis.diagnosis import Symptom
from nao_hil.view.history import COLUMNS, History
from nao_hil.view.looks import Floats

WINDOW: Final = 10.0
"""s shown."""
WIDTH: Final = 352.0
LEFT: Final = 28.0
"""Room for the scale."""
GAP: Final = 17.0
"""Room for a chart's title."""
HEAD: Final = 16.0
"""Room over all charts for what went wrong first."""
BINS: Final = 250
"""Points drawn of each line."""

BACKGROUND: Final = "#1f2023"
BLUE, ORANGE, GREEN, RED, GREY = "#339af0", "#ff922b", "#40c057", "#fa5252", "#868e96"
MARKS: Final = {"world": "#fcc419", "fall": RED}
"""Colours of symptoms; the others are orange, the first of a fall is red."""
PHASES: Final = {
    "DSL": "#495057",
    "DSR": "#495057",
    "SSL": "#1c7ed6",
    "SSR": "#e8590c",
    "start": "#2b8a3e",
    "stop": "#2b8a3e",
    "stand": "#343a40",
}


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
PHASE_HEIGHT: Final = 14.0
TOLD: Final = 3
"""Signs that are listed under the charts; their room is always kept, so that nothing below moves."""
TOLD_HEIGHT: Final = 12.5
LETTERS: Final = 54
"""Of a line."""
LETTER_HEIGHT: Final = 10.0
"""Two numbers of a scale that are nearer than this would overlap."""


def strip_charts(
    history: History,
    now: float,
    symptoms: Sequence[Symptom] = (),
    first: Symptom | None = None,
    ahead: float = 0.0,
    charts: Sequence[Chart] = CHARTS[:FIRST_CHARTS],
) -> str:
    """All charts of the last seconds, as SVG.

    Args:
        history: The numbers.
        now: The moment whose numbers are written out, robot time, s.
        symptoms: Marked by a line through all charts; the last ones up to `now` are listed.
        first: The one that is to stand out.
        ahead: How much of what comes after `now` is shown, s.
        charts: Which ones.
    """
    end = now + ahead
    rows, phases = history.window(end, WINDOW)
    begin = end - WINDOW
    body, titles, y = [], [], HEAD if first is not None else 0.0
    for chart in charts:
        if chart.lines[0].column == "late" and not np.isfinite(rows[:, COLUMNS.index("late")]).any():
            continue  # a recording has no wall clock
        if chart.lines[0].column == "late":
            missed = int(rows[-1, COLUMNS.index("missed")])
            chart = chart._replace(title=f"{chart.title} · {missed} missed" if missed else chart.title)
        body.append(_chart(chart, rows, begin, y))
        titles.append(_title(chart, rows[: int(np.searchsorted(rows[:, 0], now, side="right"))], y))
        y += GAP + chart.height + 5.0
    body.append(_phases(rows[:, 0], phases, begin, y))
    y += GAP + PHASE_HEIGHT
    if ahead > 0.0:
        x = _x(now, begin)
        body.append(
            f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{HEAD:g}" y2="{y:g}" stroke="#f8f9fa" stroke-width="0.8"/>'
        )
    body.append(_marks(symptoms, first, begin, end, y))
    body.append(f'<g paint-order="stroke" stroke="{BACKGROUND}" stroke-width="3">{"".join(titles)}</g>')
    body.append(_seconds(begin, end, y))
    y += 15.0
    known = sorted((s for s in symptoms if s.time <= now), key=lambda s: s.time)
    body.append(_told(known[-TOLD:], y))
    return _svg("".join(body), y + TOLD * TOLD_HEIGHT + 3.0)


def _svg(body: str, height: float) -> str:
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {height:g}" width="100%" class="charts" style="display: block; '
        f"box-sizing: border-box; padding: 4px 10px 0 0; background: {BACKGROUND}; "
        f'font-family: Inter, sans-serif">{body}</svg>'
    )


def _x(time: float, begin: float) -> float:
    return LEFT + (WIDTH - LEFT) * (time - begin) / WINDOW


def _chart(chart: Chart, rows: Floats, begin: float, top: float) -> str:
    columns = [rows[:, COLUMNS.index(line.column)] for line in chart.lines]
    low, high = _range(chart, columns)
    y_0 = top + GAP
    scale = chart.height / (high - low)
    parts = [_box(y_0, chart.height)]
    for value in (low, high):
        parts.append(_scale(y_0 + (high - value) * scale, value))
    if low < 0.0 < high:
        parts.append(_rule(y_0 + high * scale))
        if min(high, -low) * scale > LETTER_HEIGHT:
            parts.append(_scale(y_0 + high * scale, 0.0))
    for line, values in zip(chart.lines, columns, strict=True):
        for points in _pieces(rows[:, 0], np.clip(values, low, high), line.column == "late"):
            path = " ".join(f"{_x(t, begin):.1f},{y_0 + (high - v) * scale:.1f}" for t, v in points)
            parts.append(f'<polyline points="{path}" fill="none" stroke="{line.colour}" stroke-width="1.3"/>')
    return "".join(parts)


def _range(chart: Chart, columns: Sequence[Floats]) -> tuple[float, float]:
    """The range always shown, widened in steps to what there is, within the bounds."""
    values = np.concatenate(columns)
    values = values[np.isfinite(values)]
    low, high = chart.least
    if len(values):
        step = 0.5 * (high - low)
        low += step * min(math.floor((float(values.min()) - low) / step + 1e-9), 0)
        high += step * max(math.ceil((float(values.max()) - high) / step - 1e-9), 0)
    return max(low, chart.most[0]), min(high, chart.most[1])


def _pieces(times: Floats, values: Floats, peaks: bool) -> list[list[tuple[float, float]]]:
    """The curve in as many points as can be seen, in one piece per run of numbers."""
    stride = max(1, len(times) // BINS)
    pieces: list[list[tuple[float, float]]] = [[]]
    for i in range(0, len(times), stride):
        part = values[i : i + stride]
        value = float(np.nanmax(part)) if peaks and np.isfinite(part).any() else float(part[0])
        if math.isfinite(value):
            pieces[-1].append((float(times[i]), value))
        elif pieces[-1]:
            pieces.append([])
    return [piece for piece in pieces if len(piece) > 1]


def _title(chart: Chart, rows: Floats, top: float) -> str:
    """Name, and the last numbers of some rows."""
    parts = [_text(LEFT, top + 12, chart.title, "#ced4da", weight="600")]
    x = WIDTH - 2.0
    for line in reversed(chart.lines):
        values = rows[:, COLUMNS.index(line.column)]
        known = values[np.isfinite(values)]
        word = f"{line.name} {round(float(known[-1]))}" if len(known) else line.name
        parts.append(_text(x, top + 12, word, line.colour, "end"))
        x -= 5.6 * len(word) + 9.0
    return "".join(parts)


def _phases(times: Floats, phases: Sequence[str], begin: float, top: float) -> str:
    parts = [_text(LEFT, top + 12, "phase", "#ced4da", weight="600")]
    y, start = top + GAP, 0
    for i in range(1, len(phases) + 1):
        if i < len(phases) and phases[i] == phases[start]:
            continue
        x_0, x_1 = _x(float(times[start]), begin), _x(float(times[i - 1]), begin)
        colour = PHASES.get(phases[start], "#212529")
        parts.append(
            f'<rect x="{x_0:.1f}" y="{y:g}" width="{max(x_1 - x_0, 0.5):.1f}" height="{PHASE_HEIGHT:g}" '
            f'fill="{colour}"/>'
        )
        if x_1 - x_0 > 7.0 * len(phases[start]):
            parts.append(_text(0.5 * (x_0 + x_1), y + 10.5, phases[start], "#f8f9fa", "middle"))
        start = i
    return "".join(parts)


def _marks(symptoms: Sequence[Symptom], first: Symptom | None, begin: float, end: float, bottom: float) -> str:
    parts = []
    for symptom in symptoms:
        if not begin <= symptom.time <= end:
            continue
        x = _x(symptom.time, begin)
        is_first = symptom == first
        colour = RED if is_first else MARKS.get(symptom.kind, ORANGE)
        width, dash = (2.2, "") if is_first else (1.0, ' stroke-dasharray="3 3"')
        parts.append(
            f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{HEAD:g}" y2="{bottom:g}" stroke="{colour}" '
            f'stroke-width="{width}"{dash}/>'
        )
        if is_first:
            middle = min(max(x, 0.5 * WIDTH - 30.0), 0.5 * WIDTH + 30.0)
            words = f"first: {symptom.text}, {symptom.time:.2f} s"
            parts.append(_text(middle, HEAD - 5.0, words, "#ff8787", "middle", "700"))
    return "".join(parts)


def _told(symptoms: Sequence[Symptom], top: float) -> str:
    """The last signs as words, the newest at the bottom."""
    parts = []
    for i, symptom in enumerate(symptoms):
        y = top + TOLD_HEIGHT * (i + 1) - 3.0
        text = symptom.text if len(symptom.text) <= LETTERS else symptom.text[: LETTERS - 1] + "…"
        parts.append(_text(LEFT + 38.0, y, f"{symptom.time:.2f} s", MARKS.get(symptom.kind, ORANGE), "end"))
        parts.append(_text(LEFT + 44.0, y, text, "#ced4da"))
    return "".join(parts)


def _seconds(begin: float, end: float, y: float) -> str:
    return "".join(
        _text(_x(t, begin), y + 11, f"{t} s", GREY, "middle")
        for t in range(max(0, math.ceil(begin)), math.floor(end) + 1, 2)
        if _x(t, begin) < WIDTH - 8
    )


def _box(y: float, height: float) -> str:
    return f'<rect x="{LEFT:g}" y="{y:g}" width="{WIDTH - LEFT:g}" height="{height:g}" fill="#141517"/>'


def _scale(y: float, value: float) -> str:
    return _text(LEFT - 3, y + 3.5, f"{value:.0f}", GREY, "end", size=9.5)


def _rule(y: float) -> str:
    return f'<line x1="{LEFT:g}" x2="{WIDTH:g}" y1="{y:.1f}" y2="{y:.1f}" stroke="#495057" stroke-width="0.8"/>'


def _text(
    x: float, y: float, text: str, colour: str, anchor: str = "start", weight: str = "400", size: float = 10.5
) -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size:g}" font-weight="{weight}" fill="{colour}" '
        f'text-anchor="{anchor}">{html.escape(text)}</text>'
    )
