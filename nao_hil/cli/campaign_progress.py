"""How far a campaign is: a bar in a terminal, a line now and then elsewhere."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Final

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

LINE_INTERVAL: Final = 10.0
"""s between lines where there is no terminal to redraw."""


class CampaignProgress:
    """Told by a campaign of its runs.

    Args:
        console: Where to show it.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[note]}"),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._task = self._bar.add_task("", total=0, note="")
        self._expected = self._done = 0
        self._title = ""
        self._next_line = time.monotonic() + LINE_INTERVAL

    def begin(self, title: str) -> None:
        """An experiment begins."""
        self._title, self._expected, self._done = title, 0, 0
        self._bar.reset(self._task, total=0, description=title, note="")

    def expect(self, runs: int) -> None:
        """So many runs more."""
        self._expected += runs
        self._bar.update(self._task, total=self._expected)

    def done(self, name: str, note: str) -> None:
        """One of them is done."""
        self._done += 1
        words = f"{name}: {note}" if note else name
        self._bar.update(self._task, advance=1, note=words)
        if not self._console.is_terminal and time.monotonic() > self._next_line:
            self._next_line = time.monotonic() + LINE_INTERVAL
            self._console.print(
                f"{self._title}: {self._done} of {self._expected} runs; last {words}", highlight=False
            )

    def say(self, text: str) -> None:
        """A sentence for the person who waits."""
        self._console.print(text, highlight=False)

    def __enter__(self) -> CampaignProgress:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()
