"""Plays a behaviour: its boxes, in threads of their own, the links between them, and events of ALMemory."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache, partial
from pathlib import Path
from types import CodeType
from typing import Any, Final

from nao_hil.naoqi_programs.choregraphe.dialog import DialogBox
from nao_hil.naoqi_programs.choregraphe.project import PARENT, Box
from nao_hil.naoqi_programs.choregraphe.scripts import generated_class
from nao_hil.naoqi_programs.choregraphe.timeline import Timeline
from nao_hil.naoqi_programs.source import compiled

MAX_THREADS: Final = 200
"""Scripts that run at once."""
FORBIDDEN: Final = "the box {name} was not played: {reason}"
_SUBSCRIBES: Final = re.compile(r"""(?:subscribeTo(?:Micro)?Event|subscriber)\(\s*["']([^"']+)""")
"""Events that a script waits for."""
Services = Callable[[str], Any]


class _Worker(threading.Thread):
    """A thread of a player, which counts what runs in it."""


class Player:
    """Plays one behaviour.

    Args:
        services: a service of the robot by its name; raises RuntimeError.
        session: result of `self.session()` in scripts.
    """

    def __init__(
        self,
        services: Services,
        names: dict[str, Any],
        session: Any,
        folder: Path,
        register: Callable[[str, Any], Any],
    ) -> None:
        self.services, self._names, self.session, self.folder = services, names, session, folder
        self._register = register
        self.frames = names["ALFrameManager"]
        self.number: int = self.frames.add(self)
        """The behaviour's, `behaviorId` in its scripts."""
        self.could_not: list[str] = []
        """Omitted steps, one sentence each."""
        self.ended = threading.Event()
        """The outermost box has ended, or the player is stopped."""
        self._lock = threading.Lock()
        self._running = 0
        self._last = time.monotonic()
        self._boxes: list[RunningBox] = []
        self._subscribers: list[Any] = []
        self._threads = set(threading.enumerate())

    @property
    def idle(self) -> float:
        """Time for which nothing has run, s."""
        others = (thread for thread in threading.enumerate() if thread not in self._threads)
        if any(not isinstance(thread, threading._DummyThread | _Worker) for thread in others):
            return 0.0  # of a script; qi's own threads are dummies
        with self._lock:
            return 0.0 if self._running else time.monotonic() - self._last

    def hold(self, pending: Any) -> Any:
        """Count a future of qi as something that runs."""
        with self._lock:
            self._running += 1
        pending.then(lambda _: self._release())
        return pending

    @contextmanager
    def resting(self) -> Iterator[None]:
        """The present work waits for an order, and does not count as something that runs."""
        self._release()
        try:
            yield
        finally:
            with self._lock:
                self._running += 1

    def _release(self) -> None:
        with self._lock:
            self._running -= 1
            self._last = time.monotonic()

    def cannot(self, sentence: str) -> None:
        """Note an omitted step, once."""
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
        _Worker(target=self._run, args=(work,), daemon=True).start()

    def _run(self, work: Callable[[], None]) -> None:
        try:
            work()
        finally:
            self._release()

    def beside(self, folder: Path) -> Player:
        """A player of another behaviour of the project, which notes its omitted steps here."""
        other = Player(self.services, self._names, self.session, folder, self._register)
        other.could_not = self.could_not
        return other

    def play_to_end(self, box: Box, idle: float) -> None:
        """Play, until the box is left or nothing has run for a time, s; boxes that wait are noted."""
        self.play(box)
        self.wait(idle)

    def wait(self, idle: float) -> None:
        """Wait for the end, as `play_to_end`."""
        while not self.ended.wait(0.1) and self.idle < idle:
            pass
        if not self.ended.is_set():
            for sentence in self.waiting():
                self.cannot(f"{sentence}, which did not come within {idle:g} s")
        self.close()

    def play(self, box: Box) -> None:
        """Begin with the outermost box; returns at once."""

        def left(output: str, value: Any) -> None:
            if output == "onStopped":
                self.ended.set()

        running = RunningBox(self, box, left)
        self.start(lambda: running.stimulate("onStart", None))

    def waiting(self) -> Iterator[str]:
        """A sentence for each started box that waits for an event."""
        for running in self._boxes:
            events = [*running.box.events.values(), *_SUBSCRIBES.findall(running.box.script)]
            events += ["words (NaoHil.hear)"] if running.box.dialog else []
            if running.active and events:
                yield f"the box {running.box.name} waits for {' or '.join(dict.fromkeys(events))}"

    def close(self) -> None:
        """End the boxes: their `onUnload` is called, latest first."""
        self.ended.set()
        for running in reversed(self._boxes):
            running.unload()

    def subscribe(self, event: str, told: Callable[[Any], None]) -> None:
        """Call `told` with each new value of an event of ALMemory."""
        subscriber = self.services("ALMemory").subscriber(event)
        subscriber.signal.connect(lambda value: self.start(lambda: told(value)))
        self._subscribers.append(subscriber)

    def script_class(self, running: RunningBox) -> Any:
        """An object of the class in a box's script; None when it has none that runs."""
        name, script = running.box.name, running.box.script
        with self._lock:
            self._boxes.append(running)
            running.module_name = f"{re.sub(r'[^0-9A-Za-z]', '_', name)}__{len(self._boxes)}"
        if running.box.dialog:
            return DialogBox(running)
        if not script:
            return None
        scope = self._names | {"GeneratedClass": generated_class(running)}
        try:
            exec(_code(script), scope)
            if "MyClass" not in scope:
                return None
            made = scope["MyClass"]()
            if "getName" in script:
                self._register(running.module_name, made)
            return made
        except Exception as error:
            self.cannot(FORBIDDEN.format(name=name, reason=f"its script failed ({error})"))
        return None


@lru_cache
def _code(script: str) -> CodeType:
    return compiled(script.encode(), "<box>", old=True)


class RunningBox:
    """A box that the flow has reached.

    Args:
        emit: called with the name and the value of each output.
        parent: box around it; None: it is the outermost.
    """

    def __init__(
        self, player: Player, box: Box, emit: Callable[[str, Any], None], parent: RunningBox | None = None
    ) -> None:
        self.player, self.box, self._emit, self.parent = player, box, emit, parent
        self.module_name = box.name
        self.active = False
        """Started, and not left by `onStopped`."""
        self.timeline: Timeline | None = None
        self._inner: dict[tuple[int, int], RunningBox] = {}
        self._script: Any = None
        self._loaded = self._opened = False
        self._lock = threading.RLock()

    def emit(self, output: str, value: Any = None) -> None:
        """Leave the box through an output."""
        if output == "onStopped":
            self.active = False
        self._emit(output, value)

    def parameter(self, name: str) -> Any:
        """The value of a parameter, perhaps that of the box around this one.

        Raises:
            RuntimeError: there is none.
        """
        if name in self.box.inherited and self.parent is not None and name in self.parent.box.parameters:
            return self.parent.parameter(name)
        if name not in self.box.parameters:
            there = ", ".join(self.box.parameters) or "none"
            raise RuntimeError(f"the box has no parameter {name!r}; it has {there}")
        return self.box.parameters[name]

    def stimulate(self, name: str, value: Any) -> None:
        """An input is stimulated."""
        box = self.box
        if name in box.starts:
            self.active = True
        self.load()
        self._open()
        if self._script is not None:
            self._call(f"onInput_{name}", value)
        if box.timed and name in box.starts:
            self.timeline = self.timeline or Timeline(self)
            self.timeline.play(box.start, name, value)
            return
        loaded = range(len(box.diagrams)) if not box.timed else self.timeline.loaded if self.timeline else ()
        for number in loaded:
            self.follow(number, PARENT, name, value)
        if name in box.stops:
            self._stop()
        elif name in box.starts and self._script is None and not box.diagrams:
            if box.plugin:
                reason = f"the plugin {box.plugin} is not offered"
                self.player.cannot(FORBIDDEN.format(name=box.name, reason=reason))
            if box.plugin or box.script:  # an empty box stays as it is
                self.emit("onStopped")

    def _stop(self) -> None:
        """End the boxes inside; a box without a script of its own is left then."""
        if self.timeline is not None:
            self.timeline.stop()
        for inner in list(self._inner.values()):
            inner._stop()
            inner.unload()
        if self._script is None and self.active:
            self.emit("onStopped")
        self.active = False

    def load(self) -> None:
        """Make the script's object and listen to events, once."""
        with self._lock:
            if self._loaded:
                return
            self._loaded = True
            self._script = self.player.script_class(self)
        if self._script is not None:
            self._call("onLoad", None)
        for name, event in self.box.events.items():
            self.player.subscribe(event, partial(self._notice, name))

    def _open(self) -> None:
        """Load the diagrams but those of a timeline, once: when the box is first stimulated (assumed)."""
        with self._lock:
            opened, self._opened = self._opened, True
        for number in range(len(self.box.diagrams)) if not (opened or self.box.timed) else ():
            self.enter(number)

    def enter(self, number: int) -> None:
        """Load the boxes of a diagram; then its border sends onLoad."""
        for target in self.box.diagrams[number].boxes:
            self._inner_box(number, target).load()
        self.follow(number, PARENT, "onLoad", None)

    def _notice(self, name: str, value: Any) -> None:
        """An event: it counts once the box has started, unless it cannot be started."""
        if self.active or not (self._linked_to_start() or self.parent is None):
            self.stimulate(name, value)

    def _linked_to_start(self) -> bool:
        """Whether a link leads to an input that starts this box."""
        if self.parent is None:
            return False
        for diagram in self.parent.box.diagrams:
            for link in diagram.links:
                target = diagram.boxes.get(link.target)
                if target is self.box and self.box.inputs.get(link.input) in self.box.starts:
                    return True
        return False

    def unload(self) -> None:
        """Call the script's `onUnload`, once."""
        with self._lock:
            script, self._loaded, self._opened = self._script if self._loaded else None, False, False
        if script is not None:
            self._call("onUnload", None)

    def _call(self, method: str, value: Any) -> None:
        """Call a method of the script; when it fails the flow continues behind the box."""
        function = getattr(self._script, method, None)
        if function is None:
            return
        count = function.__code__.co_argcount - 1 if hasattr(function, "__code__") else 0
        try:
            function(*[value][:count])
        except Exception as error:
            self.player.cannot(f"the box {self.box.name} failed in {method}: {str(error) or repr(error)}")
            if method.removeprefix("onInput_") in self.box.starts:
                self.emit("onStopped")

    def follow(self, number: int, source: int, output: str, value: Any) -> None:
        """Stimulate the inputs linked to a box's output; the parent's inputs are outputs here."""
        diagram = self.box.diagrams[number]
        names = self.box.inputs if source == PARENT else diagram.boxes[source].outputs
        for link in diagram.links:
            if link.source != source or names.get(link.output) != output:
                continue
            if link.target == PARENT:
                self.emit(self.box.outputs.get(link.input, ""), value)
            elif link.target in diagram.boxes:
                inner = self._inner_box(number, link.target)
                name = inner.box.inputs.get(link.input, "")
                self.player.start(lambda inner=inner, name=name: inner.stimulate(name, value))  # type: ignore[misc]

    def _inner_box(self, number: int, target: int) -> RunningBox:
        with self._lock:
            if (number, target) not in self._inner:

                def left(output: str, value: Any) -> None:
                    self.follow(number, target, output, value)

                box = self.box.diagrams[number].boxes[target]
                self._inner[number, target] = RunningBox(self.player, box, left, self)
            return self._inner[number, target]
