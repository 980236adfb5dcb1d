"""Cost of the live page for the robot's real-time cycle, with a client that draws nothing or a browser."""

from __future__ import annotations

import multiprocessing
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from abc import ABC, abstractmethod
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, Final

from bridge.body import load_body
from bridge.errors import ConfigurationError, LinkError
from bridge.realtime import ROBOT_PRIORITY, quiet_process
from emulator.engine.catalogue import ENGINES
from emulator.robot import EmulatedRobot
from emulator.timing import CycleTimer
from nao_hil.runs.config import RunConfig
from nao_hil.runs.supervisor import Child
from nao_hil.view.child import READY, LivePage
from nao_hil.view.video import CHROMIUM, SOFTWARE
from tests.bench.cycles import bare_cycle
from tests.ports import free_endpoint, free_port

GZIP: Final = b"\x1f\x8b"
"""First bytes of a packed run; other binary messages are rows."""
COUNT: Final = """
(() => {
  let drew = false;
  const draw = WebGL2RenderingContext.prototype.drawArrays;
  WebGL2RenderingContext.prototype.drawArrays = function (...a) { drew = true; return draw.apply(this, a); };
  window.pictures = 0;
  const count = () => { window.pictures += drew; drew = false; requestAnimationFrame(count); };
  count();
})()
"""
"""Counts the pictures that a browser draws, in `window.pictures`."""


class Viewer(ABC):
    """Views a page in a thread of its own, from its creation to `close`."""

    def __init__(self) -> None:
        self.port = free_port()
        self._ready, self._stop = threading.Event(), threading.Event()
        self._rate = 0.0
        self._thread = threading.Thread(target=self._view, daemon=True)

    def open(self, timeout: float) -> None:
        """View the served page and wait until it is shown; `timeout` in s. Raises LinkError."""
        self._thread.start()
        if not self._ready.wait(timeout):
            raise LinkError("the page was not shown.")

    def close(self) -> float:
        """Stop viewing; returns the pictures per second since the page opened."""
        self._stop.set()
        self._thread.join()
        return self._rate

    @abstractmethod
    def _view(self) -> None:
        """View until `_stop`: set `_ready` when the page is shown and, at the end, `_rate`."""


class Receiver(Viewer):
    """Takes everything, draws nothing."""

    def _view(self) -> None:
        from websockets.sync.client import connect
        from websockets.typing import Origin

        own, rows = f"127.0.0.1:{self.port}", 0
        with connect(f"ws://{own}/", origin=Origin(f"http://{own}"), max_size=None, compression=None) as page:
            self._ready.set()
            begin = time.monotonic()
            while not self._stop.is_set():
                try:
                    message = page.recv(timeout=0.1)
                except TimeoutError:
                    continue
                rows += isinstance(message, bytes) and message[:2] != GZIP
            self._rate = rows / (time.monotonic() - begin)


class Browser(Viewer):
    """Headless Chromium that draws in software at 1280 x 800.

    Raises:
        ConfigurationError: there is no Chromium, or no playwright.
    """

    def __init__(self) -> None:
        super().__init__()
        try:
            import playwright  # noqa: F401
        except ModuleNotFoundError:
            raise ConfigurationError("This needs playwright: pip install 'nao-hil[video]'.") from None
        self._path = next((path for name in CHROMIUM if (path := shutil.which(name))), None)
        if self._path is None:
            raise ConfigurationError("This needs Chromium; on Debian or Ubuntu: apt-get install chromium.")

    def _view(self) -> None:
        from playwright.sync_api import sync_playwright

        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=self._path, args=list(SOFTWARE))
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.set_default_timeout(0)  # `open` has one
            page.add_init_script(COUNT)
            page.goto(f"http://127.0.0.1:{self.port}/")
            page.wait_for_selector("body[data-ready=yes]")
            self._ready.set()
            begin, first = time.monotonic(), page.evaluate("window.pictures")
            self._stop.wait()
            self._rate = (page.evaluate("window.pictures") - first) / (time.monotonic() - begin)
            browser.close()


TIMEOUT: Final = 120.0
"""s for each process to start, and for a page to be shown."""
LISTENS: Final = "; recording to"
FOUND: Final = "found:"
LOADING_TIME: Final = 3.0
"""s until the robot walks."""
CASES: Final[dict[str, tuple[type[Viewer] | None, bool]]] = {
    "without": (None, False),
    "page": (Receiver, False),
    "page, one core busy": (Receiver, True),
    "browser": (Browser, False),
}
"""The page's viewer, and whether another process computes all the time."""
BUSY: Final = (sys.executable, "-c", "while True: pass")


def measure(seconds: float = 15.0, rounds: int = 2) -> dict[str, Any]:
    """A walking robot's recording process on each engine, in turn without a page, with one, and with a browser.

    In the cases "page" a client takes the rows and draws nothing, as if a graphics card did that. The
    browser draws in software, next to the robot. The floor is a process that makes the engine's own steps of a
    standing robot at the same pace and priority, and no other process runs.

    Returns:
        Of each engine and case: p50, p99 and max of the lateness, p50 and p99 of a cycle's work, s, the worst
        of the rounds; cycles, and cycles missed, of all rounds; pictures per second, sent or drawn, the fewest.
        Of "engine alone" the work, likewise.

    Raises:
        LinkError: one of the processes failed.
        ConfigurationError: there is no Chromium.
    """
    results: dict[str, Any] = {"seconds": seconds, "rounds": rounds}
    for engine in ENGINES:
        walks: dict[str, list[dict[str, float]]] = {case: [] for case in CASES}
        alone: list[dict[str, float]] = []
        for _ in range(rounds):
            with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
                alone.append(process.submit(_engine_alone, engine, seconds).result())
            for case, (viewer, busy) in CASES.items():
                other = subprocess.Popen(BUSY) if busy else None
                try:
                    walks[case].append(_walk(engine, seconds, viewer() if viewer else None))
                finally:
                    if other is not None:
                        other.kill()
                        other.wait()
        floor = {name: max(each[name] for each in alone) for name in alone[0]}
        results[engine] = {"engine alone": floor} | {case: _together(each) for case, each in walks.items()}
    return results


def _engine_alone(engine: str, seconds: float) -> dict[str, float]:
    """The engine's own steps of a standing robot, cycle by cycle; for a process of its own."""
    config = RunConfig()
    body = load_body(config.robot)
    with EmulatedRobot(body, seed=config.seed, engine=engine) as robot:
        timer = CycleTimer(body.cycle)
        quiet_process(ROBOT_PRIORITY)
        timer.restart()
        for _ in range(round(seconds / body.cycle)):
            timer.wait()
            bare_cycle(robot)
        work = timer.times.work
    return {"work_p50": work.p50, "work_p99": work.p99}


def _walk(engine: str, seconds: float, viewer: Viewer | None) -> dict[str, float]:
    endpoint = free_endpoint()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        emulate = ["emulate", "--engine", engine, "--listen", endpoint, "--out", name, "--json"]
        robot = Child("robot", emulate, folder)
        _wait(robot, LISTENS)
        walker = Child("walker", ["walk", "--connect", endpoint, "--steps", "0"], folder)
        page = LivePage("nao", endpoint, viewer.port, folder) if viewer is not None else None
        if page is not None:
            _wait(page, READY)
        _wait(walker, FOUND)
        time.sleep(LOADING_TIME)
        if viewer is not None:
            viewer.open(TIMEOUT)
        time.sleep(seconds)
        pictures = viewer.close() if viewer is not None else 0.0
        walker.end(5.0)
        outcome = robot.end(5.0)
        if page is not None:
            page.end(5.0)
    if outcome.result is None:
        raise LinkError(f"the robot's process failed: {outcome.error}")
    timing = outcome.result["timing"]
    late: dict[str, float] = {name: timing["lateness"][name] for name in ("p50", "p99", "max")}
    work = {f"work_{name}": timing["work"][name] for name in ("p50", "p99")}
    return (
        late
        | work
        | {"cycles": timing["cycles"], "missed": outcome.result["cycles_missed"], "pictures": pictures}
    )


def _wait(child: Child, word: str) -> None:
    """Wait until the output contains it."""
    deadline = time.monotonic() + TIMEOUT
    while word not in child.stderr:
        if not child.running or time.monotonic() > deadline:
            raise LinkError(f"the {child.name} did not start: {child.end(1.0).error}")
        time.sleep(0.1)


def _together(walks: list[dict[str, float]]) -> dict[str, float]:
    worst = {name: max(walk[name] for walk in walks) for name in ("p50", "p99", "max", "work_p50", "work_p99")}
    sums = {name: sum(walk[name] for walk in walks) for name in ("cycles", "missed")}
    return worst | sums | {"pictures": min(walk["pictures"] for walk in walks)}
