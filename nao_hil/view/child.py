"""The page as a process next to a run: it never delays the run, and its failure does not end it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

from rich.console import Console

from nao_hil.runs.supervisor import Child

DEFAULT_HOST: Final = "127.0.0.1"
DEFAULT_PORT: Final = 8080
"""TCP port of the page."""
READY: Final = "the page is at"
"""Output of `nao-hil view` before its address."""


class LivePage(Child):
    """`nao-hil view` as a child; its output is reported once.

    Args:
        robot: Id of the robot.
        connect: Zenoh endpoint of the robot.
        port: TCP port of the page.
        folder: Of the run and the page's output.
    """

    def __init__(self, robot: str, connect: str, port: int, folder: Path) -> None:
        view = ["view", "--name", robot, "--connect", connect, "--port", str(port), "--run", str(folder)]
        super().__init__("page", view, folder)
        self._known = False
        """The address is printed, or why there is none."""
        self._restarts = 0

    def restart(self) -> dict[str, str] | None:
        """Settings of another run that a page requested since the last call; None: no request."""
        lines = [json.loads(line) for line in self.stdout.splitlines() if line.startswith('{"restart"')]
        if len(lines) <= self._restarts:
            return None
        self._restarts = len(lines)
        settings: dict[str, str] = lines[-1]["restart"]
        return settings

    def report(self, console: Console) -> None:
        """Print the address once it is served, or the one sentence why it is not."""
        if self._known:
            return
        for line in self.new_lines():
            if line.startswith(READY):
                console.print(line)
                self._known = True
        if not self._known and not self.running:
            console.print(f"no page: {self.end(0.0).error}")
            self._known = True
