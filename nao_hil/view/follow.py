"""The page on a running robot: listens, draws thirty times a second, sends what a button says."""

from __future__ import annotations

import contextlib
import threading
import time
from functools import partial
from pathlib import Path
from typing import Any, Final

from bridge.body import load_body
from bridge.errors import NaoHilError
from bridge.messages import Info, Notice, SensorFrame
from bridge.messages.world import Status
from nao_hil.analysis.diagnosis import MomentBuilder
from nao_hil.runs.demo import CAPTION
from nao_hil.view.controls import Controls
from nao_hil.view.downloads import add_downloads, latest_recording
from nao_hil.view.driving import Driving
from nao_hil.view.hand import Hand
from nao_hil.view.live import Commands, Subscriber
from nao_hil.view.page import Page

RATE: Final = 30.0
"""Pictures per second."""
WATCH_EVERY: Final = 0.5
"""s between questions for what the world is like, and between looks whether a sign of the driver is due."""
ENDING: Final = 1.0
"""s that the last question may take when the page ends."""


class Follower:
    """Shows one robot until it is told to stop.

    Args:
        server: A `viser.ViserServer`.
        robot: Id of the robot.
        connect: Zenoh endpoint of the robot.
        stop: Ends it.
        folder: Of the run, where it is on this machine: its recording can be downloaded.
    """

    def __init__(
        self, server: Any, robot: str, connect: str, stop: threading.Event, folder: Path | None = None
    ) -> None:
        self._robot, self._endpoint, self._folder = robot, connect, folder
        self._hand: Hand | None = None
        self._page = Page(server, f"robot {robot}")
        self._subscriber, self._commands = Subscriber(robot, connect), Commands(robot, connect)
        self._driving = Driving(self._commands.walker, lambda: bool(server.get_clients()))
        self._stop = stop
        self._info: Info | None = None
        self._controls: Controls | None = None
        self._seq = -1
        self._anew = True
        """The robot began anew, perhaps on another terrain."""
        self._watcher: threading.Thread | None = None

    def run(self) -> None:
        """Until `stop` is set.

        Raises:
            ConfigurationError: not an endpoint.
        """
        builder = MomentBuilder()
        due = time.monotonic()
        try:
            while not self._stop.is_set():
                for message in self._subscriber.take():
                    if isinstance(message, SensorFrame) and not self._known(message):
                        continue
                    if isinstance(message, Notice) and message.code == CAPTION:
                        self._page.caption(message.text)
                    if (moment := builder.add(message)) is not None:
                        self._page.take(moment)
                self._page.show()
                due = max(due + 1.0 / RATE, time.monotonic())
                self._stop.wait(due - time.monotonic())
        finally:
            self._subscriber.close()
            if self._hand is not None:
                self._hand.let_go()
            if self._controls is not None:
                with contextlib.suppress(NaoHilError):
                    self._controls.end()
            if self._watcher is not None:
                self._watcher.join(ENDING)
            self._commands.close()

    def _known(self, frame: SensorFrame) -> bool:
        """Whether it is known what robot that is; asks at the first frame, and when it begins anew."""
        anew, self._seq = frame.seq < self._seq, frame.seq
        if self._info is None or anew:
            info = self._commands.info()
            if info is None:
                return self._info is not None
            if self._info is None or info.body != self._info.body:
                self._meet(info)
            self._info = info
            self._anew = True
        return True

    def _meet(self, info: Info) -> None:
        self._page.meet(load_body(info.body))
        if self._info is not None:
            return  # the controls are there
        emulated = info.side == "emulator"
        page, cycle = self._page, load_body(info.body).cycle
        self._controls = controls = Controls(page.gui, self._commands, self._driving, page.say, page.aim, cycle)
        controls.build(page.tabs, world=emulated)
        tab = page.add_joint_tab()
        if emulated:
            page.on_drag(controls.drag)
            body = load_body(info.body)
            self._hand = Hand(page.gui, tab, body, self._robot, self._endpoint, page.say)
        page.add_view_tab()
        if (folder := self._folder) is not None:
            with page.tabs.add_tab("Save"):
                newest, before = partial(latest_recording, folder), partial(latest_recording, folder, 1)
                add_downloads(page.gui, newest, page.say, before)
        self._page.say("answers to the buttons appear here")
        self._watcher = threading.Thread(
            target=self._watch, args=(controls, emulated), name="watch", daemon=True
        )
        self._watcher.start()

    def _watch(self, controls: Controls, emulated: bool) -> None:
        """What waits for answers of the robot, apart from the drawing."""
        while not self._stop.wait(WATCH_EVERY):
            self._driving.sign()
            with contextlib.suppress(NaoHilError):
                controls.show_armed(self._commands.guard().armed)
            with contextlib.suppress(NaoHilError):
                if self._page.walks:
                    controls.show_gait(self._commands.walker().status().gait)
            if not emulated:
                continue
            try:
                world = self._commands.world(Status(terrain=self._anew))
            except NaoHilError:
                continue  # the robot is gone, or gone again
            self._anew = False
            self._page.set_world(world)
