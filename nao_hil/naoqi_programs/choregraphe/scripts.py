"""The vendor's runtime for the script of a box, as far as boxes of its library use it."""

from __future__ import annotations

import contextlib
import logging
import os
import time
from importlib import import_module
from pathlib import Path
from typing import Any, Final, Protocol

import qi

from nao_hil.naoqi_programs.choregraphe.project import Box
from nao_hil.naoqi_programs.choregraphe.timeline import Timeline

_GLOBAL_PROXIES: Final = ("ALMemory", "ALMotion", "ALLeds", "ALLogger", "ALSensors")
"""Proxies that every script has."""
_RESOURCES: Final = ("waitResources", "waitForResources", "waitResourcesFree", "releaseResource", "tryAcquire")
"""Methods of a box's resources, which are always free."""


class ScriptedBox(Protocol):
    """The box of a script."""

    player: Any
    box: Box
    parent: Any
    timeline: Timeline | None
    module_name: str

    def emit(self, output: str, value: Any = None) -> None:
        """Leave the box through an output."""

    def parameter(self, name: str) -> Any:
        """The value of a parameter."""


def script_globals(folder: Path) -> dict[str, Any]:
    """Names that every script of a project finds.

    Args:
        folder: of the behaviour, where its resources are.
    """
    vendor: Any = import_module("naoqi")  # of `nao_hil.naoqi_programs.modules`, where the runner finds it
    frames, real = FrameManager(folder), vendor.ALProxy

    def proxy(kind: Any, name: str, *_: Any) -> Any:
        """A proxy; that of ALFrameManager is the player's own."""
        return frames if name == "ALFrameManager" else real.__new__(kind)

    vendor.ALProxy = type("ALProxy", (real,), {"__new__": proxy})
    names = {name: getattr(vendor, name) for name in ("ALBehavior", "ALBroker", "ALModule", "ALProxy")}
    for name in _GLOBAL_PROXIES:
        with contextlib.suppress(RuntimeError):  # a service that this robot does not have
            names[name] = vendor.ALProxy(name)
    return names | {"ALFrameManager": frames, "qi": qi, "time": time, "os": os}


class FrameManager:
    """`ALFrameManager` of the behaviour that is played.

    Args:
        folder: of the behaviour.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def getBehaviorPath(self, _: Any = None) -> str:
        """Folder of a behaviour, with a slash at its end."""
        return f"{self._folder.resolve()}/"

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        raise RuntimeError(f"ALFrameManager.{name} is not offered: getBehaviorPath is.")


def generated_class(running: ScriptedBox) -> type:
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
        "behaviorId": 0,
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


def _timeline_methods(running: ScriptedBox) -> dict[str, Any]:
    """Methods that play the box's own timeline, and the one that the box is in (`...Parent`)."""

    def go_to(whose: str, frame: Any, *, plays: bool) -> None:
        """Move a timeline on."""
        box = running.parent if whose else running
        if box is None or box.timeline is None:
            running.player.cannot(f"the box {running.box.name} has no timeline to move on")
        else:
            box.timeline.go_to(None if frame is None else float(frame), plays=plays)

    methods: dict[str, Any] = {}
    for whose in ("", "Parent"):
        methods |= {
            f"playTimeline{whose}": lambda _, whose=whose: go_to(whose, None, plays=True),
            f"stopTimeline{whose}": lambda _, whose=whose: go_to(whose, None, plays=False),
            f"gotoAndPlay{whose}": lambda _, frame, whose=whose: go_to(whose, frame, plays=True),
            f"gotoAndStop{whose}": lambda _, frame, whose=whose: go_to(whose, frame, plays=False),
            f"exitBehavior{whose}": lambda _: running.player.ended.set(),
        }
    return methods
