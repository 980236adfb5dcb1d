"""The page on a recording, with a timeline."""

from __future__ import annotations

import bisect
import threading
import time
from pathlib import Path
from typing import Any, Final

from nao_hil.view.downloads import add_downloads
from nao_hil.view.follow import RATE
from nao_hil.view.page import JOINT_ROWS, TOP, Page
from nao_hil.view.recorded_run import read_run

SPEEDS: Final = ("0.1", "0.25", "0.5", "1", "2", "4")
AHEAD: Final = 3.0
"""What the charts show of the time after the moment that is drawn, s."""

LINK: Final = (
    '<div style="padding: 0 0.6em 0.6em"><button class="nao-link" style="width: 100%; height: 2.15em; '
    "border: 0; cursor: pointer; font-family: inherit; font-size: 12.25px; color: #fff; "
    'background: var(--mantine-primary-color-filled)">Copy a link to this moment</button></div>'
)
"""Button of `page.js`, which can copy; viser's own cannot."""


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
        self._stop, self._file = stop, file
        self._lock = threading.Lock()
        """A person moves the slider while the film does."""
        self._page = Page(server, file.name)
        self._run = read_run(file)
        self._page.meet(self._run.body)
        self._times = [b.moment.sensors.time for b in self._run.balances]
        if self._run.world is not None:
            self._page.set_world(self._run.world)
        self._build()
        self._page.add_joint_tab()
        self._page.add_view_tab()

    def _build(self) -> None:
        gui, last = self._page.gui, self._times[-1]
        begin = self._times[0]
        self._slider = gui.add_slider("time, s", min=begin, max=last, step=0.01, initial_value=begin, order=TOP)
        self._play = gui.add_button("Pause", order=TOP + 0.1)
        with self._page.tabs.add_tab("Timeline"):
            self._speed = gui.add_dropdown("speed", SPEEDS, initial_value="1")
            jump = gui.add_button("To what went wrong first")
            gui.add_html(LINK)
            add_downloads(gui, lambda: self._file, self._page.say)
        self._at = self._times[0]
        self._playing = True
        self._drawn: float | None = None

        self._slider.on_update(self._moved)
        self._play.on_click(lambda _: self._pressed())
        jump.on_click(lambda _: self._jump())

    def _moved(self, event: Any) -> None:
        if event.client is not None:  # a person, not the film itself
            with self._lock:
                self._playing = False
                self._at = min(max(float(self._slider.value), self._times[0]), self._times[-1])
                self._slider.value = round(self._at, 2)
            self._set_playing(False)

    def _pressed(self) -> None:
        if not self._playing and self._at >= self._times[-1]:
            self._at = self._times[0]
        self._set_playing(not self._playing)

    def _jump(self) -> None:
        """To the first symptom of the fall."""
        if self._run.diagnosis is None:
            self._page.say("The robot did not fall.")
            return
        self._set_playing(False)
        first = self._run.diagnosis.first
        self._at = first.time if first is not None else self._run.diagnosis.fell
        self._slider.value = round(self._at, 2)

    def _set_playing(self, playing: bool) -> None:
        self._playing = playing
        self._play.label = "Pause" if playing else "Play"

    def run(self) -> None:
        """Until `stop` is set."""
        last = time.monotonic()
        while not self._stop.wait(1.0 / RATE):
            now = time.monotonic()
            with self._lock:
                if self._playing and self._page.server.get_clients():
                    self._at += (now - last) * float(self._speed.value)
                    if self._at >= self._times[-1]:
                        self._at = self._times[-1]
                        self._set_playing(False)
                    self._slider.value = round(self._at, 2)
            last = now
            self._show()

    def _show(self) -> None:
        at = self._at  # a person may change it meanwhile
        if at == self._drawn:
            return
        i = max(bisect.bisect_right(self._times, at) - 1, 0)
        diagnosis = self._run.diagnosis if not self._playing or self._fallen(at) else None
        if self._drawn is not None and at < self._drawn:
            self._page.forget()
        still = not self._playing
        run = self._run
        self._page.draw(run.balances[i], run.history, run.symptoms, diagnosis, now=still, ahead=AHEAD)
        before = run.balances[max(0, i - JOINT_ROWS) : i + 1]
        self._page.show_joints([b.moment for b in before], now=still)
        self._drawn = at

    def _fallen(self, at: float) -> bool:
        return self._run.diagnosis is not None and at >= self._run.diagnosis.fell
