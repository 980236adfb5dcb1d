"""Executables of a project: `ALServiceManager` runs the Python programs that its manifest names as services."""

from __future__ import annotations

import marshal
import shlex
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nao_hil.naoqi_programs.choregraphe.project import parsed
from nao_hil.naoqi_programs.loading import command
from nao_hil.naoqi_programs.source import program_code


class Signal:
    """A signal within the process, as qi's."""

    def __init__(self) -> None:
        self._listeners: dict[int, Callable[..., Any]] = {}
        self._number = 0

    def connect(self, listener: Callable[..., Any]) -> int:
        """Call a function at each emission; its number."""
        self._number += 1
        self._listeners[self._number] = listener
        return self._number

    def disconnect(self, number: int) -> None:
        """Call it no more."""
        self._listeners.pop(number, None)

    def emit(self, *values: Any) -> None:
        """Call the functions."""
        for listener in list(self._listeners.values()):
            listener(*values)


class ServiceManager:
    """`ALServiceManager` of the project; a service is named with or without its package before it.

    Args:
        project: folder with `manifest.xml`.
    """

    def __init__(self, player: Any, project: Path) -> None:
        self._player, self._project = player, project
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        self.serviceStopped = Signal()

    def _command(self, name: str) -> list[str]:
        """The program of a service with its arguments; empty if the manifest has none of the name."""
        manifest = self._project / "manifest.xml"
        services: list[ET.Element] = list(parsed(manifest).iter()) if manifest.is_file() else []
        for element in services:
            if element.tag.rpartition("}")[2] == "service" and element.get("name") == name.rpartition(".")[2]:
                words = shlex.split(element.get("execStart", ""))
                program = next((i for i, word in enumerate(words) if word.endswith(".py")), len(words))
                return words[program:]
        return []

    def startService(self, name: str) -> bool:
        """Start a service; false, and noted, if it is no Python program of the project."""
        program, *arguments = self._command(name) or [""]
        path = self._project / program
        if not program or not path.is_file():
            self._player.cannot(
                f"the service {name} was not started: the manifest names no Python program for it"
            )
            return False
        with tempfile.NamedTemporaryFile(prefix="nao-hil-service-", delete=False) as code:
            code.write(marshal.dumps(program_code(path)))
        process = subprocess.Popen(command(code.name, path, arguments), cwd=self._project)
        self._running[name] = process

        def watch() -> None:
            process.wait()
            Path(code.name).unlink()
            self._running.pop(name, None)
            self.serviceStopped.emit(name, "")

        self._player.start(watch)
        return True

    def stopService(self, name: str) -> bool:
        """End a service; whether it ran."""
        process = self._running.get(name)
        if process is not None:
            process.terminate()
        return process is not None

    def isServiceRunning(self, name: str) -> bool:
        """Whether it runs."""
        return name in self._running
