"""Plays a behaviour: scripts of boxes in threads of their own, timelines along the wall clock.

What the vendor's runtime offers scripts, as far as boxes of its library use it: `GeneratedClass` with the
outputs as methods, `getParameter`, `log`, `logger` and `session`; `ALProxy` and `qi`.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable
from typing import Any, Final

from nao_hil.naoqi_programs.choregraphe.project import PARENT, Box, Diagram
from nao_hil.naoqi_programs.source import compiled

MAX_THREADS: Final = 200
"""Scripts that run at once."""
FORBIDDEN: Final = "the box {name} was not played: {reason}"
Services = Callable[[str], Any]


class Player:
    """Plays one behaviour.

    Args:
        services: a service of the robot by its name; raises RuntimeError.
        modules: what scripts find as globals.
        session: what `self.session()` gives scripts.
    """

    def __init__(self, services: Services, modules: dict[str, Any], session: Any) -> None:
        self._services, self._modules, self.session = services, modules, session
        self.could_not: list[str] = []
        """What was not done, one sentence each."""
        self.ended = threading.Event()
        """The outermost box was left, or the player was stopped."""
        self._lock = threading.Lock()
        self._running = 0
        self._last = time.monotonic()

    @property
    def idle(self) -> float:
        """Time for which nothing has run, s."""
        with self._lock:
            return 0.0 if self._running else time.monotonic() - self._last

    def cannot(self, sentence: str) -> None:
        """Note what was not done, once."""
        with self._lock:
            if sentence not in self.could_not:
                self.could_not.append(sentence)

    def start(self, work: Callable[[], None]) -> None:
        """Run something in a thread of its own, unless the player has ended."""
        with self._lock:
            if self.ended.is_set():
                return
            if self._running >= MAX_THREADS:
                full = f"more than {MAX_THREADS} boxes ran at once; the others were left out"
                if full not in self.could_not:
                    self.could_not.append(full)
                return
            self._running += 1
        threading.Thread(target=self._run, args=(work,), daemon=True).start()

    def _run(self, work: Callable[[], None]) -> None:
        try:
            work()
        finally:
            with self._lock:
                self._running -= 1
                self._last = time.monotonic()

    def play(self, box: Box) -> None:
        """Begin with the outermost box; returns at once."""

        def left(output: str, value: Any) -> None:
            if output == "onStopped":
                self.ended.set()

        running = RunningBox(self, box, left)
        self.start(lambda: running.stimulate("onStart", None))

    def move(self, box: Box) -> float:
        """Send the joints along a timeline's curves, and return how long they take, s."""
        end = max(curve.frames[-1] for curve in box.curves) / box.fps
        known = set(self._services("ALMotion").getBodyNames("Body"))
        for curve in box.curves:
            if curve.actuator not in known:
                self.cannot(f"the timeline of {box.name}: this robot has no {curve.actuator}")
        curves = [curve for curve in box.curves if curve.actuator in known]
        if not curves:
            return end
        values = [[_angle(c.actuator, value) for value in c.values] for c in curves]
        times = [[max(0.04, frame / box.fps) for frame in c.frames] for c in curves]
        self._services("ALMotion").angleInterpolation([c.actuator for c in curves], values, times, True)
        return end

    def script_class(self, box: RunningBox) -> Any:
        """An object of the class in a box's script; None when it has none that runs."""
        name = box.box.name
        if "MyClass" not in box.box.script:
            return None
        scope = dict(self._modules) | {"GeneratedClass": _generated(box)}
        try:
            exec(compiled(box.box.script.encode(), f"<box {name}>"), scope)
            return scope["MyClass"]()
        except Exception as error:
            self.cannot(FORBIDDEN.format(name=name, reason=f"its script failed ({error})"))
        return None


class RunningBox:
    """A box that was reached.

    Args:
        player: plays it.
        box: what it is.
        emit: told of each output by name, with its value.
    """

    def __init__(self, player: Player, box: Box, emit: Callable[[str, Any], None]) -> None:
        self.player, self.box, self._emit = player, box, emit
        self._inner: dict[tuple[int, int], RunningBox] = {}
        self._script: Any = None
        self._loaded = False
        self._lock = threading.Lock()

    def emit(self, output: str, value: Any = None) -> None:
        """Leave the box through an output."""
        self._emit(output, value)

    def stimulate(self, name: str, value: Any) -> None:
        """An input is stimulated."""
        box = self.box
        self._load()
        if self._script is not None:
            self._call(f"onInput_{name}", value)
        for number, diagram in enumerate(box.diagrams):
            if not (box.timed and name == "onStart" and diagram.frame > 1):
                self._follow(number, diagram, PARENT, name, value)
        if box.timed and name == "onStart":
            self._play_timeline()
        elif name == "onStart" and self._script is None and not box.diagrams:
            if box.plugin or "MyClass" not in box.script:
                reason = f"the plugin {box.plugin} is not offered" if box.plugin else "it has no script"
                self.player.cannot(FORBIDDEN.format(name=box.name, reason=reason))
            self.emit("onStopped")

    def _load(self) -> None:
        with self._lock:
            if self._loaded:
                return
            self._loaded = True
            self._script = self.player.script_class(self)
        if self._script is not None:
            self._call("onLoad", None)

    def _call(self, method: str, value: Any) -> None:
        """Call a method of the script; when it fails the flow goes on behind the box."""
        function = getattr(self._script, method, None)
        if function is None:
            return
        count = function.__code__.co_argcount - 1 if hasattr(function, "__code__") else 0
        try:
            function(*[value][:count])
        except Exception as error:
            self.player.cannot(f"the box {self.box.name} failed in {method}: {str(error) or repr(error)}")
            if method == "onInput_onStart":
                self.emit("onStopped")

    def _play_timeline(self) -> None:
        """Curves and the diagrams at their frames; the box is left at the end."""
        began, end = time.monotonic(), 0.0
        if self.box.curves:
            ended = threading.Event()

            def move() -> None:
                try:
                    self.player.move(self.box)
                except Exception as error:
                    self.player.cannot(f"the timeline of {self.box.name}: {error}")
                ended.set()

            self.player.start(move)
        for number, diagram in sorted(enumerate(self.box.diagrams), key=lambda item: item[1].frame):
            if diagram.frame > 1:
                self.player.ended.wait(max(0.0, began + diagram.frame / self.box.fps - time.monotonic()))
                self._follow(number, diagram, PARENT, "onStart", None)
        if self.box.curves:
            end = max(curve.frames[-1] for curve in self.box.curves) / self.box.fps
            while not ended.wait(0.05) and not self.player.ended.is_set():
                pass
        self.player.ended.wait(max(0.0, began + end - time.monotonic()))
        self.emit("onStopped")

    def _follow(self, number: int, diagram: Diagram, source: int, output: str, value: Any) -> None:
        """Stimulate what a box's output is linked to; of the parent its inputs are the outputs here."""
        names = self.box.inputs if source == PARENT else diagram.boxes[source].outputs
        for link in diagram.links:
            if link.source != source or names.get(link.output) != output:
                continue
            if link.target == PARENT:
                self.emit(self.box.outputs.get(link.input, ""), value)
            elif link.target in diagram.boxes:
                inner = self._inner_box(number, diagram, link.target)
                name = inner.box.inputs.get(link.input, "")
                self.player.start(lambda inner=inner, name=name: inner.stimulate(name, value))  # type: ignore[misc]

    def _inner_box(self, number: int, diagram: Diagram, target: int) -> RunningBox:
        with self._lock:
            if (number, target) not in self._inner:

                def left(output: str, value: Any) -> None:
                    self._follow(number, diagram, target, output, value)

                self._inner[number, target] = RunningBox(self.player, diagram.boxes[target], left)
            return self._inner[number, target]


def _angle(actuator: str, value: float) -> float:
    """A key's value for ALMotion: rad, or 0 to 1 of a hand, whose keys may be percent (assumed)."""
    if actuator.endswith("Hand"):
        return value / 100.0 if value > 1.0 else value
    return math.radians(value)


def _generated(running: RunningBox) -> type:
    """The class that a script's `MyClass` derives from."""
    box = running.box

    def get_parameter(_: Any, name: str) -> Any:
        if name not in box.parameters:
            raise RuntimeError(
                f"the box has no parameter {name!r}; it has {', '.join(box.parameters) or 'none'}"
            )
        return box.parameters[name]

    def set_parameter(_: Any, name: str, value: Any) -> None:
        box.parameters[name] = value

    members: dict[str, Any] = {
        "__init__": lambda self, *_: None,
        "getParameter": get_parameter,
        "setParameter": set_parameter,
        "log": lambda _, message: print(f"{box.name}: {message}", flush=True),
        "logger": logging.getLogger(box.name),
        "session": lambda _: running.player.session,
        "getName": lambda _: box.name,
        "behaviorId": 0,
    }
    for output in box.outputs.values():
        members[output] = lambda _, *value, output=output: running.emit(output, value[0] if value else None)
    return type("GeneratedClass", (), members)
