"""The page on a recording, with a timeline."""

from __future__ import annotations

import bisect
import threading
import time
from pathlib import Path
from typing import Any, Final

from rich.console import Console
from rich.progress import track

from bridge.errors import ConfigurationError
from bridge.recording.playback import read_recording
from nao_hil.analysis.diagnosis import (
    Balance,
    BalanceEstimator,
    Moment,
    Symptoms,
    explain,
    moments,
    recorded_body,
)
from nao_hil.analysis.diagnosis.symptom import Symptom
from nao_hil.view.follow import RATE
from nao_hil.view.history import History
from nao_hil.view.page import Page
from nao_hil.view.surroundings import recorded_world

SPEEDS: Final = ("0.1", "0.25", "0.5", "1", "2", "4")
AHEAD: Final = 3.0
"""What the charts show of the time after the moment that is drawn, s."""
MOST: Final = 20_000
"""Moments that are kept to be drawn; of a longer recording every second, third, ... one."""


class Film:
    """Shows a recording until it is told to stop.

    Args:
        server: A `viser.ViserServer`.
        file: The recording.
        stop: Ends it.

    Raises:
        ConfigurationError: not a recording, or an empty one.
    """

    def __init__(self, server: Any, file: Path, stop: threading.Event) -> None:
        self._stop = stop
        self._page = Page(server, file.name)
        body = recorded_body(file)
        self._page.meet(body)
        run = first_run(list(moments(read_recording(file))))
        if not run:
            raise ConfigurationError(f"{file}: there is no sensor frame in it; record a robot that runs.")
        self._read(run, BalanceEstimator(body))
        world = recorded_world(file)
        if world is not None:
            self._page.set_world(world)
        self._build()
        self._page.add_view_tab()

    def _read(self, run: list[Moment], observer: BalanceEstimator) -> None:
        """Follow the robot through the whole recording once."""
        watch = Symptoms(observer)
        stride = 1 + len(run) // MOST
        self._history = History(len(run))
        self._balances: list[Balance] = []
        self._symptoms: list[Symptom] = []
        told, off = Console(stderr=True), None
        for i, moment in enumerate(track(run, "reading the recording", console=told, transient=True)):
            balance = observer.update(moment)
            self._symptoms += watch.update(balance)
            self._history.add(balance)
            if i % stride == 0:
                self._balances.append(balance)
            if off is None and self._symptoms and self._symptoms[-1].kind == "fall":
                off = watch.torso_off
        self._times = [b.moment.sensors.time for b in self._balances]
        self._diagnosis = explain(self._symptoms, torso_off=bool(off))
        if self._diagnosis is not None:  # what a fallen robot does is no sign of anything
            fell = self._diagnosis.fell
            self._symptoms = [s for s in self._symptoms if s.time <= fell]

    def _build(self) -> None:
        gui, last = self._page.gui, self._times[-1]
        with self._page.tabs.add_tab("Timeline"):
            self._slider = gui.add_slider(
                "time, s", min=self._times[0], max=last, step=0.01, initial_value=self._times[0]
            )
            self._play = gui.add_button("Pause")
            self._speed = gui.add_dropdown("speed", SPEEDS, initial_value="1")
            jump = gui.add_button("To what went wrong first")
        self._at = self._times[0]
        self._playing = True
        self._drawn: float | None = None

        self._slider.on_update(self._moved)
        self._play.on_click(lambda _: self._pressed())
        jump.on_click(lambda _: self._jump())

    def _moved(self, event: Any) -> None:
        if event.client is not None:  # a person, not the film itself
            self._set_playing(False)
            self._at = float(self._slider.value)

    def _pressed(self) -> None:
        if not self._playing and self._at >= self._times[-1]:
            self._at = self._times[0]
        self._set_playing(not self._playing)

    def _jump(self) -> None:
        """To the first symptom of the fall."""
        if self._diagnosis is None:
            self._page.say("The robot did not fall.")
            return
        self._set_playing(False)
        first = self._diagnosis.first
        self._at = first.time if first is not None else self._diagnosis.fell
        self._slider.value = round(self._at, 2)

    def _set_playing(self, playing: bool) -> None:
        self._playing = playing
        self._play.label = "Pause" if playing else "Play"

    def run(self) -> None:
        """Until `stop` is set."""
        last = time.monotonic()
        while not self._stop.wait(1.0 / RATE):
            now = time.monotonic()
            if self._playing and self._page.server.get_clients():
                self._at += (now - last) * float(self._speed.value)
                if self._at >= self._times[-1]:
                    self._at = self._times[-1]
                    self._set_playing(False)
                self._slider.value = round(self._at, 2)
            last = now
            self._show()

    def _show(self) -> None:
        if self._at == self._drawn:
            return
        i = max(bisect.bisect_right(self._times, self._at) - 1, 0)
        diagnosis = self._diagnosis if not self._playing or self._fallen() else None
        if self._drawn is not None and self._at < self._drawn:
            self._page.forget()
        still = not self._playing
        self._page.draw(self._balances[i], self._history, self._symptoms, diagnosis, now=still, ahead=AHEAD)
        self._drawn = self._at

    def _fallen(self) -> bool:
        return self._diagnosis is not None and self._at >= self._diagnosis.fell


def first_run(recorded: list[Moment]) -> list[Moment]:
    """The moments before the robot began anew: a timeline has one run."""
    for i in range(1, len(recorded)):
        if recorded[i].sensors.seq <= recorded[i - 1].sensors.seq:
            return recorded[:i]
    return recorded
