"""Processes and places of the system tests, and what real time this machine can hold."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import Any

import pytest

REPOSITORY = Path(__file__).parents[2]
TIMEOUT = 120.0
"""s for what takes well under a second on an idle machine."""


class Command:
    """A running `nao-hil` command, its output in files."""

    def __init__(self, arguments: list[str], folder: Path, script: str | None) -> None:
        self._out, self._err = folder / "stdout", folder / "stderr"
        start = ["-c", script] if script else ["-m", "nao_hil.cli"]
        with self._out.open("w") as out, self._err.open("w") as err:
            self.process = subprocess.Popen(
                [sys.executable, *start, *arguments],
                cwd=REPOSITORY,
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=err,
                start_new_session=True,
            )

    @property
    def said(self) -> str:
        return self._err.read_text()

    @property
    def result(self) -> dict[str, Any]:
        result: dict[str, Any] = json.loads(self._out.read_text().splitlines()[-1])
        return result

    def wait(self) -> int:
        return self.process.wait(TIMEOUT)

    def interrupt(self) -> float:
        """Ctrl-C; the time it took to end, s."""
        began = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        self.wait()
        return time.monotonic() - began

    def kill(self) -> None:
        self.process.kill()
        self.wait()

    def children(self) -> list[int]:
        path = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        return [int(pid) for pid in path.read_text().split()]

    def end(self) -> None:
        """Whatever is left of it and of its children."""
        if self.process.poll() is None:
            for pid in self.children():
                os.kill(pid, signal.SIGKILL)
            self.kill()


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., Command]]:
    """Start a command; every process ends with the test."""
    started: list[Command] = []

    def begin(*arguments: str, script: str | None = None) -> Command:
        folder = tmp_path / f"command-{len(started)}"
        folder.mkdir()
        started.append(Command(list(arguments), folder, script))
        return started[-1]

    yield begin
    for command in started:
        command.end()


@pytest.fixture
def endpoint() -> str:
    """A Zenoh endpoint on this machine that nobody uses."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{free.getsockname()[1]}"


def robot_alone(seconds: float = 5.0) -> dict[str, Any]:
    """How an emulated robot keeps real time on this machine with nothing beside it.

    Args:
        seconds: to run it, s.

    Returns:
        `timing` of `nao-hil emulate --json`: cycles, skipped, and the work of a cycle (p50, p99, s).
    """
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable,
            "-m",
            "nao_hil.cli",
            "emulate",
            "--listen",
            address,
            "--out",
            folder,
            "--json",
        ]
        process = subprocess.Popen(
            command, cwd=REPOSITORY, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        time.sleep(seconds + 2.0)  # 2 s to start
        process.send_signal(signal.SIGINT)
        result, _ = process.communicate(timeout=TIMEOUT)
    timing: dict[str, Any] = json.loads(result.splitlines()[-1])["timing"]
    return timing


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, None]:
    """A failed real-time test says nothing of the code where the robot alone cannot keep real time either.

    Measured three times right after the failure. The test is skipped, with the figures, where the robot alone
    skips over 1 % of its cycles, or needs more than half of the cycle time in 1 % of them.
    """
    outcome = yield
    report = outcome.get_result()
    if report.when != "call" or not report.failed or item.get_closest_marker("realtime") is None:
        return
    floor = max((robot_alone() for _ in range(3)), key=lambda timing: timing["work"]["p99"])
    if floor["skipped"] > 0.01 * floor["cycles"] or floor["work"]["p99"] > 0.005:
        figures = (
            f"{floor['skipped']} of {floor['cycles']} cycles skipped, "
            f"{1e3 * floor['work']['p99']:.1f} ms of work in the slowest 1 %"
        )
        print(f"{item.name}: {report.longreprtext}", file=sys.stderr)
        report.outcome = "skipped"
        report.longrepr = str(item.path), 0, f"the robot alone does not keep real time here: {figures}"
