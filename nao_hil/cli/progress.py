"""Progress and end of a run, and progress of a campaign, on the terminal."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console
from rich.live import Live
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

import emulator
from nao_hil.cli.console import open_console
from nao_hil.cli.signals import stop_event
from nao_hil.runs.announcer import CAPTION, WALKER_ENDED
from nao_hil.runs.folder import RunDirectory
from nao_hil.runs.monitor import Monitor

if TYPE_CHECKING:
    from nao_hil.runs.campaign import Campaign

LINE_INTERVAL = 5.0
"""s between lines where there is no terminal to redraw."""
CAMPAIGN_LINE_INTERVAL: Final = 10.0
"""s between lines where there is no terminal to redraw."""


def _compiled_count() -> int:
    """Number of loops of the emulator whose machine code is cached, as the progress of a first start."""
    return sum(1 for _ in Path(emulator.__file__).parent.rglob("*.nbi"))


class WalkProgress:
    """A table that is redrawn in a terminal, a line every few seconds elsewhere."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._live = Live(console=console, auto_refresh=False, transient=True) if console.is_terminal else None
        self._began: tuple[float, float] | None = None
        self._compiled = _compiled_count()
        self._next_line = time.monotonic() + LINE_INTERVAL

    def show(self, monitor: Monitor) -> None:
        """Show the newest messages of the monitor."""
        monitor.connect()
        values = self._values(monitor)
        for notice in monitor.take_notices():
            if notice.code == CAPTION:
                self._console.print(notice.text, style="bold", soft_wrap=True)
            elif not notice.routine and notice.code != WALKER_ENDED:  # `up` prints it itself
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

    def __exit__(self, *_: object) -> None:
        if self._live is not None:
            self._live.stop()


def _table(values: dict[str, str]) -> Table:
    table = Table(title="nao-hil", show_header=False)
    for name, value in values.items():
        table.add_row(name, value)
    return table


class CampaignProgress:
    """Progress of a campaign's runs."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[left]}"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[note]}"),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._task = self._bar.add_task("", total=0, note="", left="left")
        self._expected = self._done = 0
        self._title, self._unit, self._least, self._began = "", "runs", "", time.monotonic()
        self._next_line = time.monotonic() + CAMPAIGN_LINE_INTERVAL

    def begin(self, title: str, *, unit: str = "runs", grows: bool = False) -> None:
        """An experiment begins.

        Args:
            title: Of the progress.
            unit: Of what is counted.
            grows: More may come, by the results: the time left is a lower bound.
        """
        self._title, self._unit, self._least = title, unit, "at least " if grows else ""
        self._expected, self._done, self._began = 0, 0, time.monotonic()
        left = f"left: {self._least}".strip()
        self._bar.reset(self._task, total=0, description=title, note="", left=left)

    def expect(self, runs: int) -> None:
        """So many runs more."""
        if not self._expected:
            self._began = time.monotonic()
        self._expected += runs
        self._bar.update(self._task, total=self._expected)

    def done(self, name: str, note: str) -> None:
        """One of them is done."""
        self._done += 1
        words = f"{name}: {note}" if note else name
        self._bar.update(self._task, advance=1, note=words)
        if not self._console.is_terminal and time.monotonic() > self._next_line:
            self._next_line = time.monotonic() + CAMPAIGN_LINE_INTERVAL
            self._console.print(
                f"{self._title}: {self._done} of {self._expected} {self._unit}, "
                f"{self._least}{self._left()} left{'; last ' if words else ''}{words}"
            )

    def _left(self) -> str:
        """Time that the runs left take at the pace so far, as H:MM:SS."""
        pace = (time.monotonic() - self._began) / self._done
        return str(timedelta(seconds=round(pace * (self._expected - self._done))))

    def say(self, text: str) -> None:
        """A sentence for the person who waits."""
        self._console.print(text)

    def __enter__(self) -> CampaignProgress:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()


@contextmanager
def share_shown(title: str, console: Console) -> Iterator[Callable[[float], None]]:
    """A bar for the share that is done; gives a function that shows a share."""
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda share: bar.update(task, completed=share)


@contextmanager
def running_campaign(
    title: str, directory: RunDirectory | None, cluster: str
) -> Iterator[tuple[Campaign, CampaignProgress]]:
    """A campaign that ends with Ctrl-C, its progress on the terminal.

    Args:
        title: Of the progress.
        directory: Folder of the run, in which walks are kept; None: they are kept nowhere.
        cluster: As `--cluster` has it.
    """
    from nao_hil.runs.campaign import Campaign  # imported late: physics is for those who run one

    folder, stop = None if directory is None else directory.path / "walks", stop_event()
    with (
        CampaignProgress(open_console()) as progress,
        Campaign(folder, cluster=cluster, stop=stop, progress=progress) as campaign,
    ):
        progress.begin(title)
        yield campaign, progress


def conclude(
    summary: dict[str, Any],
    directory: RunDirectory,
    *,
    interrupted: bool,
    target: Sequence[float] = (),
) -> dict[str, Any]:
    """Add the diagnosis, write the summary and show it.

    Args:
        summary: Of the run, with `fell` and `resets`.
        directory: Folder of the run.
        interrupted: A signal ended the run.
        target: Place to walk to, m, m, rad, in the frame of its first pose; empty: none.

    Returns:
        The summary with the diagnosis, and a sentence in `starved` if the run did not keep real time.
    """
    recording = directory.last_recording(summary["resets"])
    summary = {"starved": ""} | summary
    summary["diagnosis"] = _diagnosis(directory, summary["resets"]) if summary["fell"] else None
    directory.write_summary(summary)
    _show(summary, recording, interrupted, target)
    return summary


def _diagnosis(directory: RunDirectory, resets: int) -> str | None:
    """Diagnosis of the last fall, which may have been before a reset."""
    # imported late: most runs end well, and need no SciPy here
    from nao_hil.analysis.diagnosis import diagnose
    from nao_hil.runs.run import load

    for number in range(resets, -1, -1):
        diagnosis = diagnose(load(directory.last_recording(number)))
        if diagnosis is not None:
            return diagnosis.sentence
    return None


def _fell(summary: dict[str, Any]) -> str:
    times = "" if summary["falls"] == 1 else f" {summary['falls']} times"
    resets = f" (over {summary['resets']} resets)" if summary["resets"] else ""
    up = " and got up again" if summary["stands"] and summary["recoveries"] else ""
    return f"The robot fell{times}{resets}{up}"


def _show(summary: dict[str, Any], recording: Path, interrupted: bool, target: Sequence[float]) -> None:
    stands = "The robot stands" if summary["stands"] else "The robot lies or sits"
    ending = _fell(summary) if summary["fell"] else "Interrupted" if interrupted else stands
    table = Table(title=ending, show_header=False)
    table.add_column()
    table.add_column(overflow="fold")
    table.add_row("steps", str(summary["steps"]))
    if summary["fell"] or summary["recoveries"]:
        table.add_row("falls, got up", f"{summary['falls']}, {summary['recoveries']}")
    x, y, turn = summary["displacement"]
    table.add_row("went", f"{x:.3f} m ahead, {y:.3f} m to the left, turned by {math.degrees(turn):.1f} deg")
    if target:
        table.add_row("from its place", f"{math.hypot(target[0] - x, target[1] - y):.3f} m")
    table.add_row("mean speed", f"{summary['speed']:.4f} m/s, start and stop included")
    if any(summary["velocity"]):
        x, y, turn = summary["velocity"]
        table.add_row("mean velocity after 2 s", f"{x:.3f}, {y:.3f} m/s, {turn:.3f} rad/s")
    if summary["torso_max"]:
        table.add_row("largest torso tilt", f"{math.degrees(summary['torso_max']):.2f} deg")
    table.add_row("real-time factor", f"{summary['real_time_factor']:.2f}")
    table.add_row("cycles", f"{summary['cycles']}, {summary['cycles_missed']} missed")
    if calls := summary.get("inference"):
        median, most = 1e3 * calls["p50"], 1e3 * calls["p99"]
        table.add_row("network", f"{calls['count']} calls, {median:.2f} ms (median), {most:.2f} ms (99 %)")
    table.add_row("recording", str(recording))
    console = open_console()
    console.print(table)
    for sentence in (summary["diagnosis"], summary["starved"]):
        if sentence:
            console.print(sentence)
