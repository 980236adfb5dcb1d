"""Sliders for the joints of an emulated robot that no controller holds: the page takes its lease meanwhile."""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, JOINTS
from bridge.errors import NaoHilError
from nao_hil.connection import connect

SPEED: Final = 1.0
"""At which a joint goes where its slider is, rad/s."""
STEP: Final = 0.5
"""Of a slider, deg."""
WAIT: Final = 3.0
"""s for a robot to answer."""


class Hand:
    """The sliders.

    Args:
        gui: `viser.ViserServer.gui`.
        tab: Of the joints.
        body: Whose ranges they have.
        robot: Id of the robot.
        endpoint: Zenoh endpoint of the robot.
        say: Told what came of it.
    """

    def __init__(
        self, gui: Any, tab: Any, body: Body, robot: str, endpoint: str, say: Callable[[str], None]
    ) -> None:
        self._body, self._robot, self._endpoint, self._say = body, robot, endpoint, say
        self._end: threading.Event | None = None
        self._wanted = np.zeros(len(JOINTS))
        self._sliders: dict[str, Any] = {}
        with tab:
            hint = "of a robot that hangs, sits or lies: nao-hil emulate --start hang"
            self._take = gui.add_button("Take the joints", hint=hint)
            self._folder = gui.add_folder("Joints, deg", visible=False)
        with self._folder:
            for name in (name for name in JOINTS if name in body.joints):
                joint = body.joints[name]
                low, high = (math.degrees(limit) / STEP for limit in (joint.lower, joint.upper))
                low, high = STEP * math.ceil(low), STEP * math.floor(high)  # shown as they are
                rest = min(max(0.0, low), high)
                slider = gui.add_slider(name, min=low, max=high, step=STEP, initial_value=rest)
                slider.on_update(lambda event, name=name: self._moved(event, name))
                self._sliders[name] = slider
        self._take.on_click(lambda _: self.let_go() if self._end else self._begin())

    def _moved(self, event: Any, name: str) -> None:
        if event.client is not None:  # a person
            self._wanted[INDEX[name]] = math.radians(self._sliders[name].value)

    def _begin(self) -> None:
        self._end = threading.Event()
        threading.Thread(target=self._hold, args=(self._end,), name="hand", daemon=True).start()

    def let_go(self) -> None:
        """Give the robot back."""
        if self._end is not None:
            self._end.set()

    def _hold(self, end: threading.Event) -> None:
        try:
            with connect(self._endpoint, robot=self._robot, name="page", timeout=WAIT) as robot:
                target = np.array(robot.frame.position)
                self._wanted[:] = target
                for name, slider in self._sliders.items():
                    slider.value = STEP * round(math.degrees(target[INDEX[name]]) / STEP)
                self._show(True)
                step = SPEED * self._body.cycle
                while not end.is_set():
                    target += np.clip(self._wanted - target, -step, step)
                    robot.step(target)
        except NaoHilError as error:
            self._say(str(error))
        self._end = None
        with contextlib.suppress(RuntimeError):  # the page has ended
            self._show(False)

    def _show(self, holds: bool) -> None:
        self._folder.visible = holds
        self._take.label = "Give the joints back" if holds else "Take the joints"
        if holds:
            self._say("The page holds the robot; its joints go where the sliders are.")
