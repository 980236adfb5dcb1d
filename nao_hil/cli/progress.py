"""What a person sees while the robot walks."""

from __future__ import annotations

import math
import time
from types import TracebackType

from rich.console import Console
from rich.live import Live
from rich.table import Table

from nao_hil.runs.config import RunConfig
from nao_hil.runs.demo import CAPTION
from nao_hil.runs.monitor import Monitor

LINE_INTERVAL = 5.0
"""s between lines where there is no terminal to redraw."""


def _compiled_count() -> int:
    """Loops of the emulator that are compiled; imported late, since the command line loads without numba."""
    from emulator.compiled import compiled_count

    return compiled_count()


class WalkProgress:
    """A table that is redrawn in a terminal, a line every few seconds elsewhere.

    Args:
        settings: of the run.
        console: where to show it.
    """

    def __init__(self, settings: RunConfig, console: Console) -> None:
        self._settings, self._console = settings, console
        self._live = Live(console=console, auto_refresh=False, transient=True) if console.is_terminal else None
        self._began: tuple[float, float] | None = None
        self._compiled = _compiled_count()
        self._next_line = time.monotonic() + LINE_INTERVAL

    def show(self, monitor: Monitor) -> None:
        """Show the newest of what the monitor has heard."""
        monitor.connect()
        values = self._values(monitor)
        for notice in monitor.take_notices():
            if notice.code == CAPTION:
                self._console.print(notice.text, style="bold", highlight=False, soft_wrap=True)
            elif not notice.routine:
                self._console.print(f"the robot says: {notice.text}")
        if self._live is not None:
            self._live.update(_table(values), refresh=True)
        elif time.monotonic() > self._next_line and values:
            self._next_line += LINE_INTERVAL
            self._console.print(", ".join(f"{k} {v}" for k, v in values.items()))

    def _values(self, monitor: Monitor) -> dict[str, str]:
        frame, truth, status, walk = monitor.sensors, monitor.truth, monitor.status, monitor.walk
        if frame is None:
            compiled = _compiled_count() - self._compiled
            first = f"; first start, {compiled} loops compiled so far" if compiled > 0 else ""
            return {"waiting": f"for the robot{first}"}
        if self._began is None or frame.time < self._began[0]:  # a reset begins at 0 again
            self._began = (frame.time, time.monotonic())
        wall = time.monotonic() - self._began[1]
        values = {"time": f"{frame.time:.1f} s"}
        if walk is not None:
            of = f" of {walk.steps}" if walk.steps else ""
            values |= {"state": walk.state, "phase": walk.phase, "step": f"{walk.step}{of}"}
        elif status is not None:
            values["state"] = status.state
        if status is not None:
            values["held by"] = status.holder or "no controller"
        if truth is not None:
            values["distance"] = f"{truth.torso_position[0]:.2f} m"
        roll, pitch = (math.degrees(a) for a in frame.angle)
        values["torso"] = f"roll {roll:+.1f}, pitch {pitch:+.1f} deg"
        if wall > 0.5:
            values["real-time factor"] = f"{(frame.time - self._began[0]) / wall:.2f}"
        values["missed cycles"] = str(frame.missed)
        return values

    def __enter__(self) -> WalkProgress:
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()


def _table(values: dict[str, str]) -> Table:
    table = Table(title="nao-hil", show_header=False)
    for name, value in values.items():
        table.add_row(name, value)
    return table
