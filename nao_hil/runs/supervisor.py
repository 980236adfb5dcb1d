"""Child processes of `nao-hil up`: started, watched, ended, and their last word read."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any, Final, NamedTuple

SUPERVISED: Final = "NAO_HIL_SUPERVISED"
"""Environment variable of a child: its stdin is open for as long as its parent lives."""


class ChildResult(NamedTuple):
    """The end of a child."""

    code: int
    result: dict[str, Any] | None
    """The JSON object on the last line of its stdout."""
    stderr: str
    """Its stderr."""

    @property
    def error(self) -> str:
        """The sentence it ended with, or its exit code in words."""
        for line in reversed(self.stderr.splitlines()):
            if line.startswith("error: "):
                return line.removeprefix("error: ")
        if self.code < 0:
            return f"it was killed by {signal.Signals(-self.code).name}"
        return f"it ended with exit code {self.code}"


class Child:
    """One `nao-hil` command as a child process, apart from the terminal's Ctrl-C.

    It ends by itself when this process is killed: no robot walks on unwatched.

    Args:
        name: for people, and for its files.
        arguments: of the command.
        folder: of `<name>.out` (its stdout) and `<name>.log` (its stderr).
        place: command that runs it, for one in another network namespace.
    """

    def __init__(self, name: str, arguments: list[str], folder: Path, place: tuple[str, ...] = ()) -> None:
        self.name = name
        self._asked, self._reported = False, 0
        self._out, self._log = folder / f"{name}.out", folder / f"{name}.log"
        with self._out.open("w") as out, self._log.open("w") as log:
            self._process = subprocess.Popen(
                [*place, sys.executable, "-m", "nao_hil.cli", *arguments],
                stdin=subprocess.PIPE,
                env=os.environ | {SUPERVISED: "1"},
                stdout=out,
                stderr=log,
                start_new_session=True,
            )

    @property
    def running(self) -> bool:
        """Whether it has not ended yet."""
        return self._process.poll() is None

    @property
    def pid(self) -> int:
        """Process id of the process."""
        return self._process.pid

    def kill(self) -> None:
        """End it without a warning, as a power cut does."""
        self._process.kill()
        self._process.wait()

    @property
    def stdout(self) -> str:
        """Its stdout so far."""
        return self._out.read_text()

    @property
    def stderr(self) -> str:
        """Its stderr so far."""
        return self._log.read_text()

    def new_lines(self) -> list[str]:
        """Whole lines of its stderr since the last call."""
        text = self.stderr
        begin, self._reported = self._reported, text.rfind("\n") + 1
        return text[begin : self._reported].split("\n")[:-1]

    def ask_to_end(self) -> None:
        """Send it a Ctrl-C, unless it has ended or got one already: a second one would end it in disorder."""
        if self.running and not self._asked:
            self._asked = True
            self._process.send_signal(signal.SIGINT)

    def end(self, grace: float) -> ChildResult:
        """Ask it to end if it has not, wait `grace` s, then kill it."""
        self.ask_to_end()
        try:
            code = self._process.wait(grace)
        except subprocess.TimeoutExpired:
            self._process.kill()
            code = self._process.wait()
        assert self._process.stdin is not None
        self._process.stdin.close()
        return ChildResult(code, _last_json(self._out.read_text()), self._log.read_text())


def _last_json(text: str) -> dict[str, Any] | None:
    for line in reversed(text.splitlines()):
        try:
            value = json.loads(line)
        except ValueError:
            continue
        return value if isinstance(value, dict) else None
    return None
