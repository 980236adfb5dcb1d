"""Plays a Choregraphe project: run by `nao-hil run-choregraphe` where programs for NAOqi run.

Arguments: the `.xar` file, the file for the report, seconds without anything running after which it ends.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from bridge.adapters.naoqi.interaction.animations import BEHAVIOUR_EVENT
from bridge.adapters.naoqi.robot_files import ROBOT_HOME
from nao_hil.naoqi_programs.choregraphe.executables import ServiceManager
from nao_hil.naoqi_programs.choregraphe.player import Player
from nao_hil.naoqi_programs.choregraphe.project import behaviours, read_behaviour
from nao_hil.naoqi_programs.choregraphe.scripts import FrameManager, OwnSession, script_globals
from nao_hil.naoqi_programs.loading import load_modules

IDLE: Final = 10.0


def project_of(file: Path) -> Path:
    """Folder of the project that a `.xar` file is in: the nearest with a `.pml`, or the file's own."""
    folder = file.resolve().parent
    return next((place for place in (folder, *folder.parents[:3]) if any(place.glob("*.pml"))), folder)


class BehaviorManager:
    """`ALBehaviorManager` of a robot on which the project is installed; other behaviours are the robot's.

    Args:
        idle: time without anything running after which a behaviour ends, s.
    """

    def __init__(self, player: Player, project: Path, idle: float) -> None:
        self._player, self._idle = player, idle
        files = [file.resolve() for file in behaviours(project)]
        self._files = {str(file.parent.relative_to(project.resolve())): file for file in files}
        self._running: dict[str, Player] = {}
        self.post = _Post(self, player)

    def _own(self, name: str) -> str:
        """The behaviour that is meant, with or without the name of the project before it; or empty."""
        parts = [part for part in str(name).split("/") if part not in ("", ".")]
        return next((own for own in self._files if own in ("/".join(parts), "/".join(parts[1:]))), "")

    def _robot(self) -> Any:
        return self._player.services("ALBehaviorManager")

    def runBehavior(self, name: str, *_: Any) -> None:
        """Play a behaviour to its end."""
        own = self._own(name)
        if not own:
            return self._robot().runBehavior(name)  # type: ignore[no-any-return]
        file = self._files[own]
        running = self._running[own] = self._player.beside(file.parent)
        running.play_to_end(read_behaviour(file), self._idle)
        del self._running[own]
        return None

    def startBehavior(self, name: str) -> None:
        """Play a behaviour without waiting."""
        self.post.runBehavior(name)

    def run_for_text(self, name: str) -> None:
        """Play a behaviour that a dialogue or a spoken text names and the robot does not have."""
        if self._own(name):
            self.runBehavior(name)
        else:
            self._player.cannot(
                f"a text starts the behaviour {name}, which neither the project nor the robot has"
            )

    def stopBehavior(self, name: str) -> None:
        """End a behaviour."""
        running = self._running.get(self._own(name))
        if running is not None:
            running.close()
        elif not self._own(name):
            self._robot().stopBehavior(name)

    def stopAllBehaviors(self) -> None:
        """End all behaviours that this one has started."""
        for running in list(self._running.values()):
            running.close()
        self._robot().stopAllBehaviors()

    def isBehaviorInstalled(self, name: str) -> bool:
        """Whether it can be played."""
        return bool(self._own(name)) or bool(self._robot().isBehaviorInstalled(name))

    isBehaviorPresent = preloadBehavior = isBehaviorInstalled

    def isBehaviorRunning(self, name: str) -> bool:
        """Whether it is played now."""
        return self._own(name) in self._running or bool(self._robot().isBehaviorRunning(name))

    def getInstalledBehaviors(self) -> list[str]:
        """Behaviours of the project."""
        return list(self._files)

    getBehaviorNames = getInstalledBehaviors

    def getRunningBehaviors(self) -> list[str]:
        """Behaviours that are played."""
        return [*self._running, *self._robot().getRunningBehaviors()]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._robot(), name)


class _Post:
    """Its calls without waiting."""

    def __init__(self, manager: BehaviorManager, player: Player) -> None:
        self._manager, self._player = manager, player

    def __getattr__(self, method: str) -> Callable[..., int]:
        def call(*arguments: Any) -> int:
            self._player.start(lambda: getattr(self._manager, method)(*arguments))
            return 0

        return call


def make_player(session: Any, folder: Path, idle: float = IDLE, own: dict[str, Any] | None = None) -> Player:
    """A player of behaviours, the first one in `folder`.

    Args:
        session: qi's.
        idle: time without anything running after which a behaviour ends, s.
        own: services that the player has in the robot's place, by name; `ALFrameManager` is added.
    """
    own = {} if own is None else own
    own["ALFrameManager"] = FrameManager(idle)
    names, register = script_globals(own), import_module("naoqi").register
    return Player(session.service, names, OwnSession(session, own), folder, register)


def home_of(session: Any, other: Path) -> Path:
    """The folder of this machine that is the robot's home; another one, made, where there is none."""
    homes = [ROBOT_HOME]
    with suppress(RuntimeError):  # of qi: a server of others
        homes.append(Path(session.service("NaoHil").home()))
    for home in homes:
        if home.is_dir():
            return home
    other.mkdir(exist_ok=True)
    return other


def play(file: Path, report: Path, idle: float) -> None:
    """Play one behaviour to its end, and list omitted steps."""
    import qi  # late: `BehaviorManager` needs none

    session = qi.Session()
    session.connect(os.environ["NAO_HIL_NAOQI"])
    os.environ["HOME"] = str(home_of(session, report.parent / "home"))  # scripts run on the robot
    folder, project = file.resolve().parent, project_of(file)
    sys.path[0:0] = [str(folder), str(folder.parent)]
    load_modules(old=True)
    own: dict[str, Any] = {}
    player = make_player(session, folder, idle, own)
    run_later = qi.runAsync
    qi.runAsync = lambda *arguments, **options: player.hold(run_later(*arguments, **options))
    own["ALBehaviorManager"] = manager = BehaviorManager(player, project, idle)
    player.subscribe(BEHAVIOUR_EVENT, manager.run_for_text)
    own["ALServiceManager"] = ServiceManager(player, project)
    player.play_to_end(read_behaviour(file), idle)
    report.write_text(json.dumps(player.could_not))


if __name__ == "__main__":
    play(Path(sys.argv[1]), Path(sys.argv[2]), float(sys.argv[3]))
    sys.stdout.flush()
    os._exit(0)  # without waiting for threads of scripts
