"""`nao-hil doctor`: properties of this machine that matter to a robot and its controller, and advice."""

from __future__ import annotations

import multiprocessing
import os
import platform
import socket
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from typing import Final, Literal, TypeVar

import msgspec
from rich.table import Table
from rich.text import Text

from bridge.adapters.naoqi import qi_library
from bridge.errors import NaoHilError
from bridge.link.client import link_robots
from bridge.realtime import CONTROLLER_PRIORITY, quiet_process, request_real_time
from emulator.timing import CycleTimer, CycleTimes
from nao_hil.cli.console import Answer

T = TypeVar("T")
Verdict = Literal["good", "warning", "bad"]

OLDEST_PYTHON: Final = (3, 10)
LINK_PORT: Final = 7447
PORTS: Final = {
    LINK_PORT: (
        "of the link",
        "A robot may be running already; end it, or choose another port: --listen tcp/127.0.0.1:7448, and "
        "--connect with the same for the walker.",
    ),
    8080: ("of the page", "Another page or server has it; give `nao-hil view` and `up --view` another --port."),
}
"""Default ports: owner, and advice when one is taken."""
CYCLE: Final = 0.01
CYCLES: Final = 100
MAX_LATENESS: Final = 0.001
"""s; 99 of 100 wake-ups of a quiet machine come sooner after the deadline."""
EXTRAS: Final = {
    "emulator": ("numba", "mujoco", "pybullet"),
    "analysis": ("matplotlib", "psutil"),
    "campaign": ("distributed", "duckdb", "optuna", "pyarrow"),
    "design": ("control", "optuna"),
    "naoqi": ("qi",),
    "view": ("websockets",),
}
"""Optional packages by the extra of nao-hil that brings them."""

NEWEST_PYTHON: Final = {"pybullet": (3, 11), "qi": qi_library.NEWEST_PYTHON}
"""Newest Python of packages that are compiled for some Pythons on x86-64 alone."""

_STYLES: Final[dict[Verdict, str]] = {"good": "green", "warning": "yellow", "bad": "red"}


class Finding(msgspec.Struct, frozen=True, kw_only=True):
    """One thing looked at."""

    name: str
    verdict: Verdict
    value: str
    """The finding."""
    advice: str
    """Its meaning, and advice when it is not good."""


def _judged(
    name: str, value: str, good: bool, advice: str, otherwise: str, bad: Verdict = "warning"
) -> Finding:
    """A finding that is good, or has another advice."""
    return Finding(
        name=name, verdict="good" if good else bad, value=value, advice=advice if good else otherwise
    )


def doctor() -> Answer:
    """Check this machine: cores, timer, permissions, port, packages. Exit code 3: it cannot work.

    Example: nao-hil doctor --json
    """
    findings = diagnose()
    bad = any(f.verdict == "bad" for f in findings)
    return Answer({"healthy": not bad, "findings": findings}, _table(findings), code=3 if bad else 0)


def diagnose() -> list[Finding]:
    """Look at everything; takes a little over a second for the timer."""
    return [
        python_finding(sys.version_info[:3]),
        cores_finding(usable_cores()),
        timer_finding(in_child(measure_timer)),
        real_time_finding(in_child(partial(request_real_time, CONTROLLER_PRIORITY))),
        *(port_finding(port, whose, advice) for port, (whose, advice) in PORTS.items()),
        *(package_finding(extra, name) for extra, names in EXTRAS.items() for name in names),
    ]


def python_finding(found: tuple[int, ...]) -> Finding:
    """Whether this Python is new enough."""
    wanted = ".".join(map(str, OLDEST_PYTHON))
    value = f"{'.'.join(map(str, found))} on {platform.system()} {platform.machine()}"
    otherwise = f"Python {wanted} or newer is needed; install one."
    return _judged("python", value, found >= OLDEST_PYTHON, "New enough.", otherwise, "bad")


def usable_cores() -> int:
    """Cores this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def cores_finding(cores: int) -> Finding:
    """Whether robot and walker have a core each."""
    return _judged(
        "cores",
        str(cores),
        cores >= 2,
        "One for the robot and one for the walker.",
        "Robot and walker share one core; use --mode lockstep, which waits instead of missing cycles.",
    )


def measure_timer() -> CycleTimes:
    """Keep 100 cycles of 10 ms as the robot's process does, at ordinary priority."""
    timer = CycleTimer(CYCLE)
    quiet_process(None)
    timer.restart()
    for _ in range(CYCLES):
        timer.wait()
    return timer.times


def timer_finding(times: CycleTimes | None) -> Finding:
    """How late a 10 ms loop wakes up at ordinary priority."""
    if times is None:
        return Finding(
            name="timer", verdict="warning", value="not measured", advice="No process could be started."
        )
    late = times.lateness
    return _judged(
        "timer",
        f"late by {1e6 * late.p50:.0f} us (p50), {1e6 * late.p99:.0f} us (p99), "
        f"{1e6 * late.max:.0f} us (max), {times.skipped} of {times.cycles + times.skipped} cycles skipped",
        late.p99 <= MAX_LATENESS and times.skipped == 0,
        "A 10 ms cycle keeps time.",
        "Wake-ups come late: end other work here, permit real-time scheduling, or use --mode lockstep.",
    )


def real_time_finding(permitted: bool | None) -> Finding:
    """Whether SCHED_FIFO may be used."""
    return _judged(
        "real-time scheduling",
        "permitted" if permitted else "not permitted",
        bool(permitted),
        "SCHED_FIFO is used for the robot's cycle.",
        "Works without; for punctual cycles on a busy machine set `rtprio 50` for your user in "
        "/etc/security/limits.conf, or give a container the capability SYS_NICE.",
    )


def port_finding(port: int, whose: str, advice: str) -> Finding:
    """Whether a default port can be listened on."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        # As the link itself does: a port of connections that have just ended counts as free.
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError as error:
            value = f"{whose}, cannot be used ({error.strerror}{_robots_at(port) if port == LINK_PORT else ''})"
            return Finding(name=f"port {port}", verdict="warning", value=value, advice=advice)
    return Finding(name=f"port {port}", verdict="good", value=f"{whose}, free", advice="It can be used.")


def _robots_at(port: int) -> str:
    """Clause that lists the robots of a link at a port of this machine; empty: there are none."""
    try:
        names = link_robots(f"tcp/127.0.0.1:{port}", 0.0)
    except NaoHilError:
        return ""
    return f"; robots there: {', '.join(names)}"


def package_finding(extra: str, name: str) -> Finding:
    """Whether an optional package is there."""
    try:
        installed = version(name)
    except PackageNotFoundError:
        newest = NEWEST_PYTHON.get(name, (sys.maxsize,))
        value, remedy = "not installed", f"pip install 'nao-hil[{extra}]' brings it."
        if sys.version_info[:2] > newest or (name in NEWEST_PYTHON and platform.machine() != "x86_64"):
            where = f"Python {'.'.join(map(str, newest))} or older on x86-64"
            value = "not available"
            remedy = f"there is no package of it for this Python and machine: {where} has one."
        advice = f"Only the {extra} needs it; {remedy}"
        return Finding(name=name, verdict="warning", value=value, advice=advice)
    return Finding(name=name, verdict="good", value=installed, advice=f"Used by the {extra}.")


def in_child(work: Callable[[], T]) -> T | None:
    """Result of `work` in a process of its own, so that this one stays as it is; None when there is none."""
    try:
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            return pool.submit(work).result()
    except (OSError, BrokenProcessPool):
        return None


def _table(findings: list[Finding]) -> Table:
    table = Table("", "what", "found", "what it means", title="nao-hil doctor")
    for f in findings:
        table.add_row(Text(f.verdict, _STYLES[f.verdict]), f.name, f.value, f.advice)
    return table
