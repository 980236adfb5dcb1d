"""Processes and places of the system tests, and what real time this machine can hold."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from bridge.types import Array
from tests.bare_loop import BareLoop
from tests.loops import TIMEOUT
from tests.ports import free_endpoint, free_port
from tests.system.machine import complaint, engine_cycles

if TYPE_CHECKING:
    from playwright.sync_api import Page

LATENESS: pytest.StashKey[Array] = pytest.StashKey()
"""Of the bare loop beside a real-time test, s."""
REPOSITORY = Path(__file__).parents[2]
INSTALLED = os.environ.get("NAO_HIL_PYTHON")
"""Python of an installed nao-hil that is tested in place of this checkout; `.ci/wheel` gives it."""


class Command:
    """A running `nao-hil` command, its output in files."""

    def __init__(self, arguments: list[str], folder: Path, script: str | None) -> None:
        self.arguments = arguments
        self._out, self._err = folder / "stdout", folder / "stderr"
        start = ["-c", script] if script else ["-m", "nao_hil.cli"]
        with self._out.open("w") as out, self._err.open("w") as err:
            self.process = subprocess.Popen(
                [INSTALLED or sys.executable, *start, *arguments],
                cwd=folder if INSTALLED else REPOSITORY,
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=err,
                start_new_session=True,
            )

    @property
    def stderr(self) -> str:
        return self._err.read_text()

    @property
    def result(self) -> dict[str, Any]:
        result: dict[str, Any] = json.loads(self._out.read_text())
        return result

    def wait(self) -> int:
        return self.process.wait(TIMEOUT)

    def interrupt(self) -> None:
        """Ctrl-C, and its end."""
        self.process.send_signal(signal.SIGINT)
        self.wait()

    def kill(self) -> None:
        self.process.kill()
        self.wait()

    def children(self) -> list[int]:
        path = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        return [int(pid) for pid in path.read_text().split()]

    def children_with(self, word: str) -> list[int]:
        """Child processes with a word in their command line; one that ends meanwhile is none."""
        found = []
        for pid in self.children():
            with contextlib.suppress(OSError):
                if word.encode() in Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0"):
                    found.append(pid)
        return found

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

    begin.commands = started  # type: ignore[attr-defined]
    yield begin
    for command in started:
        command.end()


@pytest.fixture(autouse=True)
def _patient_leases(monkeypatch: pytest.MonkeyPatch) -> None:
    """A controller that the machine starves keeps its robot, where that is one of this process."""
    monkeypatch.setattr("bridge.link.lease.SILENCE_LIMIT", TIMEOUT)


@pytest.fixture
def endpoint() -> str:
    """A Zenoh endpoint on this machine that nobody uses."""
    return free_endpoint()


@pytest.fixture
def far() -> str:
    """Another one, of the bridged robot."""
    return free_endpoint()


@pytest.fixture
def port() -> int:
    """A port of this machine that nobody uses."""
    return free_port()


@pytest.fixture
def errors() -> list[str]:
    """Complaints of the page."""
    return []


@pytest.fixture
def page(errors: list[str]) -> Iterator[Page]:
    """An empty page in a headless browser."""
    from tests.system.pages import browser_page  # imported late: only tests of the page need Playwright

    with browser_page(errors) as opened:
        yield opened


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, Any, None]:
    """A bare loop beside each real-time test."""
    if item.get_closest_marker("realtime") is None:
        yield
        return
    with BareLoop() as loop:
        yield
    item.stash[LATENESS] = loop.lateness


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, None]:
    """A failed real-time test is skipped where the machine could not hold a robot's cycle (`machine.py`)."""
    report = (yield).get_result()
    if report.when == "call" and report.failed:
        for command in getattr(item.funcargs.get("start"), "commands", ()):  # type: ignore[attr-defined]
            report.sections.append((f"errors of {' '.join(command.arguments)}", command.stderr[-2000:]))
        if page := item.funcargs.get("page") or getattr(item.funcargs.get("live"), "page", None):  # type: ignore[attr-defined]
            with contextlib.suppress(Exception):  # it does not answer
                report.sections.append(("texts of the page", page.inner_text("body", timeout=5000)))
    if report.when != "call" or not report.failed or LATENESS not in item.stash:
        return
    reason = complaint(item.stash[LATENESS], engine_cycles())
    if reason:
        print(f"{item.name}: {report.longreprtext}", file=sys.stderr)
        report.outcome = "skipped"
        report.longrepr = str(item.path), 0, f"the machine does not keep real time: {reason}"
