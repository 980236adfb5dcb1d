"""Tab of the joints: a table of all, and a plot of one that is chosen."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np

from bridge.body.joints import INDEX, JOINTS
from nao_hil.analysis.diagnosis import Moment
from nao_hil.view.gaps import with_gaps

NONE: Final = "none"
EVERY: Final = 15
"""Pictures from one drawing to the next: twice a second."""
SECONDS: Final = 10.0
"""Of the plot, before the moment shown."""
BELOW: Final = 1e9
"""Order of the table: below the plot."""
HEIGHT: Final = 230
"""Of the plot, pixels."""
ASKED, MEASURED, GREY = "#339af0", "#ff922b", "#868e96"

Value = Callable[[Moment, int], float]


def _asked(moment: Moment, joint: int) -> float:
    """The angle that the newest command asks for, deg; NaN without one."""
    return math.nan if moment.asked is None else math.degrees(moment.asked.position[joint])


def _angle(moment: Moment, joint: int) -> float:
    return math.degrees(moment.sensors.position[joint])


def _current(moment: Moment, joint: int) -> float:
    return moment.sensors.current[joint]


def _temperature(moment: Moment, joint: int) -> float:
    return moment.sensors.temperature[joint]


QUANTITIES: Final[dict[str, tuple[tuple[str, Value, str], ...]]] = {
    "angle, deg": (("asked", _asked, ASKED), ("measured", _angle, MEASURED)),
    "current, A": (("current", _current, MEASURED),),
    "temperature, °C": (("temperature", _temperature, MEASURED),),
}
"""What can be plotted: curves with their names, values and colours."""
COLUMNS: Final = (
    ("asked, deg", _asked, 1),
    ("measured, deg", _angle, 1),
    ("A", _current, 2),
    ("°C", _temperature, 0),
)
"""Of the table, with their decimals."""


class JointView:
    """The tab.

    Args:
        gui: `viser.ViserServer.gui`.
        tabs: The tab group to add it to.
    """

    def __init__(self, gui: Any, tabs: Any) -> None:
        self._gui = gui
        self._count = 0
        self._plot: Any = None
        self._moments: Sequence[Moment] = ()
        with tabs.add_tab("Joints") as tab:
            self.tab = tab
            self._joint = gui.add_dropdown("plot of joint", (NONE, *JOINTS))
            self._quantity = gui.add_dropdown("quantity", tuple(QUANTITIES))
            self._table = gui.add_html("", order=BELOW)
        for choice in (self._joint, self._quantity):
            choice.on_update(lambda _: self._choose())

    def _choose(self) -> None:
        """Another plot."""
        if self._plot is not None:
            self._plot.remove()
            self._plot = None
        if self._moments and self._joint.value != NONE:
            self._draw(self._moments)

    def show(self, moments: Sequence[Moment], now: bool = False) -> None:
        """Draw the last of some moments every so often, or `now`."""
        self._count += 1
        if not moments or (self._count % EVERY != 1 and not now):
            return
        self._moments = moments
        self._table.content = joint_table(moments[-1])
        if self._joint.value != NONE:
            self._draw(moments)

    def _draw(self, moments: Sequence[Moment]) -> None:
        end = moments[-1].sensors.time
        shown = [m for m in moments if m.sensors.time > end - SECONDS]
        curves = QUANTITIES[self._quantity.value]
        joint = INDEX[self._joint.value]
        data = [np.array([m.sensors.time for m in shown])]
        data += [np.array([value(m, joint) for m in shown]) for _, value, _ in curves]
        if self._plot is None:
            series = ({"label": "s"}, *({"label": name, "stroke": c, "width": 1.5} for name, _, c in curves))
            axis = {"stroke": GREY, "grid": {"stroke": "#8884", "width": 1}}
            with self.tab:
                self._plot = self._gui.add_uplot(
                    tuple(data),
                    series,
                    title=f"{self._joint.value}, {self._quantity.value}",
                    scales={"x": {"time": False}},
                    axes=(axis, axis),
                    height=HEIGHT,
                )
        else:
            self._plot.data = with_gaps(data)


def joint_table(moment: Moment) -> str:
    """All joints of a moment as HTML."""
    cell = '<td style="text-align: right; padding: 0 6px">{}</td>'
    head = "".join(cell.format(f"<b>{name}</b>") for name, _, _ in COLUMNS)
    rows = []
    for i, name in enumerate(JOINTS):
        values = [(value(moment, i), decimals) for _, value, decimals in COLUMNS]
        cells = "".join(cell.format("" if math.isnan(v) else f"{v:.{n}f}") for v, n in values)
        rows.append(f"<tr><td>{name}</td>{cells}</tr>")
    style = "font-size: 12px; width: calc(100% - 24px); margin: 0 12px; border-collapse: collapse"
    style += "; font-variant-numeric: tabular-nums"
    return f'<table class="joints" style="{style}"><tr><td></td>{head}</tr>{"".join(rows)}</table>'
