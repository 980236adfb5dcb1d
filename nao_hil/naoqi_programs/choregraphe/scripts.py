"""The vendor's runtime for the script of a box, as far as boxes of its library use it."""

from __future__ import annotations

import contextlib
import logging
import time
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from bridge.errors import NaoHilError
from nao_hil.naoqi_programs.choregraphe.project import Box, LiveBox, read_behaviour

_GLOBAL_PROXIES: Final = ("ALMemory", "ALMotion", "ALLeds", "ALLogger", "ALSensors")
"""Proxies that every script has."""
_RESOURCES: Final = ("waitResources", "waitForResources", "waitResourcesFree", "releaseResource", "tryAcquire")
"""Methods of a box's resources, which are always free."""


def script_globals(own: dict[str, Any]) -> dict[str, Any]:
    """Names that every script of a project finds.

    Args:
        own: services that the player has in the robot's place, by name.
    """
    vendor: Any = import_module("naoqi")  # of `nao_hil.naoqi_programs.modules`, where the runner finds it
    real = vendor.ALProxy

    def proxy(kind: Any, name: str, *_: Any) -> Any:
        """A proxy, or the player's own service."""
        return own[name] if name in own else real.__new__(kind)

    vendor.ALProxy = type("ALProxy", (real,), {"__new__": proxy})
    names = {name: getattr(vendor, name) for name in vendor.__all__}
    for name in _GLOBAL_PROXIES:
        with contextlib.suppress(RuntimeError):  # a service that this robot does not have
            names[name] = vendor.ALProxy(name)
    return names | {"ALFrameManager": own["ALFrameManager"], "time": time}


class OwnSession:
    """A session with the player's own services.

    Args:
        session: qi's.
        own: services that the player has in the robot's place, by name.
    """

    def __init__(self, session: Any, own: dict[str, Any]) -> None:
        self._session, self._own = session, own

    def service(self, name: str) -> Any:
        """A service of the player or of the robot."""
        return self._own[name] if name in self._own else self._session.service(name)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._session, name)


class FrameManager:
    """`ALFrameManager`: the behaviours that are played, by their numbers.

    Args:
        idle: time without anything running after which a behaviour ends, s.
    """

    def __init__(self, idle: float) -> None:
        self._idle = idle
        self._players: list[Any] = []
        self._boxes: dict[int, Box] = {}
        """Outermost boxes of behaviours from files."""

    def add(self, player: Any) -> int:
        """Number of one more behaviour by its player."""
        self._players.append(player)
        return len(self._players) - 1

    def _of(self, number: Any) -> Any:
        if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < len(self._players):
            raise RuntimeError(
                f"ALFrameManager: {number!r:.40} is no behaviour; newBehaviorFromFile returns its number."
            )
        return self._players[number]

    def getBehaviorPath(self, number: int = 0) -> str:
        """Folder of a behaviour, with a slash at its end."""
        return f"{self._of(number).folder.resolve()}/"

    def newBehaviorFromFile(self, file: str, *_: Any) -> int:
        """Read the behaviour of a .xar file; its number."""
        path = Path(file)
        try:
            box = read_behaviour(path)
        except NaoHilError as error:
            raise RuntimeError(f"ALFrameManager.newBehaviorFromFile: {error}") from None
        number: int = self._players[0].beside(path.parent).number
        self._boxes[number] = box
        return number

    def playBehavior(self, number: int) -> None:
        """Begin a behaviour."""
        player = self._of(number)
        if number in self._boxes:
            player.play(self._boxes.pop(number))

    def completeBehavior(self, number: int) -> None:
        """Begin a behaviour, unless it has begun, and wait for its end."""
        self.playBehavior(number)
        self._of(number).wait(self._idle)

    def exitBehavior(self, number: int) -> None:
        """End a behaviour."""
        self._of(number).close()

    deleteBehavior = exitBehavior

    def cleanBehaviors(self) -> None:
        """End all behaviours from files."""
        for player in self._players[1:]:
            player.close()

    def getMethodList(self) -> list[str]:
        """As of every service."""
        return sorted(name for name in dir(type(self)) if name[0] != "_" and name != "add")

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        offered = ", ".join(self.getMethodList())
        raise RuntimeError(f"ALFrameManager.{name} is not offered: {offered} are.")


def generated_class(running: LiveBox) -> type:
    """The class that a script's `MyClass` derives from."""
    box, player = running.box, running.player

    def get_parameter(_: Any, name: str) -> Any:
        return running.parameter(str(name))

    def set_parameter(_: Any, name: str, value: Any) -> None:
        box.parameters[str(name)] = value

    members: dict[str, Any] = {
        "__init__": lambda self, *_: None,
        "getParameter": get_parameter,
        "setParameter": set_parameter,
        "log": lambda _, message: print(f"{box.name}: {message}", flush=True),
        "logger": _logger(box.name),
        "session": lambda _: player.session,
        "getName": lambda _: running.module_name,
        "BIND_PYTHON": lambda *_: None,
        "boxName": box.name,
        "behaviorId": player.number,
        "resource": False,
        "behaviorAbsolutePath": lambda _: str(player.folder.resolve()),
        "packageUid": lambda _: player.folder.name,
        "stopped": False,
        "tr": lambda _, text, *__: text,
    }
    members |= {name: lambda *_: True for name in _RESOURCES}
    members |= _timeline_methods(running)
    for output in box.outputs.values():
        members[output] = lambda _, *value, output=output: running.emit(output, value[0] if value else None)
    return type("GeneratedClass", (), members)


def _logger(name: str) -> Any:
    """A box's logger, whose messages are printed as those of `log`."""
    logger = logging.getLogger(f"box.{name}")
    logger.setLevel(logging.DEBUG)
    if not logger.handlers:
        handler = logging.StreamHandler()
        handler.setFormatter(logging.Formatter("%(levelname)s %(name)s: %(message)s"))
        logger.addHandler(handler)
    return logger


class TimelineOfScript:
    """`self.getTimeline()` and `self.getParentTimeline()`.

    Args:
        running: the script's box.
        box: the one whose timeline it is, or None.
    """

    def __init__(self, running: LiveBox, box: LiveBox | None) -> None:
        self._running, self._box = running, box

    def go_to(self, frame: Any = None, plays: bool | None = None) -> None:
        """As `Timeline.go_to`; noted where there is none."""
        if self._box is None or self._box.timeline is None:
            self._running.player.cannot(f"the box {self._running.box.name} has no timeline to move on")
        else:
            self._box.timeline.go_to(frame, plays)

    def play(self) -> None:
        """Play on."""
        self.go_to(plays=True)

    def pause(self) -> None:
        """Rest at the present frame."""
        self.go_to(plays=False)

    def stop(self) -> None:
        """Rest at the first frame."""
        self.go_to(self._box.box.start if self._box else None, plays=False)

    def goTo(self, frame: Any) -> None:
        """Go to a frame, a number or a name."""
        self.go_to(frame)


def _timeline_methods(running: LiveBox) -> dict[str, Any]:
    """Methods that play the box's own timeline, and the one around it (`...Parent`)."""
    around = running.parent
    while around is not None and not around.box.timed and around.parent is not None:
        around = around.parent
    methods: dict[str, Any] = {}
    for whose, timeline in (
        ("", TimelineOfScript(running, running)),
        ("Parent", TimelineOfScript(running, around)),
    ):
        methods |= {
            f"get{whose}Timeline": lambda _, of=timeline: of,
            f"playTimeline{whose}": lambda _, of=timeline: of.play(),
            f"stopTimeline{whose}": lambda _, of=timeline: of.pause(),
            f"gotoAndPlay{whose}": lambda _, frame, of=timeline: of.go_to(frame, True),
            f"gotoAndStop{whose}": lambda _, frame, of=timeline: of.go_to(frame, False),
            f"exitBehavior{whose}": lambda _: running.player.ended.set(),
        }
    return methods
